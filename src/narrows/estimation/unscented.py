"""The unscented transform, and the filter's two steps with it, for any system.

A distribution is a mean and a root of its covariance. The first columns of the root may belong to errors that are
carried and never corrected, such as those of coefficients (Schmidt); the others are lower triangular.

References
----------
Schmidt (1966), Application of state-space methods to navigation problems.
van der Merwe and Wan (2001), The square-root unscented Kalman filter for state and parameter estimation.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from narrows.codegen.cache import compiled_loops
from narrows.estimation import square_roots
from narrows.estimation.settings import CONSIDERED_DISTANCE, SQUARED_DISTANCE


class Gaussian(NamedTuple):
    mean: np.ndarray  # (n,) Mean
    root: np.ndarray  # (n, k) Root of the covariance

    @property
    def covariance(self) -> np.ndarray:
        return np.asarray(self.root @ self.root.T)


class Transformed(NamedTuple):
    """A distribution transformed by a function."""

    mean: np.ndarray  # (m,) Mean of the values
    slopes: np.ndarray  # (k, m) Change along each column of the root
    bends: np.ndarray  # (j, m) Nonlinear part along each corrected column


class SigmaPointWeights(NamedTuple):
    """Distances and weights of the sigma points."""

    distance: np.ndarray  # (k,) Distance of each pair, in standard deviations
    mean: float  # Weight of each corrected pair in the mean
    bend: float  # Share of the sum of all second differences in the nonlinear part of each pair
    # The first pairs, along errors that are carried and not corrected: linear, without weight in the mean
    considered: int


def unscented_transform(values: np.ndarray, spread: SigmaPointWeights) -> Transformed:
    """Return mean and deviations of the values at sigma points, (1 + 2 k, m)."""
    return Transformed(*compiled_loops(square_roots).transform(values, *spread))


def predict(
    now: Gaussian, move: Callable[[np.ndarray], np.ndarray], noise: np.ndarray, spread: SigmaPointWeights
) -> tuple[Gaussian, Transformed]:
    """Return the distribution after a motion, and the transformation of its root."""
    # noise (j, n)
    after, p = unscented_transform(move(sigma_points(now.mean, now.root, spread)), spread), spread.considered
    return _joined(after.mean, np.concatenate([after.slopes, after.bends, noise]), p), after


def update(
    now: Gaussian, expected: Transformed, innovation: np.ndarray, covariance: np.ndarray, sigma: np.ndarray,
    spread: SigmaPointWeights,
) -> Gaussian:  # fmt: skip
    """Return the distribution after a measurement; carried columns are not corrected."""
    # innovation (m,); covariance (m, m); sigma (m,)
    numbers = *now, expected.slopes, expected.bends, innovation, covariance, sigma
    mean, rows = compiled_loops(square_roots).update(*numbers)
    return _joined(mean, rows, spread.considered)


def _joined(mean: np.ndarray, rows: np.ndarray, considered: int) -> Gaussian:
    root = triangular_root(rows[considered:])
    return Gaussian(mean, np.concatenate([rows[:considered].T, root], axis=1) if considered else root)


# Julier and Uhlmann (1997), A new extension of the Kalman filter to nonlinear systems. van der Merwe (2004),
# Sigma-point Kalman filters for probabilistic inference in dynamic state-space models, chapter 3.
def sigma_point_weights(
    size: int, considered: int = 0, alpha: float = 0.5, beta: float = 2.0, kappa: float | None = None
) -> SigmaPointWeights:
    """Return the weights of van der Merwe's scaled points."""
    squared = SQUARED_DISTANCE if kappa is None else alpha * alpha * (size + kappa)
    distance = np.concatenate([np.full(considered, CONSIDERED_DISTANCE), np.full(size, np.sqrt(squared))])
    # The covariance has the pairs' second differences d about the mean, and the central point by the weight 1 - n/h^2 +
    # 1 - alpha^2 + beta, which may be negative. Both together are sums of squares of (d_i + bend sum d) / 2 h.
    bend = (np.sqrt(max(1.0 + (beta - alpha * alpha) * size / squared, 0.0)) - 1.0) / size
    return SigmaPointWeights(distance, 0.5 / squared, float(bend), considered)


def sigma_points(mean: np.ndarray, root: np.ndarray, spread: SigmaPointWeights) -> np.ndarray:
    """Return the points, (1 + 2 k, n): the mean, then one point on either side of it along each column."""
    return np.asarray(compiled_loops(square_roots).sigma_points(mean, root, spread.distance))


# A covariance P stored as a root L, with L L^T = P, stays symmetric and positive. van der Merwe and Wan (2001), The
# square-root unscented Kalman filter for state and parameter estimation.
@lru_cache(maxsize=64)
def _upper(size: int) -> np.ndarray:
    return np.triu(np.ones((size, size)))


def triangular_root(rows: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of the sum of outer products of rows, (n, n), by QR."""
    count, size = rows.shape
    if count < size:
        rows = np.vstack([rows, np.zeros((size - count, size))])
    factored = lapack.dgeqrf(rows)[0]
    return np.asarray((factored[:size] * _upper(size)).T)
