"""Linear estimators of the second level: the fit itself and others that should agree with it, with their errors."""

from dataclasses import dataclass

import numpy as np

from narrows.identification.uncertainty.error_model import pseudo_inverse


@dataclass(frozen=True)
class LinearEstimator:
    """``theta = P Z'y``, with P the inverse of Z'D.

    Parameters
    ----------
    z : array (blocks, q, p)
        Instruments: the columns themselves, what is left of them beside others, or weighted ones.
    inverse : array (p, p)
        P.
    known : array (p,) of bool
        Which parameters it determines.
    """

    z: np.ndarray
    inverse: np.ndarray
    known: np.ndarray

    def values(self, y: np.ndarray) -> np.ndarray:
        """Return the parameters.

        Parameters
        ----------
        y : array (blocks, q)
            Of the second level.
        """
        return np.asarray(self.inverse @ np.tensordot(self.z, y, axes=((0, 1), (0, 1))))

    def covariance(self, v: np.ndarray, other: "LinearEstimator | None" = None) -> np.ndarray:
        """Return the covariance (p, p) of its estimates, or that with another's.

        Parameters
        ----------
        v : array (blocks, q, q)
            Of the second level.
        other : LinearEstimator, optional
            The other.
        """
        second = other or self
        size = self.z.shape[2]
        middle = self.z.reshape(-1, size).T @ (v @ second.z).reshape(-1, size)
        return np.asarray(self.inverse @ middle @ second.inverse.T)


def estimator(z: np.ndarray, d: np.ndarray | None = None) -> LinearEstimator:
    """Make an estimator of its instruments (ours).

    Parameters
    ----------
    z : array (blocks, q, p)
        Instruments.
    d : array (blocks, q, p), optional
        Columns of the parameters, where Z'D is not Z'Z.
    """
    flat = z.reshape(-1, z.shape[2])
    inverse, known = pseudo_inverse(flat.T @ (flat if d is None else d.reshape(flat.shape)))
    return LinearEstimator(z, inverse, known)


@dataclass(frozen=True)
class SecondEstimate:
    """Another estimate of every parameter beside the fit's.

    Parameters
    ----------
    values : array (p,)
        Of the parameters.
    std : array (p,)
        Their standard errors.
    gap : array (p,)
        Standard error of their differences from the fit.
    known : array (p,) of bool
        Which ones are determined.
    """

    values: np.ndarray
    std: np.ndarray
    gap: np.ndarray
    known: np.ndarray


def compared_with(
    fit: np.ndarray, other: LinearEstimator, y: np.ndarray, v: np.ndarray, shown: np.ndarray
) -> SecondEstimate:
    """Compare another estimator with the fit (ours).

    Parameters
    ----------
    fit : array (blocks, q, p)
        Weights of the fit.
    other : LinearEstimator
        The other.
    y : array (blocks, q)
        Of the second level.
    v, shown : array (blocks, q, q)
        Its covariance, for the error of the estimate and for that of the difference.
    """
    weights = other.z @ other.inverse.T
    return SecondEstimate(other.values(y), sizes(weights, v), sizes(weights - fit, shown), other.known)


def sizes(weights: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the standard error (p,) of what each column of weights makes of the second level (ours).

    Parameters
    ----------
    weights : array (blocks, q, p)
        Of linear estimates.
    v : array (blocks, q, q)
        Covariance of the second level.
    """
    return np.asarray(np.sqrt(np.maximum((weights * (v @ weights)).sum(axis=(0, 1)), 0.0)))
