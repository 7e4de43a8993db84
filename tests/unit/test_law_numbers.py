"""The regulator by hand, order by order; no ship sails."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from narrows.control import HeldLine, Regulator
from narrows.simulation.controllers import LAST_ORDER

DEGREE = math.pi / 180


# The regulator, step by step

LINE = HeldLine(2.0, (0.01, 0.5, 0.02, 3.0, 0.25, 0.001), 0.03, -0.02, 0.1, (4.0, 5.0, 6.0))
BEND, LEAD = 1e-3, 7.0


def observed(law: Any, memory: Any, **at: Any) -> SimpleNamespace:
    def water(name: str, x: float) -> float:
        assert name == "curvature"
        return BEND if x > 100.0 else 0.0

    whole = {"t": 0.0, "dt": 0.5, "x": 0.0, "current": 0.0, "rudder_limit": 0.6, "rudder_rate": 0.1, "water": water}
    return SimpleNamespace(**{**law.parameters(), **memory, **whole, **at})


def test_an_order_of_the_regulator_is_that_of_its_formula_by_hand() -> None:
    """Twice the design speed, straight on: gains of pose and rudder double, that of the integral is fourfold.

    With dt = 0.5 s and a rudder gain of 0.25 / s, doubled: the rate is divided by 1 + 0.5 * 0.5.
    """
    law = Regulator((LINE,), 2.0, LEAD, unwinding=20.0, integral=3.0)
    memory = law.memory({"rudder": 0.05})
    assert memory == {"integral": 3.0, LAST_ORDER: 0.05}
    at = observed(law, memory, y=2.6, psi=0.01, u=4.0, v=0.3, r=0.002, rudder=9.9)
    orders, kept = law.orders(at)
    # Deviations: 0.6 m, 0.03 rad, 0.3 - 0.2 m/s, 0.05 - 0.03 rad.
    rate = -(2 * (0.01 * 0.6 + 0.5 * 0.03 + 0.25 * 0.02) + 0.02 * 0.1 + 3.0 * 0.002 + 4 * 0.001 * 3.0)
    assert orders["rudder"] == pytest.approx(0.05 + 0.5 * rate / 1.25)
    assert kept == {"integral": pytest.approx(3.0 + 0.5 * 0.6), LAST_ORDER: orders["rudder"]}
    # At a twentieth of the design speed and below the gains stay.
    slow, slower = (law.orders(observed(law, memory, y=2.6, psi=0.01, u=u, v=0.3, r=0.0)) for u in (0.1, 0.02))
    assert slow[0]["rudder"] == pytest.approx(slower[0]["rudder"])


def test_a_regulator_that_the_gear_cannot_follow_unwinds() -> None:
    """0.05 rad a step of 0.5 s at most; what is lacking goes back into the integral by its gain and time."""
    law = Regulator((replace(LINE, psi=0.0, v=0.0, turning=(0.0,) * 3),), 2.0, LEAD, unwinding=20.0)
    at = observed(law, {"integral": 1.0, LAST_ORDER: 0.03}, y=32.0, psi=0.0, u=2.0, v=0.0, r=0.0)
    orders, kept = law.orders(at)
    assert orders["rudder"] == pytest.approx(0.03 - 0.05)
    move = 0.5 * -(0.01 * 30.0 + 0.001 * 1.0) / 1.125
    assert kept["integral"] == pytest.approx(1.0 + 0.5 * 30.0 + (move + 0.05) / (0.001 * 20.0))
    hard = observed(law, {"integral": 1.0, LAST_ORDER: -0.59}, y=32.0, psi=0.0, u=2.0, v=0.0, r=0.0)
    assert law.orders(hard)[0]["rudder"] == -0.6


def test_the_turn_ahead_moves_course_drift_and_rudder() -> None:
    """In a steady turn of 1e-3 1/m at 2.5 m/s over ground, on the held course of that turn, the order stays."""
    law = Regulator((LINE,), 2.0, LEAD, unwinding=20.0)
    pace = 2.0 + 0.5
    turn = BEND * pace
    steady = {"y": 2.0, "psi": -0.02 + 4.0 * turn, "u": 2.0, "v": 0.1 + 5.0 * turn, "r": turn, "current": 0.5}
    rudder = 0.03 + 6.0 * turn
    memory = {"integral": 0.0, LAST_ORDER: rudder}
    orders, kept = law.orders(observed(law, memory, x=100.0 - LEAD * pace + 0.1, **steady))
    assert orders["rudder"] == pytest.approx(rudder, abs=1e-12)
    assert kept["integral"] == pytest.approx(0.0, abs=1e-9)
    before = law.orders(observed(law, memory, x=100.0 - LEAD * pace - 0.1, **steady))[0]["rudder"]
    rate = 0.5 * 4.0 * turn + 0.02 * 5.0 * turn + 3.0 * turn + 0.25 * 6.0 * turn
    assert before == pytest.approx(rudder - min(0.5 * rate / 1.125, 0.05))
    # Half as fast, heading and rudder of a turn are as large, the sway velocity of the straight course is half.
    slow = {**steady, "u": 1.0, "current": 0.0, "r": BEND, "psi": -0.02 + 4.0 * BEND * 2, "v": 0.05 + 5.0 * BEND}
    there = {"integral": 0.0, LAST_ORDER: 0.03 + 6.0 * BEND * 2}
    orders, _ = law.orders(observed(law, there, x=200.0, **slow))
    assert orders["rudder"] == pytest.approx(there[LAST_ORDER], abs=1e-12)


def test_lines_hold_from_their_time_on() -> None:
    lines = tuple(replace(LINE, y=float(y), start=float(start)) for y, start in ((0, 0), (5, 30), (9, 60)))
    by_time = Regulator(lines, 2.0, LEAD, 20.0)
    for now, y in ((-1.0, 0.0), (29.9, 0.0), (30.0, 5.0), (59.9, 5.0), (60.1, 9.0)):
        memory = {"integral": 0.0, LAST_ORDER: 0.0}
        rest = {"psi": 0.0, "u": 2.0, "v": 0.0, "r": 0.0, "y": 7.0, "dt": 0.01}
        kept = by_time.orders(observed(by_time, memory, t=now, **rest))[1]["integral"]
        free = Regulator((replace(LINE, y=y),), 2.0, LEAD, 20.0)
        assert kept == free.orders(observed(free, memory, **rest))[1]["integral"]
