"""A waterway as a table of equal cells, for engines that look it up at every step."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.errors import InputError
from narrows.waterway.room import GAUSS
from narrows.waterway.waterway import Waterway

MOST_CELLS = 1_000_000
# Cells a beam of the ship that keep contact within 0.01 of the beam.
# A kink of a bank by a slope m between nodes errs by m step / 4 (1:10: 0.006 of the beam), a bend that starts at once
# by 0.005 of it, the chord of a bank in a bend by curvature step^2 / 8 (radius of 30 beams: 0.0003).
STEPS_A_BEAM = 4


@dataclass(frozen=True)
class WaterwayTable:
    """A waterway in equal cells; between nodes its columns are straight, and so are its banks on the map."""

    s: np.ndarray  # (n,) Along the line, from 0 to its length [m]
    starboard: np.ndarray  # (n,) From the line to vertical walls that leave the same section of water [m]
    port: np.ndarray  # (n,) From the line to vertical walls that leave the same section of water [m]
    # (n,) From the line to where a keel meets the bank, or to the wall where that is nearer [m]
    keel_starboard: np.ndarray
    keel_port: np.ndarray  # (n,) From the line to where a keel meets the bank, or to the wall where that is nearer [m]
    depth: np.ndarray  # (n,) Of the water; NaN where the waterway has none [m]
    curvature: np.ndarray  # (n,) Of the line, to starboard [1/m]

    @property
    def step(self) -> float:
        """From node to node [m]."""
        return float(self.s[-1]) / (len(self.s) - 1)

    @cached_property
    def nodes(self) -> np.ndarray:
        """Of line and banks on a map of the table's own, (n + 2, 9): see ``narrows.waterway.room.ROW``."""
        # It has its origin and forward axis at the first node. The first row and the last are far beyond the ends,
        # where line and banks go straight on.
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
        """The nodes, flat, as ``exact_room`` takes them."""
        return np.ascontiguousarray(self.nodes).reshape(-1)


def tabulate(waterway: Waterway, draft: float, step: float) -> WaterwayTable:
    """Return a waterway as a table of equal cells."""
    # draft [m]; step [m]
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
    return WaterwayTable(s, starboard, port, keel_starboard, keel_port, depth, waterway.line.curvature(s))


def _integrated(curvature: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes and headings of a line of linear curvature between nodes: three points of Gauss and Legendre a cell."""
    heading = np.concatenate([[0.0], np.cumsum((curvature[1:] + curvature[:-1]) / 2 * step)])
    part = step * np.array([1 - GAUSS, 1, 1 + GAUSS]) / 2
    change = np.diff(curvature)[:, None] / step
    turned = heading[:-1, None] + part * (curvature[:-1, None] + part * change / 2)
    weights = step * np.array([5, 8, 5]) / 18
    x, y = (np.concatenate([[0.0], np.cumsum(f(turned) @ weights)]) for f in (np.cos, np.sin))
    return x, y, heading
