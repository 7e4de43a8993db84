"""Distances to drawn banks, a waterway's table, and the room beside its banks, compiled and in plain Python.

python benchmarks/waterway.py
"""

import re
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
from common import median_seconds, show, sizes

from narrows.waterway import Centreline, Waterway
from narrows.waterway import bank_clearance as clearance_text
from narrows.waterway.bank_clearance import exact_clearance
from narrows.waterway.banks import bank_from_points
from narrows.waterway.waterway import STEPS_A_BEAM, least_walls, tabulate

LENGTH, BEAM, DRAFT, CORNERS = 230.0, 32.2, 10.8, 2000
RECTANGLE = np.array([[1, -1], [1, 1], [-1, 1], [-1, -1]]) / 2 * [LENGTH, BEAM]


def winding() -> Waterway:
    """20 km of a river with banks of 2000 points."""
    t = np.linspace(0, 20_000, 60)
    line = Centreline(np.stack([600 * np.sin(t / 2500), t], axis=1))
    s, draw = np.linspace(-50, line.length + 50, CORNERS), np.random.default_rng(0)
    sides = {
        side: line.at(s, sign * draw.uniform(140, 160, CORNERS)) for side, sign in (("starboard", 1), ("port", -1))
    }
    return Waterway(line, *(bank_from_points(side, points, line) for side, points in sides.items()))


def compiled_clearances() -> Callable[..., float]:
    """The text of the room, compiled, for columns of poses."""
    text = re.sub(r"^def ", "@numba.njit\ndef ", Path(clearance_text.__file__).read_text(), flags=re.MULTILINE)
    scope = {"numba": numba}
    exec(text, scope)
    one = scope["exact_clearance"]

    @numba.njit
    def rooms(track: np.ndarray, step: float, s: np.ndarray, n: np.ndarray, psi: np.ndarray, hull: np.ndarray) -> float:
        total = 0.0
        for i in range(len(s)):
            total += one(track, step, s[i], n[i], np.cos(psi[i]), np.sin(psi[i]), hull)[0]
        return total

    return rooms


def main(count: int) -> None:
    """Measure and print."""
    way, draw = winding(), np.random.default_rng(0)
    s, n, psi = (draw.uniform(*ends, count) for ends in ((0, way.line.length), (-80, 80), (-0.1, 0.1)))
    table = tabulate(way, DRAFT, BEAM / STEPS_A_BEAM)
    rows = [
        (f"{count} distances to a bank of {CORNERS} points", median_seconds(lambda: way.starboard.at(s), 3), ""),
        ("the banks from their points, and the waterway", median_seconds(winding, 3), ""),
        ("the table", median_seconds(lambda: tabulate(way, DRAFT, table.step), 3), f"{len(table.s)} nodes"),
        ("lower bounds of contact", median_seconds(lambda: least_walls(table, RECTANGLE), 3), ""),
    ]
    show("a waterway of 20 km", rows, "ms", 1e3)

    hull, rooms, few = RECTANGLE.ravel(), compiled_clearances(), max(count // 100, 10)
    track, outline = table.track.tolist(), hull.tolist()

    def plain() -> None:
        for i in range(few):
            exact_clearance(track, table.step, s[i], n[i], float(np.cos(psi[i])), float(np.sin(psi[i])), outline)

    rows = [
        ("compiled", median_seconds(lambda: rooms(table.track, table.step, s, n, psi, hull)) / count, ""),
        ("plain Python", median_seconds(plain) / few, ""),
    ]
    show("the exact room of a hull", rows, "us", 1e6)


if __name__ == "__main__":
    places, _ = sizes(__doc__, usual=1e5, small=1e3)
    main(places)
