"""Confidence intervals of bounded coefficients (unified intervals of Feldman and Cousins)."""

from functools import cache

import numpy as np

from narrows.errors import InputError
from narrows.quantities.names import Number

LEVEL = 0.95
GRID = 201
# Tolerance of the critical ratio.
HALVINGS = 30
# Clusters from which on a tenth of one makes no difference.
COARSE = 20.0


def t_quantile(clusters: Number, level: float = LEVEL) -> Number:
    """Return how many standard errors a two-sided interval reaches, Student's t with K - 1 degrees."""
    from scipy.special import stdtrit

    if not 0 < level < 1:
        raise InputError(f"a confidence of {level} is no share; give one between 0 and 1, as 0.95")
    return stdtrit(np.maximum(clusters - 1, 1), 0.5 + level / 2)


def bounded_interval(
    value: float, std: float, bound: tuple[float, float], clusters: float, level: float = LEVEL
) -> tuple[float, float]:
    """Return the interval of a coefficient that is known to lie within bounds."""
    # Away from the bounds it is ``value`` and Student's t on either side. Near one it is the unified interval: the
    # values whose likelihood ratio, to the best value within the bounds, is not surprising. Cutting the plain interval
    # at the bound would cover a coefficient at its bound too often, and could leave nothing.
    # Feldman, Cousins (1998), Unified approach to the classical statistical analysis of small signals.
    if not np.isfinite(std):
        return bound
    if std == 0:
        return (value, value)
    clusters = round(clusters, 1) if clusters < COARSE else round(clusters)  # a table is kept for each
    ends = np.array([-1, 1]) * t_quantile(clusters, level) * std + value
    low, high = bound
    if np.isfinite(low):
        ends = low + std * np.array(_above_zero((value - low) / std, clusters, level))
    elif np.isfinite(high):
        ends = high - std * np.array(_above_zero((high - value) / std, clusters, level))[::-1]
    return max(low, float(ends[0])), min(high, float(ends[1]))


def _above_zero(x: float, clusters: float, level: float) -> tuple[float, float]:
    """Interval of a mean that is not negative, seen as x, in standard errors."""
    plain = float(t_quantile(clusters, level))
    if x > 2 * plain:
        return x - plain, x + plain
    truths, least, most = _accepted(clusters, level)
    low = float(np.interp(x, most, truths)) if x > most[0] else 0.0
    if x >= least[-1]:
        return low, x + plain
    return low, float(np.interp(x, least, truths))


@cache
def _accepted(clusters: float, level: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the acceptance interval of the estimate, for truths from 0 to the quantile."""
    from scipy.special import stdtr

    plain, degrees = t_quantile(clusters, level), max(clusters - 1, 1)
    truths = np.linspace(1e-3, 1, GRID) * plain
    low, high = np.zeros(GRID), np.full(GRID, plain)  # of the square root of the critical ratio
    for _ in range(HALVINGS):
        root = (low + high) / 2
        inside = stdtr(degrees, root) - stdtr(degrees, _least(truths, root) - truths)
        low, high = np.where(inside < level, root, low), np.where(inside < level, high, root)
    root = (low + high) / 2
    return truths, _least(truths, root), truths + root


def _least(truths: np.ndarray, root: np.ndarray) -> np.ndarray:
    """Return the lower bound, where the likelihood ratio to the best allowed truth reaches ``root`` squared."""
    return np.asarray(np.where(root <= truths, truths - root, (truths**2 - root**2) / (2 * truths)))
