"""Sigma points: a few states that stand for a normal distribution, and how each weighs.

References
----------
Julier and Uhlmann (1997), A new extension of the Kalman filter to nonlinear systems.
van der Merwe (2004), Sigma-point Kalman filters for probabilistic inference in dynamic state-space models, chapter 3.
"""

from typing import NamedTuple

import numpy as np

ALPHA, BETA = 0.5, 2.0
# Of the points from the mean, in variances: the fourth moment of a normal distribution is met.
SQUARED_DISTANCE = 3.0
# Standard deviations by which a coefficient is moved: so near that the difference is the derivative.
CONSIDERED_DISTANCE = 0.1


class Spread(NamedTuple):
    """How far the points lie from the mean and how they weigh."""

    distance: np.ndarray  # (k,) Of each pair, in standard deviations
    mean: np.ndarray  # (k,) Weight of each pair in the mean
    slope: np.ndarray  # (k, 1) One over the distance within each pair
    centre: float  # Weight of the central point in the covariance
    # Pairs, the first ones, along errors that are carried and not corrected: linear, without weight in the mean
    considered: int


def spread_of(
    size: int, considered: int = 0, alpha: float = ALPHA, beta: float = BETA, kappa: float | None = None
) -> Spread:
    """Return the spread of van der Merwe's scaled points."""
    squared = SQUARED_DISTANCE if kappa is None else alpha * alpha * (size + kappa)
    distance = np.concatenate([np.full(considered, CONSIDERED_DISTANCE), np.full(size, np.sqrt(squared))])
    mean = np.concatenate([np.zeros(considered), np.full(size, 0.5 / squared)])
    centre = 1.0 - size / squared + 1.0 - alpha * alpha + beta
    return Spread(distance, mean, 0.5 / distance[:, None], centre, considered)


def sigma_points(mean: np.ndarray, root: np.ndarray, spread: Spread) -> np.ndarray:
    """Return the points, (1 + 2 k, n): the mean, then what lies ahead of it and behind it along each column."""
    # mean (n,); root (n, k)
    pairs = len(spread.distance)
    points = np.empty((1 + 2 * pairs, len(mean)))
    steps = root.T * spread.distance[:, None]
    points[0] = mean
    np.add(mean, steps, out=points[1 : pairs + 1])
    np.subtract(mean, steps, out=points[pairs + 1 :])
    return points
