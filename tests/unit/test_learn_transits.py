"""Transits of a canal: twins whose truth is known are found again, gusts included; what cannot be told is said."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import narrows as nw
from logs import PassedTransit
from narrows.logbook.filtering.likelihood import FIRST_PASSES, RecordLikelihood, search
from narrows.logbook.filtering.log_problem import RecordedMotion
from narrows.logbook.filtering.record_grid import HELM_GAIN, first_guess, grid_of
from narrows.logbook.learning.log_fit import forecast_errors
from narrows.logbook.learning.log_setup import log_problem
from narrows.logbook.ship_log import AIS, VDR, SensorGrade
from narrows.logbook.transits import TransitTwin, recorded
from narrows.waterway import Bank, Centreline
from twins import CURRENT, SPEED, drawn_truth, large_container_ship, transits_of

pytestmark = pytest.mark.slow
MINUTES = 12.0


@cache
def ship() -> nw.Model:
    return large_container_ship()


@cache
def twin(**held: float) -> tuple[nw.Model, nw.ShipLog]:
    """The first ship that comes through, and its log."""
    for seed in range(30):
        truth = drawn_truth(ship(), seed, **held)
        try:
            return truth, transits_of(TransitTwin(truth, SPEED, 60 * MINUTES), VDR, 2, 3)
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
    assert found.informative
    assert found.gusts is not None
    assert 10 < found.gusts.memory < 160
    assert not found.disagrees


def test_a_compass_in_whole_degrees_is_not_taken_for_gusts() -> None:
    truth, log = twin()
    first = log[0]
    rounded = first.with_signals(psi=nw.Signal(first["psi"].t, in_degrees(first)))
    found, fine = nw.learn(ship(), rounded), learned()[1]
    assert found.gusts is not None
    assert fine.gusts is not None
    assert found.gusts.yaw < 1.5 * fine.gusts.yaw
    assert not found.has_unexplained_disturbance
    assert abs(found.model["c_bank"] - truth["c_bank"]) < 3.5 * found.coefficients["c_bank"].std


def in_degrees(record: nw.ShipRecord) -> np.ndarray:
    return np.radians(np.round(np.degrees(record["psi"].values)))


def test_the_law_of_a_pilot_is_found_in_the_rudder() -> None:
    """A pilot gives rudder against a heading and a yaw rate, and takes it off again."""
    setup = log_problem(ship(), twin()[1], "vdr", pilot=True)
    found = search(setup.problem, setup)
    assert found is not None
    names = [one.name for one in setup.problem.model.processes]
    for record in found.records:
        assert record.path is not None
        law = dict(zip(names, record.path.processes[0].tolist(), strict=True))
        assert law[HELM_GAIN("psi")] < -0.1
        assert law[HELM_GAIN("r")] < -10.0
        assert -0.6 < law[HELM_GAIN("rudder")] < 0.0


def test_a_current_along_the_canal_is_not_taken_for_speed() -> None:
    for record, own in zip(twin()[1], learned()[1].records, strict=True):
        x = record["x"]
        over_ground = (x.values[-1] - x.values[0]) / (x.t[-1] - x.t[0])
        current, through_water = own.zeros["current_x"], record["u"].values.mean() - own.zeros["u_error"]
        assert through_water + current == pytest.approx(over_ground, abs=0.01)
        assert abs(current - (over_ground - SPEED)) < 0.5 * abs(over_ground - SPEED)
    setup = log_problem(ship(), twin()[1], "vdr")
    for grid in setup:
        unknowns = np.zeros(len(setup.problem.precision))
        path = RecordLikelihood(setup.problem, grid).smoothed(unknowns, None, FIRST_PASSES)
        assert path is not None
        known = setup.problem, unknowns[: setup.problem.count], grid, path, setup.problem.model
        assert np.abs(forecast_errors(*known)[:, 0]).max() < 40.0  # of some 1400 m


def test_in_bends_the_yaw_rate_counts_the_turning_of_the_line() -> None:
    """Pieces end where the voyage was, heading to the line, yaw rate over ground; the heading alone guesses it too."""
    voyage = nw.simulate(ship(), x=2000.0, u=SPEED, duration=600.0, dt=1.0, waterway=winding(), rudder=0.02)
    told = ("x", "y", "psi", "r", "u", "v", "rudder")
    record = nw.ShipRecord("bend", {name: nw.Signal(voyage.t, voyage[name]) for name in told})
    assert np.ptp(winding().section(voyage.x).curvature) > 1e-4
    motion = RecordedMotion(ship(), {"rudder": 0.0}, ("c_bank",), {"u": SPEED, "waterway": winding(), "x": 9000.0})
    grid = grid_of(record, 1.0, {"rudder": 0.0})
    every = np.stack([voyage[name] for name in ("x", "y", "psi", "u", "v", "r")], axis=1)
    first = np.arange(0, len(grid) + 1, 10)
    states, pieces = every[first], len(first) - 1
    sailed, _ = motion.sailed(states[:-1], np.zeros((pieces, 3)), first, grid.times, grid.positions)
    np.testing.assert_allclose(sailed[first[1:] + np.arange(pieces)], states[1:], atol=1e-6)
    silent = replace(record, signals={name: record[name] for name in ("x", "y", "psi", "rudder")})
    guess = first_guess(grid_of(silent, 1.0, {"rudder": 0.0}), winding())
    np.testing.assert_allclose(guess[::10, 5], states[:-1, 5], atol=2e-5)


@cache
def winding() -> nw.Waterway:
    """A canal as wide as the model's, in bends of 3 km to either side."""
    along = np.arange(0.0, 18_000.0, 20.0)
    heading = np.cumsum(np.sin(along / 1200.0) ** 3 / 3000.0) * 20.0
    line = 20.0 * np.cumsum(np.stack([np.cos(heading), np.sin(heading)], axis=1), axis=0)
    canal, ends = ship().configuration.canal, np.array([0.0, along[-1]])
    sides = (Bank(side, ends, np.full(2, canal.width / 2)) for side in ("starboard", "port"))
    return nw.Waterway(Centreline(line), *sides, (ends, np.full(2, canal.depth)), name="winding canal")


def test_no_bank_is_called_unresolved_and_not_small() -> None:
    _, found = learned(c_bank=0.0)
    own = found.coefficients["c_bank"]
    assert own.unresolved
    assert any("Assumed: a draft of" in note for note in found.notes)
    assert "unresolved" in own.verdict
    assert "c_bank" in found.summary()
    assert "unresolved, for 0 is among it" in found.summary()


def passed(marked: bool) -> nw.LogFit:
    """A transit on which two ships pass."""
    transit = PassedTransit(twin()[0], SPEED, 60 * MINUTES, passes=(200.0, 520.0))
    (record,) = transits_of(transit, VDR, 1, 3)
    t = np.arange(0.0, 60 * MINUTES, 10.0)
    near = np.minimum(abs(t - 200.0), abs(t - 520.0)) < ship().configuration.ship.length / SPEED
    return nw.learn(ship(), record.with_signals(meeting=nw.Signal(t, 1.0 * near)) if marked else record)


def test_a_ship_that_passes_is_no_gust_where_the_log_marks_it() -> None:
    found = passed(marked=True)
    assert not found.has_unexplained_disturbance
    assert abs(found.coefficients["c_bank"].value - twin()[0]["c_bank"]) < 3.5 * found.std["c_bank"]


def test_a_ship_that_passes_unmarked_is_said() -> None:
    found = passed(marked=False)
    assert found.has_unexplained_disturbance
    assert "mark these times in the log (`meeting`)" in found.summary()


def test_what_is_marked_holds_until_it_is_marked_otherwise() -> None:
    t, once = np.arange(0.0, 100.0), np.array([0.0, 35.0, 52.0])
    signals = {name: nw.Signal(t, 0.0 * t) for name in ("y", "rudder")}
    record = nw.ShipRecord("met", {**signals, "meeting": nw.Signal(once, np.array([0.0, 1.0, 0.0]))})
    grid = grid_of(record, 10.0, {"rudder": 0.0})
    assert np.flatnonzero(~grid.whole).tolist() == [3, 4, 5]
    assert not set(grid.readings["y"].step) & {3, 4, 5}


def test_a_log_without_the_rudder_cannot_tell_and_says_why() -> None:
    voyage = TransitTwin(learned()[0], SPEED, 600.0).sailed(1)
    with pytest.raises(nw.InputError, match="has no rudder angle: bank and helm cannot be separated"):
        nw.learn(ship(), [recorded("ais", voyage, AIS, 1, CURRENT)], sensors="ais")


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
