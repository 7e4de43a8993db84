"""Outcome of a step that crossed a bank or produced numbers out of range: one rule for every engine.

A voyage in Python calls these functions directly; all kernels call one compiled copy. A step through a bank is undone
and tried shorter, by the secant of the clearance. A valid step without contact is accepted, and the next try starts
from there. So a contact is located within the step, even where the suction grows without bound towards it.
"""

from typing import Any

StepState = Any
"""State of the step control: an array or a list of numbers, by the indices below."""
CLOCK, LENGTH, PLANNED, NEXT, COUNT, TRIES, SPAN, AFTER, REST, PLACES = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9
"""Step control: seconds before the current segment of equal steps; their length, their planned number; length of the
next try, and how many of it; tries within the current step; the rest of that step, and the whole steps after it; the
last, shorter step; count of these places."""
ON, BACK, FINISHED, CLOSED, LOST = -1, -2, 0, 1, 2
"""After a try: ON from here; BACK to before the try, for a shorter one; FINISHED: the time is up; CLOSED: a bank or an
end is met here; LOST: the numbers ran out."""
GROUNDED, OUTSIDE, ASTERN, PASSED, SHALLOW = 1, 3, 4, 5, 7
"""Contacts that end a voyage: a bank, the limit of heading, an end of the waterway, too little water."""
TOO_FAST = 1e-6
"""Tolerance of the speed at which a ship touches the bottom or chokes the section [m/s]."""
MOST_TRIES, HALVE_EACH = 600, 8
"""Most tries within a step; every eighth halves the step instead of the secant."""
SHORTEST = 0.1
"""Shortest next try, as a share of the last."""
AIM = 0.8
"""Share of the available clearance that the next step aims at."""


def begin(book: StepState, length: float, count: float, rest: float) -> None:
    """Set up a voyage of equal steps and a last shorter one."""
    book[CLOCK], book[LENGTH], book[PLANNED], book[REST] = 0.0, length, count, rest
    book[NEXT], book[COUNT], book[TRIES] = length, count, 0.0
    if count == 0.0:
        last_step(book)


def last_step(book: StepState) -> int:
    """Set up the last, shorter step, or end the voyage."""
    if not book[REST] > 0.0:
        return FINISHED
    book[LENGTH], book[PLANNED], book[REST] = book[REST], 1.0, 0.0
    book[NEXT], book[COUNT], book[TRIES] = book[LENGTH], 1.0, 0.0
    return ON


def cleared(clearance: float, before: float, leaves: float) -> float:
    """Return the clearance left beyond the required share [m]; the share matters where suction becomes infinite."""
    return clearance - leaves * before if leaves > 0.0 else clearance


def cause(heading: float, ahead: float, astern: float, afloat: float, tolerance: float) -> int:
    """Return which end is met when no clearance is left, by the margins to every end but a bank."""
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
    book: StepState,
    left: float,
    clearance: float,
    before: float,
    sane: bool,
    tolerance: float,
    near: float,
    leaves: float,
) -> int:
    """Decide how a voyage continues after a try; ``left`` is the number of planned steps left."""
    tried, clear = book[NEXT], cleared(clearance, before, leaves)
    if book[TRIES] == 0.0:
        if sane and clear > 0.0:
            book[CLOCK] += book[PLANNED] * tried
            return last_step(book)
        book[CLOCK] += (book[PLANNED] - left - 1.0) * tried
        book[SPAN], book[AFTER] = tried, left
    if sane and abs(clearance) <= tolerance:
        book[CLOCK] += tried
        return CLOSED
    book[TRIES] += 1.0
    if sane and clear > 0.0:
        taken = max(before - clearance, 0.0) if leaves > 0.0 else 0.0
        longer = min(2.0, AIM * (1.0 - leaves) * clearance / taken) if taken > 0.0 else 2.0
        return advanced(book, tried, longer, clearance, near)
    if book[TRIES] > MOST_TRIES:
        return LOST
    share = 0.5
    if sane and before > 0.0 and book[TRIES] % HALVE_EACH != 0.0:
        share = max(cleared(before, before, leaves) / (before - clearance), SHORTEST)
    book[NEXT], book[COUNT] = share * tried, 1.0
    return BACK


def advanced(book: StepState, tried: float, longer: float, clearance: float, near: float) -> int:
    """Accept the valid part of a step and set up the next."""
    book[CLOCK] += tried
    book[SPAN] -= tried
    if book[SPAN] > 1e-13 * book[LENGTH]:
        if book[TRIES] > MOST_TRIES:
            return CLOSED if clearance <= near else LOST
        book[NEXT], book[COUNT] = min(book[SPAN], longer * tried), 1.0
        return ON
    if book[AFTER] == 0.0:
        return last_step(book)
    book[NEXT], book[COUNT], book[PLANNED], book[TRIES] = book[LENGTH], book[AFTER], book[AFTER], 0.0
    return ON
