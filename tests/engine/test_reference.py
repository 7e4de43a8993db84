"""The reference itself: its equations beside the terms, its tracks beside voyages, its polygons beside geometry."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import Case, bent, mmg, paper, steered
from equations import Equations
from hull_polygons import OnTheMap, Walls, hull_points
from reference import Reference

import narrows as nw
from direct_equation import accelerations
from narrows.waterway import Bank, Centreline, Waterway

ROUND = 30.0
"""Radius of the bend [m]."""


@pytest.mark.parametrize("model", [paper(), steered(), mmg()], ids=["paper", "steered", "mmg"])
@pytest.mark.parametrize("inertia", [None, 4000.0])
def test_its_accelerations_are_those_of_the_terms(model: nw.Model, inertia: float | None) -> None:
    model = replace(model, configuration=replace(model.configuration, steering=None))
    own = Equations(model, surge="held" if inertia is None else "free", surge_inertia=inertia, forces=(3.0, 2.0, -1.0))
    state = np.array([2.0, 0.4, 0.1, 1.1, -0.05, 0.02, 0.0])
    rates = own.rates(state, 0.0)
    motion = nw.Motion.at(0.1, y=0.4, u=1.1, v=-0.05, r=0.02)
    expected = accelerations(model, motion, (3.0, 2.0, -1.0), inertia)
    np.testing.assert_allclose(rates[3:6], expected, rtol=1e-12, atol=1e-15)
    assert rates[1] == pytest.approx(1.1 * math.sin(0.1) - 0.05 * math.cos(0.1))


@pytest.mark.parametrize("course", ["straight", "waterway"])
@pytest.mark.parametrize("ship", ["paper", "steered", "mmg+delta"])
def test_its_track_is_the_packages_as_long_as_it_is_afloat(ship: str, course: str) -> None:
    """Where contact plays no part and the rudder stays: the equations and the waterway are understood alike."""
    case = Case(ship, course, "free", "constant", "corners")
    start = {**case.start(0), "psi": 0.0, "y": 0.1}
    options = {**case.options, "waterway": case.waterway}
    found = Reference(case.model, 6.01, 0.02, start, **options, forces=(11.0, 0.7, -0.4)).end("corners")
    voyage = nw.simulate(case.model, duration=6.01, dt=0.02, **start, **options, X=11.0, Y=0.7, N=-0.4)
    assert found.kind == voyage.outcome.kind == "afloat"
    assert found.time == voyage.outcome.time == 6.01
    # A waterway is straight between the nodes of its table, an eight-hundredth of the ship's length apart here.
    near = 2e-8 if course == "straight" else 2e-6
    for name, value in voyage.outcome.state.items():
        assert found.state[name] == pytest.approx(value, abs=near), name


def test_a_steered_track_does_not_depend_on_how_its_steps_are_joined(monkeypatch: pytest.MonkeyPatch) -> None:
    import reference

    case = Case("steered", "straight", "held", "zigzag", "corners")
    longer = replace(case.reference(0), dt=4 * case.dt)
    joined = replace(longer).end("corners")
    monkeypatch.setattr(reference, "LONGEST", 1)
    single = replace(longer).end("corners")
    assert joined.time == pytest.approx(single.time, abs=1e-9)


def test_walls_on_the_map_are_walls() -> None:
    model, points = paper(), hull_points(paper(), "corners")
    way = nw.straight_waterway(model.configuration.canal, 40.0, heading=0.7)
    draw = np.random.default_rng(1)
    states = np.stack([np.full(50, 20.0), draw.uniform(-3, 3, 50), draw.uniform(-0.4, 0.4, 50)], axis=1)
    walls, drawn = Walls(model, points), OnTheMap(model, points, way)
    rooms = walls.rooms(states)
    assert (rooms > 0).any()
    assert (rooms < 0).any()
    for state, room in zip(states, rooms.tolist(), strict=True):
        assert (drawn.room(state) > 0) == (room > 0)
        if room > 0:
            assert drawn.room(state) == pytest.approx(room, abs=1e-9)
            assert drawn.side(state) == walls.side(state)


@pytest.mark.parametrize("turn", [1, -1])
def test_a_rectangle_in_a_round_bend(turn: int) -> None:
    """The inner bank meets the middle of the side, the outer one a corner: both by Pythagoras."""
    angle = np.linspace(0, 1.2, 800)
    line = Centreline(ROUND * np.stack([turn * (1 - np.cos(angle)), np.sin(angle)], axis=1))
    s = np.array([0.0, line.length])
    way = Waterway(line, Bank("starboard", s, np.full(2, 4.0)), Bank("port", s, np.full(2, 4.0)))
    model = paper()
    half, beam = model.configuration.ship.length / 2, model.configuration.ship.beam / 2
    drawn = OnTheMap(model, hull_points(model, "corners"), way)
    for n in (-3.0, 0.0, 2.5):
        from_centre = ROUND - turn * n
        inner = from_centre - beam - (ROUND - 4.0)
        outer = ROUND + 4.0 - math.hypot(half, from_centre + beam)
        room = drawn.room(np.array([line.length / 2, n, 0.0]))
        assert room == pytest.approx(min(inner, outer), abs=1e-5), "what the spline leaves of the circle"
        assert drawn.side(np.array([line.length / 2, n, 0.0])) == (
            "starboard" if (inner < outer) == (turn > 0) else "port"
        )


def test_the_bends_are_of_five_lengths() -> None:
    way = bent(4.0, 7.0)
    bends = way.line.curvature(np.linspace(0, way.line.length, 5000))
    assert 1 / bends.max() == pytest.approx(20.0, rel=0.02)
    assert 1 / bends.min() == pytest.approx(-20.0, rel=0.02)
