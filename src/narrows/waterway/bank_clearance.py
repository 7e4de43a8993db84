"""Clearance between a hull and the banks of a table, edge by edge: plain arithmetic, compiled or not."""

from collections.abc import Sequence
from math import cos, hypot, inf, nan, sin

ROW = 9
"""Numbers per node: line forward, starboard [m], cosine, sine, curvature [1/m]; starboard bank, port bank [m]."""
STARBOARD_BANK, PORT_BANK = 5, 7
"""Places of the banks in a node."""
TURNED_AWAY = -0.5
"""Cosine between line and hull below which a bank belongs to another reach of the river."""
GAUSS = 0.7745966692414834
"""Outer node of three-point Gauss-Legendre quadrature, sqrt(3/5)."""


def advanced_along(bend: float, change: float, along: float) -> tuple[float, float, float]:
    """Return the displacement ahead and across [m] and the turn [rad] along a line of linear curvature."""
    # bend [1/m]; change [1/m^2]; along [m]
    ahead, across = 0.0, 0.0
    for node in range(-1, 2):
        d, weight = 0.5 * along * (1.0 + node * GAUSS), 8.0 if node == 0 else 5.0
        turned = d * (bend + 0.5 * d * change)
        ahead += weight * cos(turned)
        across += weight * sin(turned)
    turned = along * (bend + 0.5 * along * change)
    return ahead * along / 18.0, across * along / 18.0, turned


def line_pose(track: Sequence[float], step: float, s: float) -> tuple[float, float, float, float, int]:
    """Return the line at a place in the table's own frame: forward, starboard [m], cosine, sine, and the cell."""
    # track (n * ROW,); step [m]; s [m]
    last: int = len(track) // ROW - 4
    cell: int = int(min(max(0.0, s / step), float(last)))
    along = min(max(0.0, s - cell * step), step)
    row: int = (cell + 1) * ROW
    bend, change = track[row + 4], (track[row + ROW + 4] - track[row + 4]) / step
    ahead, across, turned = advanced_along(bend, change, along)
    beyond = s - cell * step - along
    ahead += beyond * cos(turned)
    across += beyond * sin(turned)
    c, si = track[row + 2], track[row + 3]
    return (
        track[row] + ahead * c - across * si,
        track[row + 1] + ahead * si + across * c,
        c * cos(turned) - si * sin(turned),
        si * cos(turned) + c * sin(turned),
        cell,
    )


def edge_clearance(
    a: float, b: float, next_a: float, next_b: float, sign: float, outline: Sequence[float], least: float
) -> float:
    """Return the smaller of a given clearance and that between one edge of a bank and the hull [m]."""
    # a, b, next_a, next_b [m]; outline (2 * points,) [m]; least [m]
    forward, out = outline[len(outline) - 2], sign * outline[len(outline) - 1]
    for point in range(0, len(outline), 2):
        before, out_before = forward, out
        forward, out = outline[point], sign * outline[point + 1]
        if (a - forward) * (next_a - forward) <= 0.0 and a != next_a:
            least = min(least, b + (next_b - b) * (forward - a) / (next_a - a) - out)
        if (before - a) * (forward - a) <= 0.0 and before != forward:
            least = min(least, b - out_before - (out - out_before) * (a - before) / (forward - before))
    return least


def side_clearance(
    track: Sequence[float], sign: float, cell: int,
    x: float, y: float, c: float, si: float, outline: Sequence[float],
) -> float:  # fmt: skip
    """Return the least transverse clearance between a hull and one bank [m]."""
    # track (n * ROW,); x, y [m]; outline (2 * points,) [m]
    column: int = STARBOARD_BANK if sign > 0.0 else PORT_BANK
    stern, bow, breadth, across, least = 0.0, 0.0, 0.0, 0.0, inf
    aft, fore = 0.0, 0.0
    for point in range(0, len(outline), 2):
        forward, out = outline[point], sign * outline[point + 1]
        stern, bow, across = min(stern, forward), max(bow, forward), min(across, out)
        if out > breadth:
            breadth, aft, fore = out, forward, forward
        elif out == breadth:
            aft, fore = min(aft, forward), max(fore, forward)
    for direction in range(-1, 2, 2):
        end = bow if direction > 0 else -stern
        row: int = (cell + 1) * ROW
        dx, dy = track[row + column] - x, track[row + column + 1] - y
        a, b = dx * c + dy * si, sign * (dy * c - dx * si)
        while True:
            row += direction * ROW
            dx, dy = track[row + column] - x, track[row + column + 1] - y
            next_a, next_b = dx * c + dy * si, sign * (dy * c - dx * si)
            if min(b, next_b) - breadth < least:
                if min(a, next_a) > aft and max(a, next_a) < fore:  # along the parallel body
                    least = min(b, next_b) - breadth
                else:
                    least = edge_clearance(a, b, next_a, next_b, sign, outline, least)
            along = direction * ((track[row] - x) * c + (track[row + 1] - y) * si)
            # A bank that returns over the hull's end after the line has passed it is farther away than before.
            if min(along, direction * next_a) > end or track[row + 2] * c + track[row + 3] * si < TURNED_AWAY:
                break
            if row == 0 or row + ROW >= len(track):
                break
            # A bank that has passed ahead of the hull to its other side belongs to another reach of the river.
            if direction * next_a > end and next_b < across:
                break
            a, b = next_a, next_b
    return least


def exact_clearance(
    track: Sequence[float], step: float, s: float, n: float, cos_psi: float, sin_psi: float, outline: Sequence[float]
) -> tuple[float, float]:
    """Return the least transverse clearance between hull and banks, and by how much starboard is nearer [m]."""
    # track (n * ROW,); step [m]; s, n [m]; outline (2 * points,) [m]. Over the whole length of the hull: every bank
    # node against the hull, every hull point against the edges.
    if not hypot(s, n) + hypot(cos_psi, sin_psi) < inf:
        return nan, nan
    cell: int
    x, y, c, si, cell = line_pose(track, step, s)
    x, y = x - n * si, y + n * c
    c, si = c * cos_psi - si * sin_psi, si * cos_psi + c * sin_psi
    starboard = side_clearance(track, 1.0, cell, x, y, c, si, outline)
    port = side_clearance(track, -1.0, cell, x, y, c, si, outline)
    return min(starboard, port), port - starboard
