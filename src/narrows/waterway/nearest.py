"""Lower bounds of where a hull can meet a bank, so cheap that lanes of vessels can ask them at every step."""

from typing import NamedTuple

import numpy as np

from narrows.waterway.room import PORT_BANK, STARBOARD_BANK, TURNED_AWAY
from narrows.waterway.table import WaterwayTable


class LeastWalls(NamedTuple):
    """Lower bounds at the nodes of a table, straight between them."""

    starboard: np.ndarray  # (n,) From the line, square to it at midship, to what a hull can meet of either bank [m]
    port: np.ndarray  # (n,) From the line, square to it at midship, to what a hull can meet of either bank [m]


def least_walls(table: WaterwayTable, outline: np.ndarray) -> LeastWalls:
    """Return lower bounds of where a hull can meet a bank, whatever its heading."""
    # outline (points, 2) [m]
    # With midship at s and n, let w be the bound at s, straight between nodes, and r how far the hull's outline
    # reaches to that side: then w - n - r (to port w + n - r) is never more than the hull can move square to the line
    # before it meets that bank. Where it is positive the hull is clear.
    radius = float(np.hypot(*np.reshape(outline, (-1, 2)).T).max())
    return LeastWalls(*(_least(table, radius, *side) for side in ((STARBOARD_BANK, 1), (PORT_BANK, -1))))


def _least(table: WaterwayTable, radius: float, column: int, sign: int) -> np.ndarray:
    """Least of the bank beside the hull as seen from each node, over the cells on either side of it."""
    # What one point of a bank is from the line, as midship passes a cell, is nearly straight in s; less how far it can
    # sag below its chord, the minimum at the nodes is a bound between them too.
    step, (bend, change) = table.step, _sharpest(table)
    sag = step**2 / 8 * np.stack([bend, change])
    least = np.full(len(table.s), np.inf)
    ends = ((len(least),) * 2, (0, 0))
    columns = np.ascontiguousarray(np.pad(table.nodes, ends, mode="edge")[:, [0, 1, 2, 3, column, column + 1]].T)
    for direction in (-1, 1):
        (before, out_before, *_), left, offset = _seen(columns, sign, 0), np.ones(len(least), bool), 0
        while left.any():
            offset += direction
            ahead, out, line, turned = _seen(columns, sign, offset)
            off = np.maximum(np.abs(out), np.abs(out_before)) * bend
            window = radius + step * (1 + off + bend * bend * step * (radius + 2 * step))
            lowest = _lowest(before, out_before, ahead, out, window) - sag[0] * (1 + off) - sag[1] * window
            least = np.where(left, np.minimum(least, lowest), least)
            passed = np.minimum(direction * ahead, direction * line) > window
            left &= ~(passed | (turned < TURNED_AWAY)) & (abs(offset) <= len(least))
            before, out_before = ahead, out
    return least


def _sharpest(table: WaterwayTable) -> tuple[np.ndarray, np.ndarray]:
    """Greatest curvature [1/m] and rate of curvature [1/m2] in the cells beside each node."""
    bend = np.abs(np.pad(table.curvature, 1, mode="edge"))
    change = np.pad(np.abs(np.diff(table.curvature)) / table.step, 1)
    return np.max([bend[:-2], bend[1:-1], bend[2:]], axis=0), np.maximum(change[:-1], change[1:])


def _seen(columns: np.ndarray, sign: int, offset: int) -> tuple[np.ndarray, ...]:
    """Return the bank so many nodes on, ahead of and out from each node, how far ahead the line is, its direction."""
    count = (columns.shape[1] - 2) // 3  # Beyond either end are as many, and the one that the table has there.
    x, y, c, si, *_ = columns[:, count + 1 : 2 * count + 1]
    line_x, line_y, line_c, line_si, bank_x, bank_y = columns[:, count + 1 + offset : 2 * count + 1 + offset]
    dx, dy = bank_x - x, bank_y - y
    return (
        dx * c + dy * si,
        sign * (dy * c - dx * si),
        (line_x - x) * c + (line_y - y) * si,
        line_c * c + line_si * si,
    )


def _lowest(ahead: np.ndarray, out: np.ndarray, to: np.ndarray, out_to: np.ndarray, window: np.ndarray) -> np.ndarray:
    """Least of an edge of the bank inside the window; infinite where none of it is."""
    along = np.where(to == ahead, 1.0, to - ahead)
    slope = np.where(to == ahead, 0.0, (out_to - out) / along)
    first, last = (np.clip(x, -window, window) for x in (ahead, to))
    inside = (np.minimum(ahead, to) <= window) & (np.maximum(ahead, to) >= -window)
    upright = np.where(to == ahead, np.minimum(out, out_to), np.inf)
    lowest = np.minimum(np.minimum(out + slope * (first - ahead), out + slope * (last - ahead)), upright)
    return np.where(inside, lowest, np.inf)
