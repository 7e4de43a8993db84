"""How far a predictive helm looks ahead, in what steps, and what is left of a plan when time has passed."""

from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError, check_count

LENGTHS = 2.4
"""Ship lengths ahead that a plan reaches, unless a time is given."""
INTERVALS = 30
MOST_INTERVALS = 60
PLANS_AN_INTERVAL = 5
"""New plans are made this often, unless a time between them is given."""


@dataclass(frozen=True)
class Horizon:
    """Equal intervals ahead, in each of which the rudder turns at one rate.

    Parameters
    ----------
    intervals : int
        How many.
    interval : float [s]
        Of each.
    period : float [s]
        Between one plan and the next.
    """

    intervals: int
    interval: float
    period: float

    @property
    def time(self) -> float:
        """How far ahead it reaches [s]."""
        return self.intervals * self.interval


def horizon_of(passing: float, horizon: float | None, intervals: int, period: float | None) -> Horizon:
    """Return the horizon of a ship (ours).

    Parameters
    ----------
    passing : float [s]
        In which it moves on by its length.
    horizon : float [s], optional
        How far ahead; 2.4 times that unless given.
    intervals : int
        How many intervals.
    period : float [s], optional
        Between one plan and the next; a fifth of an interval unless given.

    Raises
    ------
    InputError
        Where a time is not positive, plans are further apart than an interval, or intervals are too many.
    """
    check_count("intervals", intervals, 2, MOST_INTERVALS)
    for name, value in (("horizon", horizon), ("period", period)):
        if value is not None and not 0 < value < np.inf:
            raise InputError(f"{name} = {value} must be a positive time in seconds")
    interval = (LENGTHS * passing if horizon is None else horizon) / intervals
    between = interval / PLANS_AN_INTERVAL if period is None else period
    if between > interval:
        raise InputError(
            f"a plan every {between:g} s is too seldom for intervals of {interval:.3g} s; shorten the period or "
            "lengthen the horizon"
        )
    return Horizon(intervals, interval, between)


def later(nodes: np.ndarray, share: float) -> np.ndarray:
    """Return a plan's nodes as they are a share of an interval later, the last staying (ours).

    Parameters
    ----------
    nodes : array (nodes, ...)
        At the ends of intervals, or a number of each interval.
    share : float [1]
        Of an interval, from 0.
    """
    whole = min(int(share), len(nodes) - 1)
    shifted = np.concatenate([nodes[whole:], *[nodes[-1:]] * whole]) if whole else nodes.copy()
    shifted[:-1] += (share - int(share)) * np.diff(shifted, axis=0)
    return shifted
