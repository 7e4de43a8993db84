"""Squat: numbers by hand, Schijf's equation, monotony, limits; and the measured runs of the docs' table."""

import re

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from scipy.optimize import brentq
from strategies import numbers

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.model.water import GIVES, SquatFormula
from narrows.physics import squat_and_depth as formulas
from narrows.quantities.names import evaluate

SQUAT_RUNS = measured_files("kcs")[0].with_name("lataire2009_squat.csv")

DTC = nw.Configuration(nw.Ship(355.0, 51.0, 14.5, 0.661), nw.Canal(205.0, 24.0), nw.Water(1025.0))
KNOT = 1852 / 3600


def sinkage_by(formula: SquatFormula, configuration: nw.Configuration, speed: float) -> float:
    return float(evaluate(formula.function, {**configuration.values(), "u": speed}))


@pytest.mark.parametrize(("name", "value"), [("huuska", 0.458), ("barrass", 0.566), ("tuck_midship", 0.144)])
def test_the_dtc_at_eight_knots(name: str, value: float) -> None:
    """Worked by hand for a canal 205 m wide and 24 m deep: S = 0.1473, F = 0.2682."""
    assert sinkage_by(nw.SQUAT[name], DTC, 8 * KNOT) == pytest.approx(value, abs=6e-4)


@pytest.mark.parametrize("name", nw.SQUAT)
def test_a_formula_alone_gives_its_own_sinkage(name: str) -> None:
    found = nw.squat(DTC, 8 * KNOT, formula=name)
    assert found.sinkage == pytest.approx(sinkage_by(nw.SQUAT[name], DTC, 8 * KNOT))
    assert nw.SQUAT[name].gives in found.summary()


def test_ratios_by_hand() -> None:
    assert formulas.blockage(51.0, 14.5, 205.0, 24.0) == pytest.approx(0.1473, abs=5e-5)
    assert formulas.depth_froude(8 * KNOT, 24.0) == pytest.approx(0.2682, abs=5e-5)
    assert nw.choke_speed(DTC) == pytest.approx(8.37, abs=5e-3)


@given(share=numbers(0.01, 0.9))
def test_the_critical_speed_solves_schijfs_equation(share: float) -> None:
    """1 - S = 3/2 F^(2/3) - F^2/2, against a root finder."""
    speed = formulas.critical_speed(1.0, share / formulas.MIDSHIP_SECTION, 1.0, 1.0)
    froude = speed / 9.81**0.5
    exact = brentq(lambda f: 1.5 * f ** (2 / 3) - f * f / 2 - (1 - share), 0, 1)
    assert froude == pytest.approx(exact, rel=1e-9)


@given(share=numbers(0.02, 0.6), fast=numbers(0.05, 0.98))
def test_mean_sinkage_and_return_flow_keep_volume_and_energy(share: float, fast: float) -> None:
    """(u + return) (A - ship - width z) = u A and (u + return)^2 - u^2 = 2 g z, the slower of both solutions."""
    at = {"beam": 1.0, "draft": share / 0.98, "width": 1.0, "depth": 1.0}
    u = fast * formulas.critical_speed(**at)
    sinkage, back = formulas.continuity(u, **at), formulas.return_flow(u, **at)
    assert (u + back) * (1 - share - sinkage) == pytest.approx(u, rel=1e-9)
    assert (u + back) ** 2 - u**2 == pytest.approx(2 * 9.81 * sinkage, rel=1e-6, abs=1e-9)
    assert u + back < (9.81 * (1 - share - sinkage)) ** 0.5


def test_a_large_ship_in_the_suez_canal_close_to_choking() -> None:
    """The flow past a ship of 400 m at 13.5 kn, by a root finder: sinkage 2.26 m, return flow 2.68 m/s."""
    suez = nw.Configuration(nw.Ship(400.0, 58.8, 15.71, 0.6), nw.Canal(205.0, 24.0))
    u, section, free = 13.5 * KNOT, 205.0 * 24.0, 205.0 * 24.0 - 0.98 * 58.8 * 15.71
    sinkage = brentq(lambda z: (u * section / (free - 205.0 * z)) ** 2 - u * u - 2 * 9.81 * z, 0.0, 3.5)
    for gives in GIVES:
        assert nw.squat(suez, u, gives).sinkage >= sinkage - 1e-9
    assert nw.squat(suez, u).sinkage == pytest.approx(sinkage)
    assert sinkage == pytest.approx(2.26, abs=5e-3)


@pytest.mark.parametrize("name", nw.SQUAT)
def test_sinkage_grows_with_speed_and_in_shallow_water(name: str) -> None:
    formula = nw.SQUAT[name]
    speeds = [sinkage_by(formula, DTC, u) for u in (0.0, 2.0, 4.0, 6.0)]
    assert speeds[0] == 0
    assert np.all(np.diff(speeds) > 0)
    deep = nw.Configuration(DTC.ship, nw.Canal(205.0, 40.0), DTC.water)
    assert sinkage_by(formula, deep, 4.0) < sinkage_by(formula, DTC, 4.0)


@pytest.mark.parametrize("gives", GIVES)
def test_the_choice_gives_what_was_asked_for(gives: str) -> None:
    found = nw.squat(DTC, 4.0, gives)
    assert found.gives == gives
    assert nw.SQUAT[found.formula].gives in (gives, "mean")
    assert found.sinkage > 0
    unverified = nw.SQUAT[found.formula].status.startswith("from memory")
    assert any("not verified" in said for said in found.notes) == unverified


def test_a_formula_that_holds_goes_first() -> None:
    wide = nw.Configuration(DTC.ship, nw.Canal(2000.0, 24.0))
    assert nw.squat(wide, 4.0, "bow").formula == "huuska"
    full = nw.Configuration(nw.Ship(320.0, 58.0, 20.8, 0.82), nw.Canal(4000.0, 30.0))
    assert nw.squat(full, 4.0, "bow").formula == "icorels"
    assert nw.squat(full, 4.0, "bow").notes == ()


def test_outside_its_limits_is_said() -> None:
    deep = nw.Configuration(DTC.ship, nw.Canal(205.0, 40.0))
    said = nw.squat(deep, 4.0, "largest").notes
    assert any(text.startswith("depth to draft 2.76 is outside 1.1 to 1.4") for text in said)


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda: nw.squat(DTC, 9.0), "critical speed of this canal, 8.371 m/s"),
        (lambda: nw.squat(DTC, -1.0), "between 0"),
        (lambda: nw.squat(DTC, 4.0, "stern"), "midship or bow or largest"),
        (lambda: nw.squat(DTC, 4.0, formula="huska"), "did you mean 'huuska'"),
        (lambda: nw.squat(nw.Configuration(DTC.ship, nw.Canal(205.0)), 4.0), "depth is not given"),
    ],
)
def test_refusals(act, said: str) -> None:
    with pytest.raises(nw.InputError, match=re.escape(said)):
        act()


def test_measured_runs_are_fifteen() -> None:
    runs = pd.read_csv(SQUAT_RUNS)
    assert len(runs) == 15
    assert (runs["sinkage fore [mm]"] > 2).all()
