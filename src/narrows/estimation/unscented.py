"""The unscented transform, and the filter's two steps with it, for any system.

A distribution is a mean and a lower triangular root of its covariance.

Source: van der Merwe and Wan (2001), The square-root unscented Kalman filter for state and parameter estimation.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.estimation import square_roots
from narrows.estimation.settings import SQUARED_DISTANCE


class Gaussian(NamedTuple):
    mean: np.ndarray  # (n,) Mean
    root: np.ndarray  # (n, k) Root of the covariance

    @property
    def covariance(self) -> np.ndarray:
        return np.asarray(self.root @ self.root.T)


class SigmaPointWeights(NamedTuple):
    distance: float  # Distance of each pair, in standard deviations
    mean: float  # Weight of each pair in the mean
    bend: float  # Share of the sum of all second differences in the nonlinear part of each pair
    pairs: int

    def transform(
        self, now: Gaussian, function: Callable[[np.ndarray], np.ndarray], noise: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and rows of a function's values: changes along the root's columns, nonlinear parts, noise."""
        loops = compiled_loops(square_roots)
        points = loops.sigma_points(*now, self.distance, self.pairs)
        mean, rows = loops.transform(function(points), noise, self.distance, self.mean, self.bend)
        return mean, rows


# Julier and Uhlmann (1997), A new extension of the Kalman filter to nonlinear systems. van der Merwe (2004),
# Sigma-point Kalman filters for probabilistic inference in dynamic state-space models, chapter 3.
@lru_cache(maxsize=64)
def sigma_point_weights(
    size: int, alpha: float = 0.5, beta: float = 2.0, kappa: float | None = None
) -> SigmaPointWeights:
    """Return the weights of van der Merwe's scaled points."""
    squared = SQUARED_DISTANCE if kappa is None else alpha * alpha * (size + kappa)
    # The covariance has the pairs' second differences d about the mean, and the central point by the weight 1 - n/h^2 +
    # 1 - alpha^2 + beta, which may be negative. Both together are sums of squares of (d_i + bend sum d) / 2 h.
    bend = (math.sqrt(max(1.0 + (beta - alpha * alpha) * size / squared, 0.0)) - 1.0) / size
    return SigmaPointWeights(math.sqrt(squared), 0.5 / squared, bend, size)


def predict(
    now: Gaussian, move: Callable[[np.ndarray], np.ndarray], noise: np.ndarray, weights: SigmaPointWeights
) -> tuple[Gaussian, np.ndarray]:
    """Return the distribution after a motion with noise (j, n), and its slopes along the root's columns, (k, n)."""
    mean, rows = weights.transform(now, move, noise)
    return Gaussian(mean, triangular_root(rows)), rows[: weights.pairs]


def update(now: Gaussian, *measurement: Any) -> tuple[Any, ...]:
    """Return the distribution after a measurement, and the tests of its readings, see ``square_roots.update``."""
    mean, root, *tests = compiled_loops(square_roots).update(*now, *measurement)
    return Gaussian(mean, root), *tests


def triangular_root(rows: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of the sum of outer products of rows, (n, n)."""
    return np.asarray(compiled_loops(square_roots).triangular_root(rows))
