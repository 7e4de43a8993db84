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
    slope: np.ndarray  # (k, 1) One over the distance within each pair
    bend: float  # Share of the sum of all second differences in the nonlinear part of each pair
    # The first pairs, along errors that are carried and not corrected: linear, without weight in the mean
    considered: int


def unscented_transform(values: np.ndarray, spread: SigmaPointWeights) -> Transformed:
    """Return mean and deviations of the values at sigma points."""
    # values (1 + 2 k, m)
    k, p = len(spread.distance), spread.considered
    first, ahead, behind = values[0], values[1 : k + 1], values[k + 1 :]
    off = ahead[p:] + behind[p:] - 2.0 * first
    total = off.sum(axis=0)
    return Transformed(
        first + spread.mean * total, (ahead - behind) * spread.slope, (off + spread.bend * total) * spread.slope[p:]
    )


def predict(
    now: Gaussian, move: Callable[[np.ndarray], np.ndarray], noise: np.ndarray, spread: SigmaPointWeights
) -> tuple[Gaussian, Transformed]:
    """Return the distribution after a motion, and the transformation of its root."""
    # noise (j, n)
    after, p = unscented_transform(move(sigma_points(now.mean, now.root, spread)), spread), spread.considered
    root = triangular_root(np.concatenate([after.slopes[p:], after.bends, noise]))
    root = np.concatenate([after.slopes[:p].T, root], axis=1) if p else root
    return Gaussian(after.mean, root), after


def innovation_covariance(expected: Transformed, sigma: np.ndarray) -> np.ndarray:
    """Return the covariance of the innovation, (m, m)."""
    covariance = expected.slopes.T @ expected.slopes
    if len(expected.bends):
        covariance += expected.bends.T @ expected.bends
    covariance.flat[:: len(sigma) + 1] += sigma * sigma
    return np.asarray(covariance)


def update(
    now: Gaussian, expected: Transformed, innovation: np.ndarray, covariance: np.ndarray, sigma: np.ndarray,
    spread: SigmaPointWeights,
) -> Gaussian:  # fmt: skip
    """Return the distribution after a measurement; carried columns are not corrected."""
    # innovation (m,); covariance (m, m); sigma (m,) Joseph's form is a sum of squares: it stays a covariance for any
    # gain.
    p, s = spread.considered, expected.slopes
    gain = lapack.dposv(covariance, (now.root @ s).T)[1].T
    rest = now.root - gain @ s.T
    root = triangular_root(np.concatenate([rest[:, p:].T, gain.T * sigma[:, None], expected.bends @ gain.T]))
    root = np.concatenate([rest[:, :p], root], axis=1) if p else root
    return Gaussian(now.mean + gain @ innovation, root)


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
    return SigmaPointWeights(distance, 0.5 / squared, 0.5 / distance[:, None], float(bend), considered)


def sigma_points(mean: np.ndarray, root: np.ndarray, spread: SigmaPointWeights) -> np.ndarray:
    """Return the points, (1 + 2 k, n): the mean, then one point on either side of it along each column."""
    pairs = len(spread.distance)
    points = np.empty((1 + 2 * pairs, len(mean)))
    steps = root.T * spread.distance[:, None]
    points[0] = mean
    np.add(mean, steps, out=points[1 : pairs + 1])
    np.subtract(mean, steps, out=points[pairs + 1 :])
    return points


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
