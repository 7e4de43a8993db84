"""The bookkeeping of a block of lanes: who sails in which, who has arrived, and where exactly a hull met a bank.

Never imported: its text ends every generated kernel, below the functions of that model (see ``kernel``), so that
Numba keeps the whole as one file. A block is ONE flat array, field after field, each field LANES long.

A vessel is one lane's work until something ends its voyage; then the lane takes the next vessel from the queue.
When a step carried a hull through a bank the lane goes back to where it was and tries a shorter step, sized by the
secant of the gap, beside its neighbours' whole ones: locating a contact costs two or three lane-steps.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeVar

    Function = TypeVar("Function", bound=Callable[..., Any])
    Array = np.ndarray[Any, Any]
    LANES = FIELDS = 0
    real = np.float64

    def jit(function: Function) -> Function:
        """Compile."""

    def cached(function: Function) -> Function:
        """Compile once for all processes."""

    def gap(y: float, cos_psi: float, sin_psi: float, *constants: float) -> float:
        """Room between hull and bank [m]."""

    def lean(y: float, cos_psi: float, sin_psi: float, *constants: float) -> float:
        """Positive where starboard is the nearer bank."""

    def step(block: Array, limits: Array, constants: Any) -> bool:
        """Step every lane; return whether any wants attention."""

    def uniform(constants: Array) -> Any:
        """Give the constants of the whole fleet."""

    def of_lane(block: Array, lane: int, constants: Any) -> Any:
        """Give the constants of a lane."""

    def take_constants(block: Array, lane: int, constants: Array, vessel: int) -> None:
        """Copy a vessel's own constants into her lane."""


# fields of a lane: the state, as STATE orders it, then these; OLD is the state before the last step
STATE_FIELDS, Y, COS, SIN, U, V, R = 7, 1, 2, 3, 4, 5, 6
STEP, LEFT, FLAG, OLD = 7, 8, 9, 10
# a lane's page in the book: whole steps planned and left; seconds into the last step; the rest of that step and the
# gap at either end of it; tries to meet the bank in it
STEPS, REMAINING, CLOCK, SPAN, LOW, HIGH, TRIES, COLUMNS = 0, 1, 2, 3, 4, 5, 6, 7
OUTCOME, SIDE, COUNT = 0, 1, 2
# entries of limits
LEAST_COS, MOST_SPEED, MOST_RATE, TOLERANCE, NEAR = 0, 1, 2, 3, 4
RUNNING, AFLOAT, GROUNDED, DIVERGED, OUTSIDE = -1, 0, 1, 2, 3
MOST_TRIES, HALVE_EACH = 80, 8
CACHE_LINE = 16  # numbers: 64 bytes in single precision, two lines in double


@jit
def restore(block: "Array", lane: int) -> None:
    for field in range(STATE_FIELDS):
        block[field * LANES + lane] = block[(OLD + field) * LANES + lane]


@jit
def room_of(block: "Array", lane: int, constants: "Any") -> float:
    return gap(block[Y * LANES + lane], block[COS * LANES + lane], block[SIN * LANES + lane], *constants)


@jit
def is_sane(block: "Array", lane: int, room: float, limits: "Array") -> bool:
    slow = abs(block[U * LANES + lane]) < limits[MOST_SPEED] and abs(block[V * LANES + lane]) < limits[MOST_SPEED]
    return slow and abs(block[R * LANES + lane]) < limits[MOST_RATE] and room == room  # not NaN


@jit
def shorten(block: "Array", lane: int, book: "Array", limits: "Array") -> int:
    """Set up the next try from the secant of the gap, now and then a half in case the secant crawls."""
    book[lane, TRIES] += 1
    if book[lane, TRIES] > MOST_TRIES:
        return GROUNDED if book[lane, LOW] <= limits[NEAR] else DIVERGED
    share = 0.5
    if book[lane, HIGH] < 0 and book[lane, TRIES] % HALVE_EACH != 0:
        share = book[lane, LOW] / (book[lane, LOW] - book[lane, HIGH])
    block[STEP * LANES + lane] = share * book[lane, SPAN]
    block[LEFT * LANES + lane] = 1
    return RUNNING


@jit
def attend(block: "Array", lane: int, book: "Array", limits: "Array", constants: "Any") -> int:
    """Say what becomes of a lane that a step has flagged: an outcome, or RUNNING with a shorter step set up."""
    room = room_of(block, lane, constants)
    sane = is_sane(block, lane, room, limits)
    tried = block[STEP * LANES + lane]
    if book[lane, TRIES] == 0:
        book[lane, REMAINING], book[lane, CLOCK], book[lane, SPAN] = block[LEFT * LANES + lane], 0.0, tried
        if sane and room > 0:
            book[lane, CLOCK] = tried
            return OUTSIDE if block[COS * LANES + lane] <= limits[LEAST_COS] else AFLOAT
    if sane and abs(room) <= limits[TOLERANCE]:
        book[lane, CLOCK] += tried
        return GROUNDED
    if sane and room > 0:
        book[lane, CLOCK] += tried
        book[lane, SPAN] -= tried
        book[lane, LOW] = room
    else:
        book[lane, SPAN] = tried
        book[lane, HIGH] = room if sane else np.nan
        restore(block, lane)
        book[lane, LOW] = room_of(block, lane, constants)
    return shorten(block, lane, book, limits)


@jit
def board(block: "Array", lane: int, book: "Array", vessel: int, start: "Array", pace: "Array", steps: "Array") -> None:
    for field in range(STATE_FIELDS):
        block[field * LANES + lane] = start[vessel, field]
        block[(OLD + field) * LANES + lane] = start[vessel, field]
    block[STEP * LANES + lane] = pace[vessel]
    block[LEFT * LANES + lane] = steps[vessel]
    book[lane, STEPS], book[lane, TRIES] = steps[vessel], 0


@jit
def park(block: "Array", lane: int) -> None:
    """Leave an empty lane on the centreline, with steps of no length."""
    for field in (Y, SIN, V, R, STEP):
        block[field * LANES + lane] = 0
    block[COS * LANES + lane] = 1
    block[LEFT * LANES + lane] = np.inf


@jit
def arrive(block: "Array", lane: int, book: "Array", vessel: int, end: "Array", fate: int, codes: "Array") -> int:
    """Write where a voyage ended and how; return the whole steps before its last."""
    for field in range(STATE_FIELDS):
        end[vessel, field] = block[field * LANES + lane]
    steps = int(book[lane, STEPS] - book[lane, REMAINING])
    codes[vessel, OUTCOME], codes[vessel, COUNT] = fate, steps
    return steps - 1


@jit
def side_of(block: "Array", lane: int, fate: int, constants: "Any") -> int:
    if fate != GROUNDED:
        return 0
    y, cosine, sine = block[Y * LANES + lane], block[COS * LANES + lane], block[SIN * LANES + lane]
    leaning = lean(y, cosine, sine, *constants)
    return (leaning > 0) - (leaning < 0)


@jit
def next_of(queue: int, codes: "Array") -> int:
    while queue < len(codes) and codes[queue, OUTCOME] != RUNNING:
        queue += 1
    return queue


@jit
def aligned(memory: "Array") -> "Array":
    """The part that starts with a cache line: a vector that straddles two costs twice."""
    first = -(memory.ctypes.data // memory.itemsize) % CACHE_LINE
    return memory[first : first + FIELDS * LANES]


@cached
def fleet(
    start: "Array", pace: "Array", steps: "Array", constants: "Array", limits: "Array",
    end: "Array", time: "Array", codes: "Array",
) -> int:  # fmt: skip
    """Sail every vessel whose outcome is RUNNING to her end; return the lane-steps that it took."""
    block, book = aligned(np.zeros((FIELDS + 1) * LANES, real)), np.zeros((LANES, COLUMNS))
    who, shared = np.empty(LANES, np.int64), uniform(constants)
    active, lane_steps, queue = 0, 0, next_of(np.int64(0), codes)  # type: ignore[arg-type]
    for lane in range(LANES):
        who[lane] = -1
        park(block, lane)
        block[FLAG * LANES + lane] = 1
    flagged = True
    while True:
        for lane in range(LANES if flagged else 0):
            if block[FLAG * LANES + lane] == 0:
                continue
            vessel = who[lane]
            if vessel >= 0:
                own = of_lane(block, lane, shared)
                fate = attend(block, lane, book, limits, own)
                if fate == RUNNING:
                    continue
                whole = arrive(block, lane, book, vessel, end, fate, codes)
                time[vessel] = whole * pace[vessel] + book[lane, CLOCK]
                codes[vessel, SIDE] = side_of(block, lane, fate, own)
                who[lane], active = -1, active - 1
                park(block, lane)
            if queue < len(codes):
                who[lane], active = queue, active + 1
                board(block, lane, book, queue, start, pace, steps)
                take_constants(block, lane, constants, queue)
                queue = next_of(queue + 1, codes)
        if active == 0:
            return lane_steps
        flagged = step(block, limits, shared)
        lane_steps += LANES
