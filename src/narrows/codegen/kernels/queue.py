"""The queue of vessels in a block of lanes: which lane integrates which vessel, arrivals, and contacts.

This text is appended to every generated kernel, below ``step`` and ``room_of`` of that model, so that Numba stores the
whole as one file. A lane integrates one vessel until its voyage ends, then takes the next of the queue. Locating a
contact costs a few lane-steps, while the neighbours take whole ones.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeVar

    from narrows.codegen.kernels.event import (
        ASTERN,
        BACK,
        CLOCK,
        CLOSED,
        COUNT,
        FINISHED,
        GROUNDED,
        LOST,
        NEXT,
        TRIES,
        accept_step,
        begin,
        cause,
        cleared,
    )  # fmt: skip

    Function = TypeVar("Function", bound=Callable[..., Any])
    Array = np.ndarray[Any, Any]
    LANES = FIELDS = KEPT = FIRST = NOW = OLD = STEP_LENGTH = LEFT = FLAG = ROOM = LEAN = ROOM_BEFORE = (
        FIRST_VESSEL_INPUT
    ) = 0
    X = Y = COS = SIN = U = V = R = AT_MOST_SPEED = AT_MOST_RATE = AT_CELLS_A_METRE = 0
    EXACT = False
    LEAVES = 0.0
    real = np.float64

    def called(function: Function) -> Function:
        """Compile."""

    def cached(function: Function) -> Function:
        """Compile once for all processes."""

    def room_of(block: Array, lane: int, table: Array, shared: Array) -> tuple[float, float]:
        """Clearance of a lane by the lanes' own rule, and its side [m]."""

    def ends_of(block: Array, lane: int, first: int, table: Array, shared: Array) -> tuple[float, float, float, float]:
        """Margins of a lane, now or before the step, to every end but a bank."""

    def exact_room(track: Array, step: float, s: float, n: float, c: float, si: float, outline: Array) -> Any:
        """Exact clearance from the banks themselves, and the side [m]."""

    def step(block: Array, table: Array, shared: Array) -> bool:
        """Step every lane; return whether any needs attention."""
elif __name__ == "narrows.codegen.kernels.queue":  # Imported alone, by tools that import all modules
    called = cached = staticmethod


RUNNING, AFLOAT, DIVERGED = -1, 0, 2
OUTCOME, SIDE = 0, 1
TOLERANCE, NEAR = 0, 1
CACHE_LINE = 16  # numbers: 64 bytes in single precision, two lines in double


@called
def true_room(
    block: "Array", lane: int, first: int, table: "Array", track: "Array", outline: "Array", shared: "Array"
) -> "Any":
    """Clearance of a lane by the banks themselves and by the other ends of a voyage, and its side [m]."""
    x, y = block[(first + X) * LANES + lane], block[(first + Y) * LANES + lane]
    cosine, sine = block[(first + COS) * LANES + lane], block[(first + SIN) * LANES + lane]
    room, lean = exact_room(track, 1.0 / shared[AT_CELLS_A_METRE], x, y, cosine, sine, outline)
    heading, ahead, astern, afloat = ends_of(block, lane, first, table, shared)
    return min(room, heading, ahead, astern, afloat), lean


@called
def is_sane(block: "Array", lane: int, room: float, shared: "Array", near: float) -> bool:
    """Return whether the numbers are physical; a ship drawn to a bank that ends its voyage may have any speed."""
    if LEAVES > 0.0 and room <= near:
        return True
    most = shared[AT_MOST_SPEED]
    slow = abs(block[U * LANES + lane]) < most and abs(block[V * LANES + lane]) < most
    return slow and abs(block[R * LANES + lane]) < shared[AT_MOST_RATE] and room == room  # not NaN


@called
def cause_of(block: "Array", lane: int, table: "Array", shared: "Array", tolerance: float) -> int:
    """Return which end is met when the clearance is zero."""
    heading, ahead, astern, afloat = ends_of(block, lane, NOW, table, shared)
    return cause(heading, ahead, astern, afloat, tolerance)


@called
def handle_event(
    block: "Array",
    lane: int,
    book: "Array",
    table: "Array",
    shared: "Array",
    track: "Array",
    outline: "Array",
    limits: "Array",
) -> int:
    """Handle a lane that a step has flagged: return an outcome, or RUNNING with the next step set up."""
    room, before, left = block[ROOM * LANES + lane], block[ROOM_BEFORE * LANES + lane], block[LEFT * LANES + lane]
    sane = is_sane(block, lane, room, shared, limits[NEAR])
    if EXACT and sane and (room <= 0.0 or book[lane, TRIES] > 0.0):
        # The lanes' own clearance is a lower bound: compute the exact one.
        room, block[LEAN * LANES + lane] = true_room(block, lane, NOW, table, track, outline, shared)
    if sane and cleared(room, before, LEAVES) > 0.0 and book[lane, TRIES] == 0.0 and left > 0.0:
        return RUNNING
    if EXACT and (book[lane, TRIES] > 0.0 or not (sane and room > 0.0)):
        before = true_room(block, lane, OLD, table, track, outline, shared)[0]
    outcome = accept_step(book[lane], left, room, before, sane, limits[TOLERANCE], limits[NEAR], LEAVES)
    if outcome == CLOSED:
        return cause_of(block, lane, table, shared, limits[NEAR] if room > limits[TOLERANCE] else limits[TOLERANCE])
    if outcome == FINISHED:
        return AFLOAT
    if outcome in (LOST, BACK):
        for field in range(KEPT):
            block[field * LANES + lane] = block[(OLD + field) * LANES + lane]
        block[ROOM * LANES + lane] = before
    if outcome == LOST:
        return cause_of(block, lane, table, shared, limits[NEAR]) if before <= limits[NEAR] else DIVERGED
    block[STEP_LENGTH * LANES + lane], block[LEFT * LANES + lane] = book[lane, NEXT], book[lane, COUNT]
    return RUNNING


@called
def load_lane(
    block: "Array", lane: int, book: "Array", vessel: int, start: "Array", times: "Array", vessel_inputs: "Array",
    table: "Array", shared: "Array", track: "Array", outline: "Array", limits: "Array",
) -> int:  # fmt: skip
    """Put a vessel into a lane; return its outcome if the voyage ends where it begins, else RUNNING."""
    for field in range(KEPT):
        block[field * LANES + lane] = start[vessel, field]
        block[(OLD + field) * LANES + lane] = start[vessel, field]
    row = min(vessel, vessel_inputs.shape[0] - 1)  # One row serves all if nothing varies
    for field in range(vessel_inputs.shape[1]):
        block[(FIRST_VESSEL_INPUT + field) * LANES + lane] = vessel_inputs[row, field]
    room, lean = room_of(block, lane, table, shared)
    if EXACT and room <= 0.0:
        room, lean = true_room(block, lane, NOW, table, track, outline, shared)
    block[ROOM * LANES + lane], block[LEAN * LANES + lane] = room, lean
    begin(book[lane], times[vessel, 0], times[vessel, 1], times[vessel, 2])
    block[STEP_LENGTH * LANES + lane], block[LEFT * LANES + lane] = book[lane, NEXT], book[lane, COUNT]
    if not is_sane(block, lane, room, shared, 0.0):
        return DIVERGED
    if not room > 0.0:
        outcome = cause_of(block, lane, table, shared, 0.0)
        if room < 0.0 or outcome != ASTERN:  # The first point of a waterway belongs to it
            return outcome
    return RUNNING if block[LEFT * LANES + lane] > 0.0 else AFLOAT


@called
def idle_lane(block: "Array", lane: int) -> None:
    """Put an empty lane on the line, with steps of no length."""
    for field in (Y, SIN, V, R, STEP_LENGTH):
        block[field * LANES + lane] = 0.0
    block[COS * LANES + lane] = 1.0
    block[LEFT * LANES + lane] = np.inf


@called
def unload_lane(
    block: "Array", lane: int, book: "Array", vessel: int, outcome: int, end: "Array", time: "Array", codes: "Array"
) -> None:
    """Write place, time and outcome of a voyage's end."""
    for field in range(KEPT):
        end[vessel, field] = block[field * LANES + lane]
    time[vessel] = book[lane, CLOCK]
    lean = block[LEAN * LANES + lane]
    codes[vessel, OUTCOME] = outcome
    codes[vessel, SIDE] = (lean > 0.0) - (lean < 0.0) if outcome == GROUNDED else 0


@cached
def sail(
    start: "Array", times: "Array", vessel_inputs: "Array", table: "Array", shared: "Array", track: "Array",
    outline: "Array", limits: "Array",
    end: "Array", time: "Array", codes: "Array", memory: "Array", book: "Array", who: "Array",
) -> int:  # fmt: skip
    """Integrate every vessel to its end; return the number of lane-steps."""
    first = -(memory.ctypes.data // memory.itemsize) % CACHE_LINE
    block = memory[first : first + FIELDS * LANES]  # a vector that straddles two cache lines costs twice
    # With the literal 0 Numba would compile ``load_lane`` again.
    active, lane_steps, queue, vessels = 0, 0, FIRST, len(codes)
    for lane in range(LANES):
        who[lane] = -1
        load_lane(block, lane, book, FIRST, start, times, vessel_inputs, table, shared, track, outline, limits)
        idle_lane(block, lane)
        block[FLAG * LANES + lane] = 1.0
    flagged = True
    while True:
        for lane in range(LANES if flagged else 0):
            if block[FLAG * LANES + lane] == 0.0:
                continue
            if who[lane] >= 0:
                outcome = handle_event(block, lane, book, table, shared, track, outline, limits)
                if outcome == RUNNING:
                    continue
                unload_lane(block, lane, book, who[lane], outcome, end, time, codes)
                who[lane], active = -1, active - 1
                idle_lane(block, lane)
            while queue < vessels:
                outcome = load_lane(
                    block, lane, book, queue, start, times, vessel_inputs, table, shared, track, outline, limits
                )
                queue += 1
                if outcome == RUNNING:
                    who[lane], active = queue - 1, active + 1
                    break
                unload_lane(block, lane, book, queue - 1, outcome, end, time, codes)
                idle_lane(block, lane)
        if active == 0:
            return lane_steps
        flagged = step(block, table, shared)
        lane_steps += LANES
