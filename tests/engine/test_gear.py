"""Steering gears: against exact dead time, the solved servo, laws of their own; in every engine; under every helm."""

import importlib.util
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import steered
from full_size import Exactly, full_size, geared

import narrows as nw
from narrows.control import PredictiveHelm, linearize, regulator

SPEED, HOLD = 4.5, 50.0


class Ramp:
    """A rudder ordered over at a rate, from amidships."""

    def parameters(self) -> dict[str, float]:
        return {"slope": math.radians(0.5)}

    def memory(self, start: Any) -> dict[str, Any]:
        return {}

    def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        return {"rudder": at.slope * at.t}, {}


def rudder_of(order: Any, dt: float, duration: float = 20.0, **gear: Any) -> tuple[np.ndarray, np.ndarray]:
    voyage = nw.simulate(geared(full_size(), **gear), 0.0, SPEED, duration, dt, controller=order)
    return voyage.t, voyage.rudder


@pytest.mark.parametrize("dt", [0.1, 0.25, 1.0, 2.0])
@pytest.mark.parametrize("dead_time", [0.7, 2.0, 5.0])
def test_a_ramp_comes_late_by_the_dead_time(dt: float, dead_time: float) -> None:
    t, prompt = rudder_of(Ramp(), dt, 60.0)
    _, late = rudder_of(Ramp(), dt, 60.0, dead_time=dead_time)
    settled = t > 40.0
    np.testing.assert_allclose((prompt - late)[settled], math.radians(0.5) * dead_time, rtol=1e-3)
    assert np.abs(late[t < 0.25 * dead_time - dt]).max(initial=0.0) < 0.02 * math.radians(0.5) * dead_time


@pytest.mark.parametrize("dt", [0.25, 1.0])
def test_a_lag_is_the_exponential(dt: float) -> None:
    t, rudder = rudder_of(nw.ConstantRudder(0.05), dt, lag=3.0)
    np.testing.assert_allclose(rudder, 0.05 * (1.0 - np.exp(-t / 3.0)), atol=1e-9)


def test_one_pump_turns_half_as_fast() -> None:
    t, rudder = rudder_of(nw.ConstantRudder(0.5), 1.0, pumps=1)
    np.testing.assert_allclose(rudder[:10], math.radians(65 / 28 / 2) * t[:10], rtol=1e-9)


def test_within_the_dead_band_the_rudder_stays() -> None:
    angle = math.radians(1.5)
    assert (rudder_of(nw.ConstantRudder(angle), 1.0, dead_band_deg=2.0)[1] == 0.0).all()
    assert rudder_of(nw.ConstantRudder(angle), 1.0, dead_band_deg=1.0)[1][-1] == pytest.approx(angle)


@pytest.mark.parametrize(
    ("gear", "words"),
    [({"dead_time": -1.0}, "negative"), ({"lag": -1.0}, "negative"), ({"dead_band_deg": -1.0}, "negative"),
     ({"pumps": 3}, "1 pump or 2"), ({"lag": math.nan}, "not a finite number")],
)  # fmt: skip
def test_what_is_no_gear_is_one_sentence(gear: dict[str, Any], words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        nw.SteeringGear(**gear)


def test_another_size_has_another_gear() -> None:
    gear = nw.scale_model(geared(steered(), dead_time=1.0, lag=2.0), length=4 * 3.984).model.configuration.gear
    assert (gear.dead_time, gear.lag) == (pytest.approx(2.0, rel=1e-3), pytest.approx(4.0, rel=1e-3))


LATE = {"dead_time": 0.4, "lag": 0.3, "dead_band_deg": 0.2, "pumps": 1}


def test_a_fleet_takes_the_steps_of_a_voyage() -> None:
    model = geared(steered(), **LATE)
    law = regulator(model, 0.2, 1.0)
    told = {"u": 1.0, "duration": 20.0, "dt": 0.1, "rudder": 0.1, "controller": law}
    fleet = nw.ensemble(model, y=[0.0, 0.4], **told)
    for number, y in enumerate((0.0, 0.4)):
        voyage = nw.simulate(model, y, **told)
        for name in ("y", "psi", "v", "r"):
            assert voyage[name][-1] == pytest.approx(float(fleet[f"{name}_end"][number]), abs=1e-9)


def test_an_export_takes_the_steps_of_a_voyage(tmp_path: Path) -> None:
    model = geared(steered(), **LATE)
    nw.export.write(model, tmp_path / "ship.py")
    spec = importlib.util.spec_from_file_location("geared_ship", tmp_path / "ship.py")
    ship = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(ship)
    constants, state, end = ship.prepare(ship.MODEL), ship.rest(), np.zeros(2)
    state[ship.U], inputs = 1.0, ship.AT_REST
    inputs.rudder_order = 0.1
    ship.integrate(state, inputs, constants, None, 0.1, 8.0, end)
    voyage = nw.simulate(model, 0.0, 1.0, 8.0, 0.1, controller=nw.ConstantRudder(0.1))
    assert state[ship.RUDDER] == pytest.approx(voyage.rudder[-1], abs=1e-12)
    assert state[ship.Y] == pytest.approx(voyage.y[-1], abs=1e-10)


def test_slopes_of_a_voyage_are_differences() -> None:
    model = geared(steered(), **{**LATE, "dead_band_deg": 0.0})
    told = {"u": 1.0, "duration": 8.0, "dt": 0.1, "controller": nw.ConstantRudder(0.1)}
    slopes = nw.sensitivities(model, ["rudder"], 0.1, rudder=0.05, **told).slopes[-1, 1]
    ahead, astern = (nw.simulate(model, 0.1, rudder=0.05 + off, **told).y[-1] for off in (1e-5, -1e-5))
    assert slopes[0] == pytest.approx((ahead - astern) / 2e-5, rel=1e-5)


@cache
def begun() -> dict[str, float]:
    course = linearize(full_size(), HOLD, SPEED).course
    return {name: float(course[name]) for name in ("u", "psi", "v", "rudder")}


def held(model: nw.Model, helm: Any, dt: float, duration: float = 900.0) -> float:
    """Largest distance from the line of a ship that begins a metre off it; infinite where it grounds [m]."""
    voyage = nw.simulate(model, HOLD + 1.0, duration=duration, dt=dt, controller=helm, **begun())
    return float(np.abs(voyage.y - HOLD).max()) if voyage.outcome.kind == "afloat" else math.inf


GEARS = [(0.0, 0.0), (5.0, 0.0), (0.0, 4.0), (1.0, 2.5), (5.0, 4.0)]


@pytest.mark.parametrize("dt", [0.1, 0.25, 1.0, 2.0])
def test_the_regulator_stands_every_gear(dt: float) -> None:
    law = regulator(full_size(), HOLD, SPEED)
    assert max(held(geared(full_size(), dead_time=dead, lag=lag), law, dt) for dead, lag in GEARS) < 2.0


@pytest.mark.parametrize("dead", [0.0, 5.0])
@pytest.mark.parametrize("told", [False, True])
@pytest.mark.parametrize("dt", [0.25, 1.0])
def test_the_predictive_helm_stands_every_gear(dt: float, told: bool, dead: float) -> None:
    pytest.importorskip("daqp")
    model = geared(full_size(), dead_time=dead, lag=4.0)
    helm = PredictiveHelm(model if told else full_size(), HOLD, SPEED)
    assert held(model, helm, dt, 300.0) < 2.0


@pytest.mark.parametrize("told", [False, True])
def test_the_predictive_helm_stands_the_gear_of_a_hull_in_a_tank(told: bool) -> None:
    """A hull of 4 m, for which 0.3 s and 0.5 s are what 2.3 s and 4 s are at full size; also if it is not told."""
    pytest.importorskip("daqp")
    import plans

    model, off = geared(plans.ship(), dead_time=0.3, lag=0.5), plans.ship().configuration.ship.length / 230.0
    start = {"y": plans.HOLD + off, "u": plans.SPEED, "duration": 30.0, "dt": 0.13}
    helm = PredictiveHelm(model, plans.HOLD, plans.SPEED) if told else plans.helm()
    voyage = nw.simulate(model, **start, controller=helm)
    assert voyage.outcome.kind == "afloat"
    assert np.abs(voyage.y - plans.HOLD).max() < 2.0 * off
    assert np.abs(voyage.y - plans.HOLD)[-50:].max() < 0.1 * off


@pytest.mark.parametrize("dead_time", [2, 5])
def test_a_voyage_is_that_of_an_exact_dead_time(dead_time: int) -> None:
    law = regulator(full_size(), HOLD, SPEED)
    start = {**begun(), "y": HOLD + 5.0, "duration": 600.0, "dt": 1.0}
    stages = nw.simulate(geared(full_size(), dead_time=dead_time), controller=law, **start)
    exact = nw.simulate(full_size(), controller=Exactly(law, dead_time), **start)
    assert np.abs(stages.y - exact.y).max() < 0.02 * 5.0
