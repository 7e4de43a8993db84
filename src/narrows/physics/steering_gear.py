"""A steering gear between an order and the rudder: dead time, first-order lag, dead band, rate."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from narrows.quantities.names import Number

# Shortest time constant [s]; shorter ones count as zero. It keeps quotients of two times finite if both are 0.
NO_TIME = 1e-12

Functions = Mapping[str, Callable[..., Any]]


def gear_motion(
    order: Number, position: Number, stages: Sequence[Number], gear: Mapping[str, Number], dt: Number,
    functions: Functions, put: Callable[[str, Any], Any] = lambda name, value: value,
) -> tuple[Any, list[Any]]:  # fmt: skip
    """Return the motion of an actuator in a step [rad], and the new stages of its dead time.

    Source: the exponential of a first-order lag; tanks in series for the dead time, Levenspiel (1999), Chemical
    Reaction Engineering, chapter 14.

    ``gear`` has ``dead_time``, ``lag`` [s], ``dead_band`` and ``rate``; ``functions`` are minimum, maximum, choice and
    exp for the type of number; ``put`` stores values that are used more than once.
    """
    # The dead time is a chain of equal first-order stages. A stage passes on a share of its input; if the step is
    # longer than its part of the dead time it passes on all of it, weighted between start and end of the step. So a
    # ramp is late by exactly the dead time for any step, and no memory of past orders is needed, whose length would
    # depend on it.
    least, greatest = functions["minimum"], functions["maximum"]
    passing = put("passing", len(stages) * dt)
    share = put("share", passing / greatest(greatest(gear["dead_time"], passing), NO_TIME))
    late = put("late", least(gear["dead_time"] / greatest(passing, NO_TIME), 1.0))
    heard, after = order, []
    for number, stage in enumerate(stages):
        after.append(put(f"heard_{number}_new", stage + share * (heard - stage)))
        heard = put(f"heard_{number}_out", after[-1] + late * (stage - after[-1]))
    left = put("left", heard - position)
    moved = put("moved", functions["choice"](abs(left) - gear["dead_band"], left, 0.0))
    followed = put("followed", 1.0 - functions["exp"](-dt / greatest(gear["lag"], NO_TIME)))
    furthest = put("reach", gear["rate"] * dt)
    return put("whole", least(greatest(moved * followed, -furthest), furthest)), after
