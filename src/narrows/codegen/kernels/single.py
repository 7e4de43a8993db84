"""Integrate one vessel to its end, step by step: the end of every exported file.

It uses the small part of Python that ``printers.translation`` supports. In the exported file ``step`` and
``least_clearance`` come first, printed from the lines of the model. ``event`` holds the rule for ends of a voyage,
``waterway.bank_clearance`` the distances to its banks.
"""

from math import floor, inf
from typing import TYPE_CHECKING, Any, TypeAlias

from narrows.codegen.kernels.event import (
    ASTERN,
    BACK,
    CLOCK,
    COUNT,
    FINISHED,
    LOST,
    NEXT,
    PLACES,
    TRIES,
    StepState,
    accept_step,
    begin_voyage,
    cause,
    clearance_left,
    is_sane,
)  # fmt: skip
from narrows.waterway.bank_clearance import exact_clearance

Array: TypeAlias = Any
Inputs: TypeAlias = Any
"""Inputs that a caller may change."""
Constants: TypeAlias = Any
"""Constants of a voyage."""
Place: TypeAlias = Any
"""The water."""

if TYPE_CHECKING:

    def step(state: Array, after: Array, length: float, inputs: Inputs, constants: Constants, waterway: Place) -> None:
        """Write the state after a step, the clearance and the side."""

    def least_clearance(state: Array, closeness: Array, constants: Constants, waterway: Place) -> None:
        """Write the clearance by the lines' own rule, and the side."""


EXACT = WATERWAY = False
LEAVES = 0.0
"""Share of the clearance that a step must leave; over 0 where the suction becomes infinite."""
KEPT, COS, U, V, R = 7, 2, 4, 5, 6
"""Numbers of the state, and places in it: cosine of the heading, velocities, yaw rate."""
AFLOAT, DIVERGED, REFUSED = 0, 2, 6
UNREACHED = 1e9
"""Margin to an end that a voyage cannot meet [m]."""
MOST_STEPS = 1e9
"""Most steps of a voyage."""
TOLERANCE = 1e-9
"""Tolerance of the location of a contact [m]."""
MOST_SPEED, MOST_RATE = 100.0, 10.0
"""Speed [m/s] and yaw rate [rad/s] at which the numbers are lost."""


def true_clearance(state: Array, closeness: Array, constants: Constants, waterway: Place) -> None:
    """Write the clearance by the banks themselves and by the other ends of a voyage, and the side [m]."""
    closeness[0], closeness[1] = exact_clearance(
        waterway.track, 1.0 / waterway.cells_a_metre, state[0], state[1], state[2], state[3], waterway.outline
    )
    ends = min(waterway.x_last - state[0], state[0] - waterway.x_first)
    closeness[0] = min(min(closeness[0], ends), state[COS] - constants.least_cos)


def clearance(state: Array, closeness: Array, waterway: Place) -> None:
    """Write the clearance to starboard and to port by the banks themselves [m]."""
    closeness[0], closeness[1] = exact_clearance(
        waterway.track, 1.0 / waterway.cells_a_metre, state[0], state[1], state[2], state[3], waterway.outline
    )
    starboard = closeness[0] if closeness[1] > 0.0 else closeness[0] - closeness[1]
    closeness[1] += starboard
    closeness[0] = starboard


def cause_of(state: Array, constants: Constants, waterway: Place, tolerance: float) -> int:
    """Return which end is met when the clearance is zero: the limit of heading, an end of the waterway, or a bank."""
    ahead, astern = UNREACHED, UNREACHED
    if WATERWAY:
        ahead, astern = waterway.x_last - state[0], state[0] - waterway.x_first
    return cause(state[COS] - constants.least_cos, ahead, astern, UNREACHED, tolerance)


def begun(state: Array, closeness: Array, constants: Constants, waterway: Place) -> int:
    """Return what ends a voyage at its start; AFLOAT if nothing does."""
    least_clearance(state, closeness, constants, waterway)
    if EXACT and closeness[0] <= 0.0:
        true_clearance(state, closeness, constants, waterway)
    if not is_sane(state[U], state[V], state[R], closeness[0], constants.near_bank, LEAVES, MOST_SPEED, MOST_RATE):
        return DIVERGED
    if closeness[0] > 0.0:
        return AFLOAT
    outcome: int = cause_of(state, constants, waterway, 0.0)
    # The first point of a waterway belongs to it.
    return AFLOAT if closeness[0] == 0.0 and outcome == ASTERN else outcome


def can_integrate(state: Array, constants: Constants, waterway: Place, length: float, duration: float) -> bool:
    """Return whether the ship moves less than its own length in a step, and there is water to sail in."""
    if not (length > 0.0 and length < inf and duration >= 0.0 and duration <= MOST_STEPS * length):
        return False
    if WATERWAY and not waterway.x_last > waterway.x_first:
        return False
    return min(length, duration) * abs(state[U]) <= constants.hull_length  # type: ignore[no-any-return]


def schedule(control: StepState, length: float, duration: float) -> None:
    """Plan whole steps and, if the time is no multiple of them, a shorter last one."""
    count = 1.0 * floor(duration / length + 1e-9)
    rest = duration - count * length
    begin_voyage(control, length, count, rest if rest > 1e-9 * length else 0.0)


def ended(outcome: int, state: Array, before: float, now: float, constants: Constants, waterway: Place) -> int:
    """Return the cause of a voyage's end, by the clearance before the step and after."""
    if outcome == FINISHED:
        return AFLOAT
    if outcome == LOST and before > constants.near_bank:
        return DIVERGED
    drawn: bool = outcome == LOST or now > TOLERANCE
    return cause_of(state, constants, waterway, constants.near_bank if drawn else TOLERANCE)


def integrate(
    state: Array, inputs: Inputs, constants: Constants, waterway: Place, length: float, duration: float, end: Array
) -> int:
    """Integrate with the caller's inputs until the time is up or the voyage ends, and return the outcome."""
    # The time [s] and the side, positive if the starboard bank is nearer [m], are put into ``end``.
    if not can_integrate(state, constants, waterway, length, duration):
        end[0], end[1] = 0.0, 0.0
        return REFUSED
    control = [0.0] * PLACES
    after = [0.0] * (KEPT + 2)
    closeness = [0.0] * 2
    schedule(control, length, duration)
    outcome: int = begun(state, closeness, constants, waterway)
    end[0], end[1] = 0.0, closeness[1]
    if outcome != AFLOAT:
        return outcome
    left, before, close = control[COUNT], closeness[0], constants.near_bank
    while control[COUNT] > 0.0:
        trying: bool = control[TRIES] > 0.0
        step(state, after, control[NEXT], inputs, constants, waterway)
        left -= 1.0
        closeness[0], closeness[1] = after[KEPT], after[KEPT + 1]
        sane: bool = is_sane(after[U], after[V], after[R], closeness[0], close, LEAVES, MOST_SPEED, MOST_RATE)
        if EXACT and sane and (closeness[0] <= 0.0 or trying):
            true_clearance(after, closeness, constants, waterway)
        now, side = closeness[0], closeness[1]
        clear: bool = sane and clearance_left(now, before, LEAVES) > 0.0
        if clear and left > 0.0 and not trying:
            for number in range(KEPT):
                state[number] = after[number]
            before = now
            continue
        if EXACT and (trying or not clear):
            true_clearance(state, closeness, constants, waterway)
            before = closeness[0]
        outcome = accept_step(control, left, now, before, sane, TOLERANCE, close, LEAVES)
        end[0] = control[CLOCK]
        if outcome != LOST and outcome != BACK:
            for number in range(KEPT):
                state[number] = after[number]
            end[1] = side
        if outcome >= FINISHED:
            return ended(outcome, state, before, now, constants, waterway)
        least_clearance(state, closeness, constants, waterway)
        left, before = control[COUNT], closeness[0]
    return AFLOAT
