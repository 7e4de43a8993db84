"""Whether a time step was short enough: what one step errs by, told by two halves of it."""

import math
from collections.abc import Sequence

from narrows.simulation.march import March, Row

# Steps of a voyage that are taken again.
SAMPLES = 16
# What a step of order 4 errs by, over its difference from two halves.
ORDER_4 = 16 / 15


def track_error(march: March, rows: Sequence[Row], dt: float) -> float:
    """Estimate how far off a voyage's track is at its end for the length of its time step [m]."""
    # dt [s]
    # The error of a step is that of a few, taken again in two halves with the rudder held; steps add up, and what the
    # motion itself makes of an error is left out.
    march.set(rudder_rate=0.0, revolutions_rate=0.0)
    whole = [row.state for row in rows[:-1] if row.ahead == dt]
    errors = [_step_error(march, state, dt) for state in whole[:: max(1, len(whole) // SAMPLES)]]
    return (rows[-1].t - rows[0].t) / dt * sum(errors) / max(len(errors), 1)


def _step_error(march: March, state: tuple[float, ...], dt: float) -> float:
    whole = march.stepped(state, dt)[0]
    halves = march.stepped(march.stepped(state, dt / 2)[0], dt / 2)[0]
    return ORDER_4 * math.hypot(whole[0] - halves[0], whole[1] - halves[1])
