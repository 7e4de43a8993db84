"""Lower bounds of the distance at which a hull meets a bank, cheap enough for every step of vessel lanes."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from narrows.base.errors import InputError
from narrows.waterway.bank_clearance import GAUSS, PORT_BANK, STARBOARD_BANK, TURNED_AWAY
from narrows.waterway.centreline import profile_at
from narrows.waterway.waterway import Waterway


class LeastWalls(NamedTuple):
    """Lower bounds at the nodes of a table, linear between them."""

    starboard: np.ndarray  # (n,) Distance from line to starboard bank within reach of the hull [m]
    port: np.ndarray  # (n,) Distance from line to port bank within reach of the hull [m]


@dataclass(frozen=True)
class WaterwayTable:
    """A waterway in equal cells; between nodes its columns and its banks on the map are linear."""

    s: np.ndarray  # (n,) Along the line, from 0 to its length [m]
    starboard: np.ndarray  # (n,) Distance from the line to a vertical wall with the same section of water [m]
    port: np.ndarray  # (n,) Distance from the line to a vertical wall with the same section of water [m]
    # (n,) Distance from the line to contact of keel and bank, or to the wall if that is nearer [m]
    keel_starboard: np.ndarray
    keel_port: np.ndarray  # (n,) Distance from line to contact of keel and bank, or nearer wall [m]
    depth: np.ndarray  # (n,) Depth; NaN if unknown [m]
    curvature: np.ndarray  # (n,) Curvature of the line, to starboard [1/m]
    flow: np.ndarray  # (n,) Current along the line over that of the waterway [1]
    across: np.ndarray | float = 0.0  # (n,) Current to starboard of the line [m/s]
    shear: np.ndarray | float = 0.0  # (n,) Rise of the current along the line to starboard [1/s]

    @property
    def step(self) -> float:
        return float(self.s[-1]) / (len(self.s) - 1)

    @cached_property
    def nodes(self) -> np.ndarray:
        """Nodes of line and banks in the table's own frame, (n + 2, 9): see ``narrows.waterway.bank_clearance.ROW``."""
        # The origin and forward axis are those of the first node. The first row and the last are far beyond the ends,
        # where line and banks are straight.
        far = self.s[-1] + 100 * max(self.keel_starboard.max(), self.keel_port.max())
        x, y, heading = _integrated(self.curvature, self.step)
        c, si = np.cos(heading), np.sin(heading)
        line = np.stack([x, y, c, si, self.curvature], axis=1)
        beyond = line[[0, -1]]
        beyond[:, :2] += np.array([[-far], [far]]) * beyond[:, 2:4]
        line = np.concatenate([beyond[:1], line, beyond[1:]])
        walls = np.pad(np.stack([self.keel_starboard, -self.keel_port], axis=1), ((1, 1), (0, 0)), mode="edge")
        banks = [line[:, :2] + wall[:, None] * line[:, [3, 2]] * [-1, 1] for wall in walls.T]
        return np.concatenate([line, *banks], axis=1)

    @cached_property
    def track(self) -> np.ndarray:
        return np.ascontiguousarray(self.nodes).reshape(-1)


def least_walls(table: WaterwayTable, outline: np.ndarray) -> LeastWalls:
    """Return lower bounds of the distance at which a hull meets a bank, for any heading."""
    # outline (points, 2) [m]. With midship at s and n, let w be the bound at s, linear between nodes, and r the extent
    # of the hull's outline to that side: then w - n - r (to port w + n - r) is at most the distance that the hull can
    # move perpendicular to the line before it meets that bank. If it is positive the hull is clear.
    radius = float(np.hypot(*np.reshape(outline, (-1, 2)).T).max())
    return LeastWalls(*(_least(table, radius, *side) for side in ((STARBOARD_BANK, 1), (PORT_BANK, -1))))


def _least(table: WaterwayTable, radius: float, column: int, sign: int) -> np.ndarray:
    """Least distance of the bank along the hull from each node, over the cells on either side of it."""
    # The position of a bank point relative to the line is nearly linear in s while midship passes a cell. The minimum
    # at the nodes, less the largest sag below the chord, is a bound between them too.
    step = table.step
    # Greatest curvature [1/m] and rate of curvature [1/m2] in the cells beside each node.
    bends, changes = (
        np.pad(np.abs(table.curvature), 1, mode="edge"),
        np.pad(np.abs(np.diff(table.curvature)) / step, 1),
    )
    bend = np.max([bends[:-2], bends[1:-1], bends[2:]], axis=0)
    sag = step**2 / 8 * np.stack([bend, np.maximum(changes[:-1], changes[1:])])
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


def _seen(columns: np.ndarray, sign: int, offset: int) -> tuple[np.ndarray, ...]:
    """Return the bank so many nodes ahead, relative to each node; the line's distance ahead, its direction."""
    count = (columns.shape[1] - 2) // 3  # Equal numbers beyond either end, plus the table's own end node
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
    """Least distance of a bank edge inside the window; infinite if none of it is inside."""
    along = np.where(to == ahead, 1.0, to - ahead)
    slope = np.where(to == ahead, 0.0, (out_to - out) / along)
    first, last = (np.clip(x, -window, window) for x in (ahead, to))
    inside = (np.minimum(ahead, to) <= window) & (np.maximum(ahead, to) >= -window)
    upright = np.where(to == ahead, np.minimum(out, out_to), np.inf)
    lowest = np.minimum(np.minimum(out + slope * (first - ahead), out + slope * (last - ahead)), upright)
    return np.where(inside, lowest, np.inf)


# Largest number of cells in a table.
MOST_CELLS = 1_000_000
# Cells per beam of the ship that keep contact within 0.01 of the beam. A kink of a bank by a slope m between nodes errs
# by m step / 4 (1:10: 0.006 of the beam), a sudden start of a bend by 0.005 of it, the chord of a bank in a bend by
# curvature step^2 / 8 (radius of 30 beams: 0.0003).
STEPS_A_BEAM = 4


def tabulate(waterway: Waterway, draft: float, step: float) -> WaterwayTable:
    length = waterway.line.length
    if not (0 < step < np.inf and 0 < draft < np.inf):
        raise InputError(f"{waterway.name}: a step of {step} m and a draft of {draft} m; give lengths over 0")
    if length / step > MOST_CELLS:
        raise InputError(f"{waterway.name}: {step} m between nodes is too fine for {length:.6g} m; give a longer step")
    s = np.linspace(0, length, int(np.ceil(length / step)) + 1)
    depth = waterway.depth(s)
    banks = (waterway.starboard, waterway.port)
    starboard, port = (bank.wall(s, depth) for bank in banks)
    keel_starboard, keel_port = (
        np.fmin(wall, bank.keel(s, depth - draft)) for wall, bank in zip((starboard, port), banks, strict=True)
    )
    return WaterwayTable(
        s, starboard, port, keel_starboard, keel_port, depth, waterway.line.curvature(s), waterway.flow(s),
        profile_at(waterway.current_across, s), profile_at(waterway.current_shear, s),
    )  # fmt: skip


def _integrated(curvature: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes and headings of a line whose curvature is linear between nodes: three-point Gauss-Legendre per cell."""
    heading = np.concatenate([[0.0], np.cumsum((curvature[1:] + curvature[:-1]) / 2 * step)])
    part = step * np.array([1 - GAUSS, 1, 1 + GAUSS]) / 2
    change = np.diff(curvature)[:, None] / step
    turned = heading[:-1, None] + part * (curvature[:-1, None] + part * change / 2)
    weights = step * np.array([5, 8, 5]) / 18
    x, y = (np.concatenate([[0.0], np.cumsum(f(turned) @ weights)]) for f in (np.cos, np.sin))
    return x, y, heading
