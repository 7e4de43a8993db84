"""Lower bounds of the distance at which a hull meets a bank, cheap enough for every step of vessel lanes."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from narrows.base.errors import InputError
from narrows.waterway.bank_clearance import GAUSS
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
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    radius, step = float(np.hypot(*np.reshape(outline, (-1, 2)).T).max()), table.step
    reach = 2 * (radius + step)
    size = 2 * int(np.ceil(reach / step)) + 1
    bend, bounds = maximum_filter1d(np.abs(table.curvature), size, mode="nearest"), []
    for wall, curvature in ((table.keel_starboard, table.curvature), (table.keel_port, -table.curvature)):
        inside, outside, widest = (
            maximum_filter1d(one, size, mode="nearest") for one in (curvature.clip(0.0), (-curvature).clip(0.0), wall)
        )
        narrowest = minimum_filter1d(wall, size, mode="nearest")
        # A point of the bank at a distance d along the line is ahead by d (1 - (bend d)^2/6 - w inside) at least. The
        # farthest one beside the hull, with an edge of the bank more, and for midship anywhere in the cells next to it:
        share = 1 - (bend * reach) ** 2 / 6 - widest * inside
        far = radius / np.maximum(share, 1e-9) + 2 * step
        # The line turns away from a bank outside its bend, and the normals turn.
        least = narrowest - far**2 / 2 * (outside + widest * bend**2)
        bounds.append(np.where(far <= reach, least, -widest))
    return LeastWalls(*bounds)


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
