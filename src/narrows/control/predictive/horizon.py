"""How far a predictive helm looks ahead, in what steps, and what is left of a plan when time has passed."""

from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError, check_count

# Ship lengths ahead that a plan reaches, unless a time is given.
LENGTHS = 2.4
INTERVALS = 30
MOST_INTERVALS = 60
# New plans are made this often, unless a time between them is given.
PLANS_AN_INTERVAL = 5


@dataclass(frozen=True)
class Horizon:
    """Equal intervals ahead, in each of which the rudder turns at one rate."""

    intervals: int  # How many
    interval: float  # Of each [s]
    period: float  # Between one plan and the next [s]

    @property
    def time(self) -> float:
        """How far ahead it reaches [s]."""
        return self.intervals * self.interval


def horizon_of(passing: float, horizon: float | None, intervals: int, period: float | None) -> Horizon:
    """Return the horizon of a ship."""
    # passing [s]; horizon [s]; period [s]
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
    """Return a plan's nodes as they are a share of an interval later, the last staying."""
    # nodes (nodes, ...)
    whole = min(int(share), len(nodes) - 1)
    shifted = np.concatenate([nodes[whole:], *[nodes[-1:]] * whole]) if whole else nodes.copy()
    shifted[:-1] += (share - int(share)) * np.diff(shifted, axis=0)
    return shifted
