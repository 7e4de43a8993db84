"""Which futures are forecast: who steers, from when, and for how long it is looked at."""

from dataclasses import dataclass

import numpy as np

AS_IS = "as it is"
# When a pilot takes over [s].
TAKEOVERS = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
# The same, for the most likely run alone [s].
CHANCES = tuple(np.arange(0.0, 61.0, 2.0).tolist())
# How long it is looked at from the takeover on [s], or from the start; and with the rudder hard over [s].
AFTER, HARD_OVER_TIME = 120.0, 60.0
NEVER = 1e9
PORT, STARBOARD = -1.0, 1.0


@dataclass(frozen=True)
class Case:
    """A future."""

    name: str  # What happens
    taken_over: float  # When a pilot takes over [s]
    duration: float  # How long it is looked at [s]
    # To which side the rudder is put over: -1 to port, 1 to starboard, 0 where it stays where it is [1]
    hard_over: float = 0.0


def pilot_case(taken_over: float) -> Case:
    """Return the future of a pilot who takes over."""
    # taken_over [s]
    when = "now" if taken_over == 0.0 else f"after {taken_over:g} s"
    return Case(f"pilot {when}", taken_over, taken_over + AFTER)


CASES = (
    Case(AS_IS, NEVER, AFTER), *map(pilot_case, TAKEOVERS),
    Case("hard to port", NEVER, HARD_OVER_TIME, PORT), Case("hard to starboard", NEVER, HARD_OVER_TIME, STARBOARD),
)  # fmt: skip
# Those of the most likely run.
LIKELY = (CASES[0], *map(pilot_case, CHANCES), *CASES[-2:])
PILOT_NOW = CASES[1].name
