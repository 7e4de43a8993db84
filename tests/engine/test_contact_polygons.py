"""Contact in waterways beside exact polygons on the smooth waterway: bends, clothoids, a narrowing of 1:10."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
import shapely
import xarray as xr
from cases import OUTLINE, paper
from hull_polygons import OnTheMap, hull_points
from public import kinds, sides
from reference import Reference

import narrows as nw
from narrows.waterway import Bank, Centreline, Waterway

LENGTH, BEAM = paper().configuration.ship.length, paper().configuration.ship.beam
RADIUS = 5 * LENGTH
HALF = 3.5
SPACING = 0.1
"""Of the points of a centreline [m]."""
NEAR = 0.01 * BEAM
VESSELS = 64


@cache
def inert() -> nw.Model:
    """A hull that only mass resists: it sails straight on, or round for ever."""
    own = paper().in_open_water()
    forces = [name for name in own.coefficients if not name.endswith("dot")]
    return own.with_coefficients(**dict.fromkeys(forces, 0.0), b_rdot=0.0, c_vdot=0.0)


def drawn(bends: list[tuple[float, float]]) -> Centreline:
    """Integrate a curvature that is linear between (place, curvature)."""
    s = np.arange(0.0, bends[-1][0] + SPACING / 2, SPACING)
    middles = (s[1:] + s[:-1]) / 2
    places, curvatures = zip(*bends, strict=True)
    heading = np.concatenate([[0.0], np.cumsum(np.interp(middles, places, curvatures) * SPACING)])
    course = (heading[1:] + heading[:-1]) / 2
    steps = SPACING * np.stack([np.sin(course), np.cos(course)], axis=1)
    return Centreline(np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)]))


def walls(line: Centreline, starboard: tuple[list[float], list[float]], port: tuple[list[float], list[float]]) -> Any:
    return Waterway(line, *(Bank(side, np.array(own[0]), np.array(own[1])) for side, own in
                            (("starboard", starboard), ("port", port))))  # fmt: skip


def bend(turn: int, approach: float) -> Waterway:
    """A straight reach, a transition as long as asked, a round bend to starboard (1) or port (-1), and out again."""
    sharp, end = turn / RADIUS, 45.0 + 2 * approach
    line = drawn([(0, 0), (15, 0), (15 + approach, sharp), (end - 15 - approach, sharp), (end - 15, 0), (end + 10, 0)])
    wide = ([0.0, line.length], [HALF, HALF])
    return walls(line, wide, wide)


def narrowing(side: str) -> Waterway:
    """One bank comes in by 1:10, and goes back as it came."""
    line = drawn([(0, 0), (70, 0)])
    wide, narrow = ([0.0, 70.0], [HALF, HALF]), ([0.0, 20.0, 40.0, 60.0, 70.0], [HALF, HALF, 1.5, HALF, HALF])
    return walls(line, narrow, wide) if side == "starboard" else walls(line, wide, narrow)


WATERWAYS = {
    "bend to starboard": bend(1, 0.05), "bend to port": bend(-1, 0.05), "clothoid to starboard": bend(1, 2 * LENGTH),
    "clothoid to port": bend(-1, 2 * LENGTH), "narrowing to starboard": narrowing("starboard"),
    "narrowing to port": narrowing("port"),
}  # fmt: skip
TURNS = {"bend to starboard": 1, "bend to port": -1, "clothoid to starboard": 1, "clothoid to port": -1}
HULLS = {"rectangle": "corners", "outline": [(LENGTH * forward, BEAM * starboard) for forward, starboard in OUTLINE]}


@dataclass(frozen=True)
class Starts:
    """Ships along the line and across it, parallel to the bank or not, each set towards a bank."""

    name: str

    def columns(self) -> dict[str, xr.DataArray]:
        draw, turn = np.random.default_rng(5), TURNS.get(self.name, 0)
        y = draw.uniform(-2.0, 2.0, VESSELS) * (1.0 if turn else 0.5)
        along = draw.uniform(0.0, 1.0, VESSELS) < 0.6
        columns = {
            "x": draw.uniform(*((16.0, 24.0) if turn else (12.0, 38.0)), VESSELS),
            "y": y,
            "psi": np.where(along, 0.0, draw.uniform(-0.12, 0.12, VESSELS)),
            "v": draw.choice([-1, 1], VESSELS) * draw.uniform(0.05, 2.0, VESSELS),
            "r": turn / (RADIUS - turn * y) * np.where(along, 1.0, 0.5),
        }
        return {name: xr.DataArray(column, dims="start") for name, column in columns.items()}

    def row(self, number: int) -> dict[str, float]:
        return {name: float(column[number]) for name, column in self.columns().items()} | {"u": 1.0}


every_case = [pytest.param(way, hull, id=f"{way}, {hull}") for way in WATERWAYS for hull in HULLS]


@pytest.mark.parametrize(("name", "hull"), every_case)
def test_a_fleet_grounds_where_the_polygons_meet(name: str, hull: str) -> None:
    way, starts = WATERWAYS[name], Starts(name).columns()
    told = {"duration": 60.0, "dt": 0.05, "contact": HULLS[hull], "waterway": way}
    ended = nw.ensemble(inert(), u=1.0, **starts, **told)
    exact = OnTheMap(inert(), hull_points(inert(), HULLS[hull]), way)
    states = np.stack([starts["x"] + ended["distance"], ended["y_end"], ended["psi_end"]], axis=-1)
    aground = np.flatnonzero(np.array(kinds(ended)) == "grounded")
    assert len(aground) > 0.8 * VESSELS
    rooms = [exact.room(state) for state in states[aground]]
    assert np.abs(rooms).max() < NEAR
    told_sides = np.array(sides(ended))[aground].tolist()
    assert told_sides == [exact.side(state) for state in states[aground]]


@pytest.mark.parametrize(("name", "hull"), every_case)
def test_a_voyage_goes_on_until_the_polygons_meet(name: str, hull: str) -> None:
    way, exact = WATERWAYS[name], OnTheMap(inert(), hull_points(inert(), HULLS[hull]), WATERWAYS[name])
    for number in range(0, VESSELS, 12):
        told = {"duration": 60.0, "dt": 0.05, "contact": HULLS[hull], "waterway": way}
        voyage = nw.simulate(inert(), **Starts(name).row(number), **told)
        states = np.stack([voyage.x, voyage.y, voyage.psi], axis=1)
        if voyage.outcome.kind == "grounded":
            assert abs(exact.room(states[-1])) < NEAR
            assert voyage.outcome.side == exact.side(states[-1])
        close = np.flatnonzero(exact.closed(states[:-1], NEAR))
        assert all(exact.room(state) > -NEAR for state in states[close])


@pytest.mark.parametrize("turn", [1, -1])
def test_in_a_bend_the_inner_bank_meets_the_side_between_the_corners(turn: int) -> None:
    """What these cases hold a hull to: its corners alone are then more than a tenth of a beam off."""
    way = WATERWAYS["bend to starboard" if turn == 1 else "bend to port"]
    start = {"x": 20.0, "y": 0.0, "v": turn * 2.0, "r": 1.05 * turn / RADIUS, "u": 1.0}
    end = Reference(inert(), 60.0, 0.05, start, waterway=way).end("corners")
    assert (end.kind, end.side) == ("grounded", "starboard" if turn == 1 else "port")
    exact = OnTheMap(inert(), hull_points(inert(), "corners"), way)
    state = np.array([end.state[name] for name in ("x", "y", "psi")])
    corners = shapely.MultiPoint(np.asarray(exact.hulls(state)[0].exterior.coords))
    assert min(shapely.distance(corners, line) for line in exact.lines) > 0.1 * BEAM
    assert abs(exact.room(state)) < 1e-6
