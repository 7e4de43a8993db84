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
    centre: np.ndarray  # (m,) Value at the central point minus the mean


class SigmaPointWeights(NamedTuple):
    """Distances and weights of the sigma points."""

    distance: np.ndarray  # (k,) Distance of each pair, in standard deviations
    mean: np.ndarray  # (k,) Weight of each pair in the mean
    slope: np.ndarray  # (k, 1) One over the distance within each pair
    centre: float  # Weight of the central point in the covariance
    # The first pairs, along errors that are carried and not corrected: linear, without weight in the mean
    considered: int


def unscented_transform(values: np.ndarray, spread: SigmaPointWeights) -> Transformed:
    """Return mean and deviations of the values at sigma points."""
    # values (1 + 2 k, m)
    k = len(spread.distance)
    first, ahead, behind = values[0], values[1 : k + 1], values[k + 1 :]
    off = ahead + behind - 2.0 * first
    shift = spread.mean @ off
    bends = (off[spread.considered :] - 2.0 * shift) * spread.slope[spread.considered :]
    return Transformed(first + shift, (ahead - behind) * spread.slope, bends, -shift)


def predict(
    now: Gaussian, move: Callable[[np.ndarray], np.ndarray], noise: np.ndarray, spread: SigmaPointWeights
) -> tuple[Gaussian, Transformed]:
    """Return the distribution after a motion, and the transformation of its root."""
    # noise (j, n)
    after = unscented_transform(move(sigma_points(now.mean, now.root, spread)), spread)
    p, centre = spread.considered, spread.centre
    parts = [after.slopes[p:], after.bends, noise]
    if centre > 0.0:
        parts.append(np.sqrt(centre) * after.centre[None])
    root = triangular_root(np.concatenate(parts))
    if centre < 0.0:
        root = downdated_root(root, np.sqrt(-centre) * after.centre)
    root = np.concatenate([after.slopes[:p].T, root], axis=1) if p else root
    return Gaussian(after.mean, root), after


def innovation_covariance(expected: Transformed, sigma: np.ndarray, spread: SigmaPointWeights) -> np.ndarray:
    """Return the covariance of the innovation, (m, m)."""
    s, b, c = expected.slopes, expected.bends, expected.centre
    covariance = s.T @ s
    if len(b):
        covariance += b.T @ b + spread.centre * np.outer(c, c)
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
    shared = now.root @ s
    gain = lapack.dposv(covariance, shared.T)[1].T
    rest = now.root - gain @ s.T
    parts = [rest[:, p:].T, gain.T * sigma[:, None]]
    curved = len(expected.bends) > 0
    if curved:
        parts.append(expected.bends @ gain.T)
        if spread.centre > 0.0:
            parts.append(np.sqrt(spread.centre) * (gain @ expected.centre)[None])
    root = triangular_root(np.concatenate(parts))
    if curved and spread.centre < 0.0:
        root = downdated_root(root, np.sqrt(-spread.centre) * (gain @ expected.centre))
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
    mean = np.concatenate([np.zeros(considered), np.full(size, 0.5 / squared)])
    centre = 1.0 - size / squared + 1.0 - alpha * alpha + beta
    return SigmaPointWeights(distance, mean, 0.5 / distance[:, None], centre, considered)


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


@lru_cache(maxsize=64)
def _unit(size: int) -> np.ndarray:
    return np.eye(size)


def triangular_root(rows: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of the sum of outer products of rows, (n, n), by QR."""
    count, size = rows.shape
    if count < size:
        rows = np.vstack([rows, np.zeros((size - count, size))])
    factored = lapack.dgeqrf(rows)[0]
    return np.asarray((factored[:size] * _upper(size)).T)


def downdated_root(root: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of L L^T - c c^T; if that is no covariance, L itself, which is conservative."""
    inside, singular = lapack.dtrtrs(root, column, lower=1)
    rest, failed = lapack.dpotrf(_unit(len(root)) - inside[:, None] * inside, lower=1)
    return root if singular or failed else np.asarray(root @ rest)
