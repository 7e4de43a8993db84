"""Integrate one vessel to its end, step by step, and fill a waterway's table: the end of every exported file.

It uses the small part of Python that ``printers.translation`` supports. In the exported file ``step`` and
``least_clearance`` come first, printed from the lines of the model. ``event`` holds the rule for ends of a voyage,
``waterway.bank_clearance`` the distances to its banks.
"""

from math import cos, floor, inf, sin
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
from narrows.waterway.bank_clearance import ROW, advanced_along, exact_clearance

Array: TypeAlias = Any
Filled: TypeAlias = Any
"""Output arrays; one that is filled is never constant."""
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


# The table of a waterway from its sections.
CELL_ENTRIES = 18
"""Numbers per cell of the table."""
STARBOARD, PORT, DEPTH, CURVATURE, FLOW, NEAR, KEEL_STARBOARD, KEEL_PORT = 0, 2, 4, 6, 8, 10, 14, 16
"""Their columns."""
SECTION = 7
"""Numbers per section: along the line; starboard, port, depth, curvature, keel_starboard, keel_port."""
MOST_EXTENT = 1e9
"""Largest place along the line [m]."""
FAR_WIDTHS = 100.0
"""Length of the straight extension beyond the ends [widths]."""


def fill_cells(sections: Array, count: int, nodes: int, table: Filled) -> float:
    """Fill the cells from sections, linear in between, in order along the line; return the cell length [m]."""
    discharge = (sections[1] + sections[2]) * sections[3]
    spacing = (sections[SECTION * (count - 1)] - sections[0]) / (nodes - 1)
    before: int = 0
    for node in range(nodes):
        s = sections[0] + node * spacing
        while before < count - 2 and sections[SECTION * (before + 1)] < s:
            before += 1
        row: int = SECTION * before
        share = (s - sections[row]) / (sections[row + SECTION] - sections[row])
        for column in range(1, SECTION):
            value = sections[row + column] + share * (sections[row + SECTION + column] - sections[row + column])
            put_value(table, nodes, node, 2 * (column - 1) + (KEEL_STARBOARD - FLOW if column > 4 else 0), value)
        wide = node_value(table, nodes, node, STARBOARD) + node_value(table, nodes, node, PORT)
        put_value(table, nodes, node, FLOW, discharge / (wide * node_value(table, nodes, node, DEPTH)))
    for cell in range(nodes - 1):
        for entry in range(NEAR, KEEL_STARBOARD):
            table[CELL_ENTRIES * cell + entry] = 0.0
    return spacing  # type: ignore[no-any-return]


def put_value(table: Filled, nodes: int, node: int, column: int, value: float) -> None:
    """Write a column's value at a node: the start of its cell, and the rise of the one before."""
    entry: int = CELL_ENTRIES * node + column
    if node < nodes - 1:
        table[entry] = value
    if node > 0:
        table[entry - CELL_ENTRIES + 1] = value - table[entry - CELL_ENTRIES]


def node_value(table: Array, nodes: int, node: int, column: int) -> float:
    """Return a column's value at a node; the last node is the end of the last cell."""
    if node < nodes - 1:
        return table[CELL_ENTRIES * node + column]  # type: ignore[no-any-return]
    last: int = CELL_ENTRIES * (nodes - 2) + column
    return table[last] + table[last + 1]  # type: ignore[no-any-return]


def put_node(
    track: Array, node: int, x: float, y: float, heading: float, bend: float, right: float, left: float
) -> None:
    """Write a node of the track: the line, and both banks perpendicular to it."""
    row: int = ROW * node
    c, si = cos(heading), sin(heading)
    track[row], track[row + 1], track[row + 2], track[row + 3], track[row + 4] = x, y, c, si, bend
    track[row + 5], track[row + 6] = x - right * si, y + right * c
    track[row + 7], track[row + 8] = x + left * si, y - left * c


def lay_track(table: Array, nodes: int, spacing: float, track: Filled) -> None:
    """Integrate the line from its curvature, with the banks at the keel and one far node beyond either end."""
    x, y, heading, widest = 0.0, 0.0, 0.0, 0.0
    for node in range(nodes):
        widest = max(widest, node_value(table, nodes, node, KEEL_STARBOARD))
        widest = max(widest, node_value(table, nodes, node, KEEL_PORT))
    beyond = (nodes - 1) * spacing + FAR_WIDTHS * widest
    for node in range(nodes):
        bend = node_value(table, nodes, node, CURVATURE)
        right, left = node_value(table, nodes, node, KEEL_STARBOARD), node_value(table, nodes, node, KEEL_PORT)
        c, si = cos(heading), sin(heading)
        put_node(track, node + 1, x, y, heading, bend, right, left)
        if node == 0:
            put_node(track, 0, x - beyond * c, y - beyond * si, heading, bend, right, left)
        if node == nodes - 1:
            put_node(track, nodes + 1, x + beyond * c, y + beyond * si, heading, bend, right, left)
            return
        change = (node_value(table, nodes, node + 1, CURVATURE) - bend) / spacing
        ahead, across, turned = advanced_along(bend, change, spacing)
        x, y, heading = x + ahead * c - across * si, y + ahead * si + across * c, heading + turned


def can_fill(sections: Array, count: int, nodes: int) -> bool:
    """Return whether there are enough sections and nodes, in order, each with water."""
    if not (count >= 2 and nodes >= 2):
        return False
    for number in range(count):
        row: int = SECTION * number
        if number > 0 and not sections[row] > sections[row - SECTION]:
            return False
        right, left, bend = sections[row + 1], sections[row + 2], sections[row + 4]
        if not (right > 0.0 and left > 0.0 and abs(bend) * max(right, left) < 1.0):
            return False
        if not (sections[row + 3] > 0.0 and sections[row + 5] > 0.0 and sections[row + 6] > 0.0):
            return False
    return abs(sections[0]) < MOST_EXTENT and abs(sections[SECTION * (count - 1)]) < MOST_EXTENT  # type: ignore[no-any-return]


def fill_table(sections: Array, count: int, nodes: int, table: Filled, track: Filled) -> float:
    """Fill table and track of a waterway and return the cell length [m]; 0 if the sections form no waterway."""
    if not can_fill(sections, count, nodes):
        return 0.0
    spacing = fill_cells(sections, count, nodes, table)
    lay_track(table, nodes, spacing, track)
    return spacing
