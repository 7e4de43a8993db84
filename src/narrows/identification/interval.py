"""Confidence intervals of bounded coefficients (unified intervals of Feldman and Cousins)."""

from functools import cache
from statistics import NormalDist

import numpy as np

from narrows.errors import InputError

LEVEL = 0.95
GRID = 201
# Halvings of the bracket around the critical likelihood ratio.
HALVINGS = 30


def bounded_interval(value: float, std: float, bound: tuple[float, float], level: float = LEVEL) -> tuple[float, float]:
    """Return the interval of a coefficient that is known to lie within bounds."""
    # Away from the bounds it is the normal interval. Near one it is the unified interval: the values whose likelihood
    # ratio, to the best value within the bounds, is not surprising. Cutting the plain interval at the bound would cover
    # a coefficient at its bound too often, and could leave nothing.
    # Feldman, Cousins (1998), Unified approach to the classical statistical analysis of small signals.
    if not 0 < level < 1:
        raise InputError(f"a confidence of {level} is no share; give one between 0 and 1, as 0.95")
    if not np.isfinite(std):
        return bound
    if std == 0:
        return (value, value)
    ends = np.array([-1, 1]) * NormalDist().inv_cdf(0.5 + level / 2) * std + value
    low, high = bound
    if np.isfinite(low) and value - low <= high - value:
        ends = low + std * np.array(_above_zero((value - low) / std, level))
    elif np.isfinite(high):
        ends = high - std * np.array(_above_zero((high - value) / std, level))[::-1]
    return max(low, float(ends[0])), min(high, float(ends[1]))


def _above_zero(x: float, level: float) -> tuple[float, float]:
    """Interval of a non-negative mean from its estimate ``x`` [standard errors]."""
    plain = NormalDist().inv_cdf(0.5 + level / 2)
    if x > 2 * plain:
        return x - plain, x + plain
    truths, least, most = _accepted(level)
    low = float(np.interp(x, most, truths)) if x > most[0] else 0.0
    if x >= least[-1]:
        return low, x + plain
    return low, float(np.interp(x, least, truths))


@cache
def _accepted(level: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the acceptance interval of the estimate, for truths from 0 to the quantile."""
    from scipy.special import ndtr

    plain = NormalDist().inv_cdf(0.5 + level / 2)
    truths = np.linspace(1e-3, 1, GRID) * plain
    low, high = np.zeros(GRID), np.full(GRID, plain)  # Bracket of the root of the critical ratio
    for _ in range(HALVINGS):
        root = (low + high) / 2
        inside = ndtr(root) - ndtr(_least(truths, root) - truths)
        low, high = np.where(inside < level, root, low), np.where(inside < level, high, root)
    root = (low + high) / 2
    return truths, _least(truths, root), truths + root


def _least(truths: np.ndarray, root: np.ndarray) -> np.ndarray:
    """Return the lower bound, where the likelihood ratio to the best allowed truth reaches ``root`` squared."""
    return np.asarray(np.where(root <= truths, truths - root, (truths**2 - root**2) / (2 * truths)))
