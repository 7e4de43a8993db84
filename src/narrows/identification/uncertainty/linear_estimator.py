"""Linear estimators of the second level: the fit itself and others that should agree with it, with their errors."""

from dataclasses import dataclass

import numpy as np

from narrows.identification.uncertainty.error_model import pseudo_inverse


@dataclass(frozen=True)
class LinearEstimator:
    """``theta = P Z'y``, with P the inverse of Z'D."""

    # (blocks, q, p) Instruments: the columns themselves, what is left of them beside others, or weighted ones
    z: np.ndarray
    inverse: np.ndarray  # (p, p) P
    known: np.ndarray  # (p,) Which parameters it determines

    def values(self, y: np.ndarray) -> np.ndarray:
        """Return the parameters."""
        # y (blocks, q)
        return np.asarray(self.inverse @ np.tensordot(self.z, y, axes=((0, 1), (0, 1))))

    def covariance(self, v: np.ndarray, other: "LinearEstimator | None" = None) -> np.ndarray:
        """Return the covariance (p, p) of its estimates, or that with another's."""
        # v (blocks, q, q)
        second = other or self
        size = self.z.shape[2]
        middle = self.z.reshape(-1, size).T @ (v @ second.z).reshape(-1, size)
        return np.asarray(self.inverse @ middle @ second.inverse.T)


def estimator(z: np.ndarray, d: np.ndarray | None = None) -> LinearEstimator:
    """Make an estimator of its instruments."""
    # z (blocks, q, p); d (blocks, q, p)
    flat = z.reshape(-1, z.shape[2])
    inverse, known = pseudo_inverse(flat.T @ (flat if d is None else d.reshape(flat.shape)))
    return LinearEstimator(z, inverse, known)


@dataclass(frozen=True)
class SecondEstimate:
    """Another estimate of every parameter beside the fit's."""

    values: np.ndarray  # (p,) Of the parameters
    std: np.ndarray  # (p,) Their standard errors
    gap: np.ndarray  # (p,) Standard error of their differences from the fit
    known: np.ndarray  # (p,) Which ones are determined


def compared_with(
    fit: np.ndarray, other: LinearEstimator, y: np.ndarray, v: np.ndarray, shown: np.ndarray
) -> SecondEstimate:
    """Compare another estimator with the fit."""
    # fit (blocks, q, p); y (blocks, q); v, shown (blocks, q, q)
    weights = other.z @ other.inverse.T
    return SecondEstimate(other.values(y), sizes(weights, v), sizes(weights - fit, shown), other.known)


def sizes(weights: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the standard error (p,) of what each column of weights makes of the second level."""
    # weights (blocks, q, p); v (blocks, q, q)
    return np.asarray(np.sqrt(np.maximum((weights * (v @ weights)).sum(axis=(0, 1)), 0.0)))
