"""Whether a time step was short enough: what one step errs by, told by two halves of it."""

import math
from collections.abc import Sequence

from narrows.simulation.integrate import Rate, Row, rk4_step

SAMPLES = 16
"""Steps of a voyage that are taken again."""
ORDER_4 = 16 / 15
"""What a step of order 4 errs by, over its difference from two halves."""


def track_error(rate: Rate, rows: Sequence[Row], dt: float) -> float:
    """Estimate how far off a voyage's track is at its end for the length of its time step [m] (ours).

    The error of a step is that of a few, taken again in two halves; steps add up, and what the motion itself makes of
    an error is left out.

    Parameters
    ----------
    rate : callable
        Right-hand side.
    rows : sequence of (time, state)
        Of the voyage.
    dt : float [s]
        Its step.
    """
    count = (rows[-1][0] - rows[0][0]) / dt
    errors = [_step_error(rate, state, dt) for _, state in rows[: -1 : max(1, len(rows) // SAMPLES)]]
    return count * sum(errors) / max(len(errors), 1)


def _step_error(rate: Rate, state: tuple[float, ...], h: float) -> float:
    whole = rk4_step(rate, state, h)
    halves = rk4_step(rate, rk4_step(rate, state, h / 2), h / 2)
    return ORDER_4 * math.hypot(whole[0] - halves[0], whole[1] - halves[1])
