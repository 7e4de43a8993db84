"""Step control of a voyage, and its end at a bank or at numbers out of range: one rule for every engine.

A voyage in Python calls these functions directly; all kernels call one compiled copy. A step through a bank is undone
and tried shorter, by the secant of the clearance. A valid step without contact is accepted, and the next try starts
from there. So a contact is located within the step, even if the suction becomes infinite there.
"""

from typing import Any

StepState = Any
"""State of the step control: an array or a list of numbers, by the indices below."""
CLOCK, LENGTH, PLANNED, NEXT, COUNT, TRIES, SPAN, AFTER, REST, PLACES = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9
"""Indices of the control: CLOCK, time before the current segment of equal steps [s]; LENGTH [s] and PLANNED, length
and number of its steps; NEXT [s] and COUNT, length and number of the next tries; TRIES within the current step; SPAN,
rest of that step [s]; AFTER, whole steps after it; REST, last, shorter step [s]; PLACES, number of indices."""
ON, BACK, FINISHED, CLOSED, LOST = -1, -2, 0, 1, 2
"""Outcomes of a try. ON: continue from its end; BACK: undo it and try a shorter one; FINISHED: the time is up; CLOSED:
contact with a bank or an end; LOST: the numbers diverge."""
GROUNDED, OUTSIDE, ASTERN, PASSED, SHALLOW = 1, 3, 4, 5, 7
"""Contacts that end a voyage: bank, limit of heading, end of the waterway astern and ahead, too little water."""
TOO_FAST = 1e-6
"""Tolerance of the speed at which a ship touches the bottom or chokes the section [m/s]."""
MOST_TRIES, HALVE_EACH = 600, 8
"""Most tries within a step; every eighth halves the step instead of using the secant."""
SHORTEST = 0.1
"""Shortest next try over the last one [1]."""
AIM = 0.8
"""Share of the remaining clearance that the next step may use [1]."""


def begin_voyage(control: StepState, length: float, count: float, rest: float) -> None:
    """Set up a voyage of ``count`` steps of ``length`` [s] and a last shorter one, ``rest`` [s]."""
    control[CLOCK], control[LENGTH], control[PLANNED], control[REST] = 0.0, length, count, rest
    control[NEXT], control[COUNT], control[TRIES] = length, count, 0.0
    if count == 0.0:
        begin_last_step(control)


def begin_last_step(control: StepState) -> int:
    """Set up the last, shorter step, or end the voyage."""
    if not control[REST] > 0.0:
        return FINISHED
    control[LENGTH], control[PLANNED], control[REST] = control[REST], 1.0, 0.0
    control[NEXT], control[COUNT], control[TRIES] = control[LENGTH], 1.0, 0.0
    return ON


def clearance_left(clearance: float, before: float, leaves: float) -> float:
    """Return the clearance beyond the share that a step must leave [m]; ``leaves`` is over 0 for infinite suction."""
    return clearance - leaves * before if leaves > 0.0 else clearance


def is_sane(
    u: float, v: float, r: float, clearance: float, near: float, leaves: float, most_speed: float, most_rate: float
) -> bool:
    """Return whether the numbers are physical; a ship drawn to a bank that ends its voyage may have any speed."""
    if leaves > 0.0 and clearance <= near:
        return True
    slow: bool = abs(u) < most_speed and abs(v) < most_speed
    return slow and abs(r) < most_rate and clearance == clearance  # not NaN


def cause(heading: float, ahead: float, astern: float, afloat: float, tolerance: float) -> int:
    """Return which end is met when no clearance is left, from the margins to all ends except the bank."""
    if heading <= tolerance:
        return OUTSIDE
    if afloat <= TOO_FAST:
        return SHALLOW
    if ahead <= tolerance:
        return PASSED
    if astern <= tolerance:
        return ASTERN
    return GROUNDED


def accept_step(
    control: StepState, left: float, clearance: float, before: float, sane: bool, tolerance: float, near: float,
    leaves: float,
) -> int:  # fmt: skip
    """Decide how a voyage continues after a try; ``left`` is the number of planned steps left."""
    tried, clear = control[NEXT], clearance_left(clearance, before, leaves)
    if control[TRIES] == 0.0:
        if sane and clear > 0.0:
            control[CLOCK] += control[PLANNED] * tried
            return begin_last_step(control)
        control[CLOCK] += (control[PLANNED] - left - 1.0) * tried
        control[SPAN], control[AFTER] = tried, left
    if sane and abs(clearance) <= tolerance:
        control[CLOCK] += tried
        return CLOSED
    control[TRIES] += 1.0
    if sane and clear > 0.0:
        taken = max(before - clearance, 0.0) if leaves > 0.0 else 0.0
        longer = min(2.0, AIM * (1.0 - leaves) * clearance / taken) if taken > 0.0 else 2.0
        return accept_shorter_step(control, tried, longer, clearance, near)
    if control[TRIES] > MOST_TRIES:
        return LOST
    share = 0.5
    if sane and before > 0.0 and control[TRIES] % HALVE_EACH != 0.0:
        share = max(clearance_left(before, before, leaves) / (before - clearance), SHORTEST)
    control[NEXT], control[COUNT] = share * tried, 1.0
    return BACK


def accept_shorter_step(control: StepState, tried: float, longer: float, clearance: float, near: float) -> int:
    """Accept the valid part of a step and set up the next."""
    control[CLOCK] += tried
    control[SPAN] -= tried
    if control[SPAN] > 1e-13 * control[LENGTH]:  # More than rounding is left
        if control[TRIES] > MOST_TRIES:
            return CLOSED if clearance <= near else LOST
        control[NEXT], control[COUNT] = min(control[SPAN], longer * tried), 1.0
        return ON
    if control[AFTER] == 0.0:
        return begin_last_step(control)
    control[NEXT], control[COUNT], control[PLANNED] = control[LENGTH], control[AFTER], control[AFTER]
    control[TRIES] = 0.0
    return ON
