"""The queue of vessels in a block of lanes: which lane integrates which vessel, arrivals, and contacts.

A lane integrates one vessel until its voyage ends, then takes the next of the queue. Locating a contact costs a few
lane-steps, while the neighbours take whole ones. One compiled copy serves all models: they pass their functions by
address.
"""

from typing import Any, NamedTuple

import numpy as np

from narrows.codegen.addresses import call
from narrows.codegen.free_motion import BOOK, CACHE_LINE, SHARED
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
    begin_voyage,
    cause,
    clearance_left,
    is_sane,
)
from narrows.waterway.bank_clearance import exact_clearance

Array = Any

# Fields of a lane: these, the rest of the state, the state before the step, and the vessel's inputs.
STEP_LENGTH, SHARE, LEFT, FLAG, CLEARANCE, NEARER_SIDE, CLEARANCE_BEFORE = range(len(BOOK))
STATE = len(BOOK)
X, Y, COS, SIN, U, V, R = range(STATE, STATE + 7)
CELLS_A_METRE, MOST_SPEED, MOST_RATE = (SHARED.index(name) for name in ("cells_a_metre", "most_speed", "most_rate"))
RUNNING, AFLOAT, DIVERGED = -1, 0, 2
OUTCOME, SIDE = 0, 1
TOLERANCE, NEAR = 0, 1
# Numba compiles a function once more for an argument that is a Python integer in the source.
NOW: Any = np.int64(0)
FIRST_LANE: Any = np.int64(0)


class LaneProgram(NamedTuple):
    """A model: its functions by address, and the sizes of its lanes."""

    step: int  # Steps every lane; returns whether any needs attention
    clearance_of: int  # Clearance of a lane by the lanes' own rule, and its side [m]
    ends_of: int  # Margins of a lane, now or before the step, to every end but a bank [m]
    kept: int  # Numbers carried from step to step
    fields: int  # Numbers of a lane
    exact: bool  # True if the lanes' clearance is a lower bound, so that a contact needs the exact one
    leaves: float  # Least share of the clearance that a step leaves [1]


class SharedInputs(NamedTuple):
    table: Array  # Cells of the waterway
    shared: Array  # Inputs
    track: Array  # Nodes of line and banks
    outline: Array  # Points of the hull [m]
    limits: Array  # Tolerance of a contact, and distance at which a diverging motion counts as contact [m]


def true_clearance(program: LaneProgram, block: Array, lane: int, first: int, water: SharedInputs) -> Any:
    """Return the clearance of a lane by the banks themselves and by the other ends of a voyage, and its side [m]."""
    x, y = block[first + X, lane], block[first + Y, lane]
    cosine, sine = block[first + COS, lane], block[first + SIN, lane]
    clearance, side = exact_clearance(water.track, 1.0 / water.shared[CELLS_A_METRE], x, y, cosine, sine, water.outline)
    ends = ends_of(program, block, lane, first, water)
    return min(clearance, ends[0], ends[1], ends[2], ends[3]), side


def ends_of(program: LaneProgram, block: Array, lane: int, first: int, water: SharedInputs) -> Array:
    """Return the margins of a lane to every end but a bank [m]."""
    ends = np.empty(4, block.dtype)
    call(program.ends_of, (block, lane, first, water.table, water.shared, ends))
    return ends


def is_sane_lane(leaves: float, block: Array, lane: int, clearance: float, shared: Array, near: float) -> bool:
    u, v, r = block[U, lane], block[V, lane], block[R, lane]
    return is_sane(u, v, r, clearance, near, leaves, shared[MOST_SPEED], shared[MOST_RATE])


def cause_of(program: LaneProgram, block: Array, lane: int, water: SharedInputs, tolerance: float) -> int:
    ends = ends_of(program, block, lane, NOW, water)
    return cause(ends[0], ends[1], ends[2], ends[3], tolerance)


def handle_event(program: LaneProgram, block: Array, lane: int, control: Array, water: SharedInputs) -> int:
    """Handle a lane that a step has flagged: return an outcome, or RUNNING with the next step set up."""
    clearance, before = block[CLEARANCE, lane], block[CLEARANCE_BEFORE, lane]
    left = block[LEFT, lane]
    tolerance, near, leaves = water.limits[TOLERANCE], water.limits[NEAR], program.leaves
    sane = is_sane_lane(leaves, block, lane, clearance, water.shared, near)
    if program.exact and sane and (clearance <= 0.0 or control[TRIES] > 0.0):
        # The lanes' own clearance is a lower bound: compute the exact one.
        clearance, block[NEARER_SIDE, lane] = true_clearance(program, block, lane, NOW, water)
    if sane and clearance_left(clearance, before, leaves) > 0.0 and control[TRIES] == 0.0 and left > 0.0:
        return RUNNING
    if program.exact and (control[TRIES] > 0.0 or not (sane and clearance > 0.0)):
        before = true_clearance(program, block, lane, program.kept, water)[0]
    outcome = accept_step(control, left, clearance, before, sane, tolerance, near, leaves)
    if outcome == CLOSED:
        return cause_of(program, block, lane, water, near if clearance > tolerance else tolerance)
    if outcome == FINISHED:
        return AFLOAT
    if outcome in (LOST, BACK):
        for field in range(STATE, STATE + program.kept):
            block[field, lane] = block[program.kept + field, lane]
        block[CLEARANCE, lane] = before
    if outcome == LOST:
        return cause_of(program, block, lane, water, near) if before <= near else DIVERGED
    block[STEP_LENGTH, lane], block[LEFT, lane] = control[NEXT], control[COUNT]
    return RUNNING


def load_lane(
    program: LaneProgram, block: Array, lane: int, control: Array, water: SharedInputs, start: Array, times: Array,
    inputs: Array,
) -> int:  # fmt: skip
    """Put a vessel into a lane; return its outcome if the voyage ends where it begins, else RUNNING."""
    for number in range(program.kept):
        block[STATE + number, lane] = start[number]
        block[STATE + program.kept + number, lane] = start[number]
    for number in range(len(inputs)):
        block[STATE + 2 * program.kept + number, lane] = inputs[number]
    own = np.empty(2, block.dtype)
    call(program.clearance_of, (block, lane, water.table, water.shared, own))
    clearance, side = own[0], own[1]
    if program.exact and clearance <= 0.0:
        clearance, side = true_clearance(program, block, lane, NOW, water)
    block[CLEARANCE, lane], block[NEARER_SIDE, lane] = clearance, side
    begin_voyage(control, times[0], times[1], times[2])
    block[STEP_LENGTH, lane], block[LEFT, lane] = control[NEXT], control[COUNT]
    if not is_sane_lane(program.leaves, block, lane, clearance, water.shared, 0.0):
        return DIVERGED
    if not clearance > 0.0:
        outcome = cause_of(program, block, lane, water, 0.0)
        if clearance < 0.0 or outcome != ASTERN:  # The first point of a waterway belongs to it
            return outcome
    return RUNNING if block[LEFT, lane] > 0.0 else AFLOAT


def idle_lane(block: Array, lane: int) -> None:
    for field in (Y, SIN, V, R, STEP_LENGTH):
        block[field, lane] = 0.0
    block[COS, lane] = 1.0
    block[LEFT, lane] = np.inf


def unload_lane(
    block: Array, lane: int, control: Array, vessel: int, outcome: int, end: Array, time: Array, codes: Array
) -> None:
    """Write place, time and outcome of a voyage's end, and leave the lane empty."""
    for number in range(end.shape[1]):
        end[vessel, number] = block[STATE + number, lane]
    time[vessel] = control[CLOCK]
    side = block[NEARER_SIDE, lane]
    codes[vessel, OUTCOME] = outcome
    codes[vessel, SIDE] = int(side > 0.0) - int(side < 0.0) if outcome == GROUNDED else 0
    idle_lane(block, lane)


def integrate_fleet(
    sizes: Array, leaves: float, table: Array, shared: Array, track: Array, outline: Array, limits: Array,
    start: Array, times: Array, vessel_inputs: Array, end: Array, time: Array, codes: Array,
    memory: Array, books: Array, who: Array,
) -> int:  # fmt: skip
    """Integrate every vessel to its end; return the number of lane-steps."""
    # ``sizes`` and ``leaves`` are those of the program: Numba takes 20 us to unpack a named tuple of a caller.
    program = LaneProgram(sizes[0], sizes[1], sizes[2], sizes[3], sizes[4], sizes[5] != 0, leaves)
    water = SharedInputs(table, shared, track, outline, limits)
    first = -(memory.ctypes.data // memory.itemsize) % CACHE_LINE
    lanes, size = len(who), program.fields * len(who)
    block = memory[first : first + size].reshape(program.fields, lanes)  # a vector on two cache lines costs twice
    rows = vessel_inputs.shape[0]  # One row serves all if nothing varies
    active, lane_steps, queue, vessels = 0, 0, 0, len(codes)
    load_lane(program, block, FIRST_LANE, books[0], water, start[0], times[0], vessel_inputs[0])
    idle_lane(block, FIRST_LANE)
    block[FLAG, 0] = 1.0
    for field in range(program.fields):
        block[field] = block[field, 0]
    who[:] = -1
    flagged = True
    while True:
        for lane in range(lanes if flagged else 0):
            if block[FLAG, lane] == 0.0:
                continue
            if who[lane] >= 0:
                outcome = handle_event(program, block, lane, books[lane], water)
                if outcome == RUNNING:
                    continue
                unload_lane(block, lane, books[lane], who[lane], outcome, end, time, codes)
                who[lane], active = -1, active - 1
            while queue < vessels:
                inputs = vessel_inputs[min(queue, rows - 1)]
                outcome = load_lane(program, block, lane, books[lane], water, start[queue], times[queue], inputs)
                queue += 1
                if outcome == RUNNING:
                    who[lane], active = queue - 1, active + 1
                    break
                unload_lane(block, lane, books[lane], queue - 1, outcome, end, time, codes)
        if active == 0:
            return lane_steps
        flagged = call(program.step, (block, water.table, water.shared)) != 0
        lane_steps += lanes
