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
