"""The table of a waterway from its sections: plain arithmetic, translated for exports without Python."""

from math import cos, sin
from typing import Any

from narrows.waterway.bank_clearance import ROW, advanced_along

Array = Any
Filled = Any
"""An output array."""
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
