"""Forecasts beside voyages of the plain engine, one at a time; beside what is known, and beside steady courses."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t as student
from transit import SENSORS, SPEED, canal, estimate, estimator, ship

import narrows as nw
from narrows.estimation import Estimate, Estimator
from narrows.warning import settings
from narrows.warning.forecasting.forecaster import BankForecast, Forecaster, crossing, level_time, rudder_needed
from narrows.warning.forecasting.helmsman import Case, Helmsmen, LineOfSight, Ships, escape_numbers

FAN_MEMBERS = 32  # ships of the fan

STATE = ("x", "y", "psi", "u", "v", "r")


@cache
def forecaster(coefficients: str = "estimated") -> Forecaster:
    return Forecaster(estimator(coefficients), members=40, escaping=40)


def nobody_yet() -> Helmsmen:
    return Helmsmen(1, ship().configuration.ship.length)


def forecast(y: float, psi: float = 0.0, rudder: float = 0.0) -> BankForecast:
    return forecaster()(estimate(y, psi), {"rudder": rudder}, nobody_yet())


class Law(LineOfSight):
    """The law with the numbers of one future."""

    def __init__(self, numbers: dict[str, float]) -> None:
        super().__init__()
        object.__setattr__(self, "numbers", numbers)

    def parameters(self) -> dict[str, float]:
        return self.numbers


def sailed(state: dict[str, float], model: nw.Model, case: Case, rudder: float, t: float) -> nw.Voyage:
    """The same future as one voyage, in the current of the state."""
    length, limit = model.configuration.ship.length, model.configuration.gear.limit
    ordered = rudder if case.ordered is None else case.ordered
    numbers = {**escape_numbers(0.0, length, limit), "since": case.since, "ordered": ordered}
    numbers |= {"by_r": numbers["by_r"] / state["u"], "crab": state["current_across"] / state["u"]}
    told = {name: state[name] for name in STATE}
    water = canal().with_water(current=state["current"], current_across=state["current_across"])
    options = {"waterway": water, "controller": Law(numbers), "rudder": rudder, "dt": 2.5, "contact": "corners"}
    return nw.simulate(model, **told, duration=t, **options)


def by_bank(bank: float, coefficients: dict[str, float]) -> nw.Model:
    banks = {term.name: bank * coefficients[term.name] for term in ship().terms.terms if term.from_bank}
    return replace(ship(), coefficients={**coefficients, **banks})


def sampled(one: Forecaster, now: Estimate, normals: np.ndarray, rudder: float = 0.0) -> Ships:
    law = nobody_yet().law(np.array([SPEED]))
    return one.sampled(now.joint.mean[None], now.joint.root[None], normals, np.array([rudder]), law)


def test_the_tracks_are_where_voyages_go() -> None:
    """The most likely ship each five seconds, as it is and by the escape, by the plain engine; samples lie about it."""
    now = estimate(60.0, 0.02)
    tracks, state = forecaster()(now, {"rudder": 0.02}, nobody_yet()).tracks, now.values
    known = sampled(forecaster(), now, forecaster().likely).coefficients
    model = by_bank(1.0, {name: float(column[0]) for name, column in known.items()})
    rudder = 0.02 + state["rudder_bias"]
    for track, since in ((tracks.as_is, 1e9), (tracks.escape, 0.0)):
        voyage = sailed(state, model, Case(60.0, since), rudder, 60.0)
        plain = np.stack([np.interp(tracks.times[:12], voyage.t, voyage[name]) for name in ("x", "y", "psi")], axis=1)
        np.testing.assert_allclose(track[:12], plain, atol=2e-3)
    assert tracks.fan.shape == (FAN_MEMBERS, 12, 3)
    np.testing.assert_allclose(tracks.fan[:, 2].mean(axis=0), tracks.as_is[5], atol=2.0)


@pytest.mark.parametrize("coefficients", ["certain", "estimated"])
def test_every_lane_is_a_voyage(coefficients: str) -> None:
    """Of some samples, in every kind of future: one after the other by the plain engine."""
    now, one, met, clear = estimate(60.0, 0.35, coefficients=coefficients), forecaster(coefficients), 0, 0
    members, ships, likely = (sampled(one, now, normals, 0.3) for normals in (one.members, one.escaping, one.likely))
    _, ends, _ = one._lanes([members, ships, likely])
    cases = one._lanes.blocks[1].cases
    for k in range(4):
        state = {name: float(column[k]) for name, column in ships.columns.items()}
        model = by_bank(1.0, {name: float(column[k]) for name, column in ships.coefficients.items()})
        for number, case in list(enumerate(cases))[::3]:
            rudder = 0.3 + state["rudder_bias"]
            outcome = sailed(state, model, case, rudder, case.duration).outcome
            hit = outcome.kind in ("grounded", "left validity")
            assert np.isfinite(ends.contact[number, k]) == hit, (k, case)
            if outcome.kind == "grounded":
                assert ends.contact[number, k] == pytest.approx(outcome.time, abs=2.5)  # a step
            met, clear = met + hit, clear + (not hit)
    assert met
    assert clear


@pytest.mark.parametrize("coefficients", ["estimated", "certain"])
def test_members_are_drawn_from_what_is_known(coefficients: str) -> None:
    now = estimate(60.0, 0.02, coefficients=coefficients)
    one = forecaster(coefficients)
    half = np.random.default_rng(0).standard_normal((8000, one.members.shape[1]))
    ships = sampled(one, now, np.concatenate([half, -half]))
    states = np.stack([*ships.columns.values()])
    np.testing.assert_allclose(states.mean(axis=1), now.normal.mean, rtol=1e-9, atol=1e-12)
    size = np.sqrt(np.diag(now.covariance))
    off = (np.cov(states) - now.covariance) / np.outer(size, size)
    assert np.abs(off).max() < 0.1
    from_bank = {term.name for term in ship().terms.terms if term.from_bank}
    drawn = [column / (ships.columns["bank"] if n in from_bank else 1.0) for n, column in ships.coefficients.items()]
    spread, told = np.std(drawn, axis=1), np.sqrt(np.diag(ship().covariance))
    assert (spread <= 1.1 * told).all()
    assert (spread > 0.2 * told).sum() >= (coefficients != "certain") * len(told) / 2


def test_a_forecast_has_the_samples_that_its_page_states() -> None:
    page, usual = (Path(__file__).parents[2] / "docs/warning.md").read_text("utf-8"), Forecaster(estimator())
    assert f"- {len(usual.members)} samples for {settings.HORIZON:g} s with the rudder unchanged" in page
    assert f"- {len(usual.escaping)} samples for each **escape**" in page


def test_a_ship_that_heads_into_a_current_across_stays_on_its_line() -> None:
    """Fixes along the middle, the heading four degrees off it: the estimate has the current, the forecast keeps it."""
    one, across = estimator(), 0.3
    one.forget()
    readings = {"gyro": -across / SPEED, "rate_of_turn": 0.0, "log": SPEED, "rudder": 0.0}
    for t in range(120):
        now = one.update(float(t), {"gnss": (100.0 + SPEED * t, 0.0), **readings})
    told = forecaster()(now, {"rudder": 0.0}, nobody_yet())
    assert now["current_across"] == pytest.approx(across, abs=2 * now.std["current_across"])
    assert not now.faults
    assert abs(forecaster().order(now.values)) < 0.05
    assert told.last_chance == math.inf
    assert np.abs(told.tracks.escape[:, 1]).max() < 5.0


def test_in_the_middle_nothing_is_met_and_towards_a_bank_everything() -> None:
    calm, lost = forecast(0.0), forecast(100.0, 0.3, 0.5)
    assert calm.as_is == 0.0
    assert calm.nobody < 1e-3
    assert calm.last_chance == calm.likely.contact == math.inf
    assert lost.as_is > 0.9
    assert lost.gone
    assert lost.likely.gone
    assert lost.side == "starboard"
    assert lost.likely.contact < 60.0
    assert "s to contact: bank to starboard" in lost.words()
    assert lost.escape.words().startswith("Hard to port, then")
    assert lost.to_dict()["escape"]["words"] == lost.escape.words()
    assert "no chance of grounding" in lost.notes[0]


def test_the_number_comes_first_and_a_sentence_of_forty_letters_has_it() -> None:
    told = forecast(40.0, 0.2, 0.5)
    assert 0.0 < told.last_chance < 60.0
    assert told.words()[:40].startswith(f"{told.last_chance:.0f} s to act: bank to starboard")


def test_the_later_somebody_acts_the_more_samples_are_lost() -> None:
    near, far = (forecast(40.0, psi, 0.5) for psi in (0.3, 0.2))
    assert near.last_chance < far.last_chance
    assert near.failing > far.failing
    assert near.escape.clearance < far.escape.clearance


def test_the_last_chance_lies_before_the_contact_and_that_of_the_likely_ship_later() -> None:
    told = forecast(40.0, 0.2, 0.5)
    assert told.last_chance <= told.likely.last_chance < told.likely.contact


def test_a_wrong_order_leaves_the_time_that_voyages_have() -> None:
    """Hard over to the worse side, by the plain engine: 2.5 s sooner an escape is in time, 2.5 s later it is not."""
    now = estimate(30.0, 0.0)
    told = forecaster()(now, {"rudder": 0.0}, nobody_yet())
    model = by_bank(now.values["bank"], dict(ship().coefficients))
    limit, rudder = ship().configuration.gear.limit, now.values["rudder_bias"]
    assert 10.0 < told.wrong_order < 60.0

    def grounded(since: float) -> bool:
        cases = [Case(since + 100.0, since, ordered=order) for order in (-limit, limit)]
        voyages = [sailed(now.values, model, one, rudder, one.duration) for one in cases]
        return any(voyage.outcome.kind in ("grounded", "left validity") for voyage in voyages)

    assert not grounded(told.wrong_order - 2.5)
    assert grounded(told.wrong_order + 2.5)
    assert forecast(100.0, 0.3, 0.5).wrong_order < forecast(60.0).wrong_order < told.wrong_order


def test_a_last_chance_is_where_rising_shares_cross() -> None:
    times, shares = np.array([0.0, 10.0, 20.0]), np.array([[0.0, 0.0, 0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(crossing(times, shares, 0.05), [15.0, -1.0, math.inf])


def test_a_gear_that_is_slower_leaves_less_time() -> None:
    """The gear as it is: at a quarter of its rate the last chance comes earlier."""
    gear = replace(ship().configuration.gear, rate_deg=0.6)
    slow = replace(ship(), configuration=ship().configuration.with_parts([gear]))
    one = Forecaster(Estimator(slow, SENSORS, waterway=canal()), members=40, escaping=40)
    now = estimate(40.0, 0.2)
    assert one(now, {"rudder": 0.5}, nobody_yet()).last_chance < forecast(40.0, 0.2, 0.5).last_chance - 5.0


@pytest.mark.parametrize("x", [800.0, 4500.0])
def test_the_rudder_that_is_needed_is_that_of_the_steady_course(x: float) -> None:
    at = {"x": x, "y": 40.0, "u": SPEED}
    course = nw.control.linearize(ship(), y=40.0, u=SPEED, waterway=canal(), at=x).course["rudder"]
    assert rudder_needed(estimator().filter.ship, canal(), at, {}) == pytest.approx(float(course), abs=1e-6)
    strong = rudder_needed(estimator().filter.ship, canal(), {**at, "bank": 2.0}, {})
    assert abs(strong) > 1.5 * abs(float(course)) or x > 3000.0
    assert rudder_needed(estimator().filter.ship, canal(), {**at, "y": 140.0}, {}) == math.inf


def steered(seconds: int, lapse: int | None, gain: float = 1.2) -> Helmsmen:
    """A hand that answers a swinging heading every 8 s, and from a time on leaves the rudder where it is."""
    one, rudder = Helmsmen(1, 230.0), 0.0
    for t in range(seconds):
        psi = 0.05 * math.sin(2 * math.pi * t / 90.0)
        if t % 8 == 0 and (lapse is None or t < lapse):
            rudder = -gain * psi
        one.update(*(np.array([value]) for value in (0.0, psi, 0.0, SPEED, rudder)))
    return one


def test_a_hand_at_work_is_seen_and_so_is_a_rudder_that_is_forgotten() -> None:
    assert steered(600, None).unattended[0] < 0.05
    assert steered(565, 520, gain=4.0).unattended[0] > 0.5
    assert steered(600, None).law(np.array([SPEED]))["by_psi"][0] == pytest.approx(1.2, rel=0.2)


def test_the_time_that_makes_the_level_is_ten_times_as_long_where_somebody_acts() -> None:
    left, nobody = np.array([15.0, 20.0, -1.0, math.inf]), np.array([1.0, 0.0, 1.0, 0.0])
    assert level_time(left, nobody).tolist() == pytest.approx([15.0, 200.0, 0.0, math.inf])


def test_the_odds_of_an_empty_helm_are_those_of_bayes_by_densities_of_student(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without lapses and returns meanwhile: a rudder that stays off the law, by the densities that SciPy has."""
    for name in ("LAPSE_INTERVAL", "RETURN_TIME", "HELM_MEMORY"):
        monkeypatch.setattr(settings, name, math.inf)
    one = Helmsmen(1, 230.0)
    odds = one.unattended[0] / (1.0 - one.unattended[0])
    for _ in range(30):
        one.update(*(np.array([value]) for value in (0.0, 0.0, 0.0, SPEED, 0.3)))
        ratio = student.pdf(one.off, 3.0, scale=0.2) / student.pdf(one.off, 3.0, scale=0.07)
        odds *= float(ratio[0]) ** (1.0 / 4.0)
        assert one.unattended[0] == pytest.approx(odds / (1.0 + odds), rel=1e-6)


def test_what_cannot_be_forecast_is_said() -> None:
    with pytest.raises(nw.InputError, match="no terms of a rudder"):
        Forecaster(Estimator(nw.published("mikkelsen2025_dtc"), SENSORS[:-1]))
    with pytest.raises(nw.InputError, match="members = 1: give a whole number from 2"):
        Forecaster(estimator(), members=1)
    fresh = Estimator(ship(), SENSORS, waterway=canal())
    with pytest.raises(nw.InputError, match="nothing is known of this ship yet"):
        forecaster()(fresh.update(0.0, {"gyro": 0.0}), {}, nobody_yet())
