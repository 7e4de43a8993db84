"""Transits of a canal: twins whose truth is known are found again, gusts included; what cannot be told is said."""

from functools import cache

import numpy as np
import pytest

import narrows as nw
from narrows.logbook.learning_demo import SPEED, large_container_ship, transits_of
from narrows.logbook.sensor_grades import AIS, VDR, SensorGrade
from narrows.logbook.transit_twins import TransitTwin, drawn_truth, recorded

pytestmark = pytest.mark.slow
MINUTES = 30.0


@cache
def ship() -> nw.Model:
    return large_container_ship()


@cache
def twin(**held: float) -> tuple[nw.Model, nw.ShipLog]:
    """The first ship that comes through, and its log."""
    for seed in range(30):
        truth = drawn_truth(ship(), seed, **held)
        try:
            return truth, transits_of(truth, VDR, 2, 3, TransitTwin(truth, SPEED, 60 * MINUTES))
        except nw.InputError:
            continue
    raise AssertionError("no ship comes through")


@cache
def learned(**held: float) -> tuple[nw.Model, nw.LogFit]:
    truth, log = twin(**held)
    return truth, nw.learn(ship(), log)


def test_the_bank_of_a_twin_is_found_within_its_interval() -> None:
    truth, found = learned()
    for name in ("b_bank", "c_bank"):
        own = found.coefficients[name]
        assert own.std < 0.3 * own.prior_std
        assert abs(own.value - truth[name]) < 3.5 * own.std
    assert found.tells
    assert found.gusts is not None
    assert 10 < found.gusts.memory < 160


def test_no_bank_is_called_unresolved_and_not_small() -> None:
    _, found = learned(c_bank=0.0)
    own = found.coefficients["c_bank"]
    assert own.holds_zero
    assert "unresolved" in own.verdict
    assert "c_bank" in found.summary().splitlines()[0]
    assert "unresolved, for 0 is among it" in found.summary()


def test_gusts_that_are_not_looked_for_make_intervals_too_narrow() -> None:
    truth, found = learned()
    blind = nw.learn(ship(), twin()[1], gusts=False)
    assert blind.gusts is None
    off = [abs(fit.model["c_bank"] - truth["c_bank"]) for fit in (blind, found)]
    assert off[0] > off[1] - found.std["c_bank"]


def test_a_log_without_the_rudder_cannot_tell_and_says_why() -> None:
    voyage = TransitTwin(learned()[0], SPEED, 600.0).sailed(1)
    with pytest.raises(nw.InputError, match="holds no rudder: what the bank did and what the helm did"):
        nw.learn(ship(), [recorded("ais", voyage, AIS, 1)], sensors="ais")


def test_twins_are_recorded_as_their_grade_says() -> None:
    voyage = TransitTwin(learned()[0], SPEED, 900.0).sailed(2)
    exact = SensorGrade("exact", "", {name: nw.SignalGrade(1e-9) for name in VDR.signals})
    true, told = (recorded("twin", voyage, grade, 5, current=0.0) for grade in (exact, VDR))
    np.testing.assert_allclose(true["psi"].values, voyage.psi[:-1], atol=1e-6)
    off = told["r"].values - true["r"].values
    own = VDR.signals["r"]
    assert np.std(off) == pytest.approx(np.hypot(own.noise, own.wander), rel=0.15)
    orders = np.degrees(voyage.rudder)
    assert np.mean(np.abs(orders - np.round(orders)) < 1e-6) > 0.5
