"""Forecasts beside voyages of the plain engine, one at a time; beside what is known, and beside steady courses."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from transit import SENSORS, SPEED, canal, estimate, estimator, ship

import narrows as nw
from narrows.estimation import Estimator
from narrows.simulation.controllers import SwitchedLaw
from narrows.warning.forecasting.forecast import AS_IS, CASES, LIKELY, BankForecast
from narrows.warning.forecasting.forecaster import Forecaster, Members, rudder_needed

FAN_MEMBERS = 32  # ships of the fan

MEMBERS = 40
STATE = ("x", "y", "psi", "u", "v", "r")


@cache
def forecaster(coefficients: str = "considered") -> Forecaster:
    return Forecaster(estimator(coefficients), members=MEMBERS)


def forecast(y: float, psi: float = 0.0, rudder: float = 0.0) -> BankForecast:
    return forecaster()(estimate(y, psi), {"rudder": rudder})


def sailed(state: dict[str, float], model: nw.Model, case: object, rudder: float) -> nw.Outcome:
    """The same future as one voyage."""
    side = math.copysign(model.configuration.gear.limit, case.hard_over) if case.hard_over else rudder
    pilot = nw.control.regulator(ship(), 0.0, SPEED, waterway=canal(), at=800.0)
    law = SwitchedLaw(pilot, side, case.taken_over)
    told = {name: state[name] for name in STATE}
    options = {"waterway": canal(), "controller": law, "rudder": rudder, "dt": 2.5, "contact": "corners"}
    return nw.simulate(model, **told, duration=case.duration, **options).outcome


def test_the_fan_is_where_voyages_go() -> None:
    """The most likely one each ten seconds, as it is and with a pilot, by the plain engine; members lie about it."""
    now, one = estimate(60.0, 0.02), forecaster()
    one(now, {"rudder": 0.02})
    fan, state = one.fan(now, {"rudder": 0.02}), now.values
    model = by_bank(state["bank"], dict(ship().coefficients))
    pilot, rudder = nw.control.regulator(ship(), 0.0, SPEED, waterway=canal(), at=800.0), 0.02 + state["rudder_bias"]
    for track, taken_over in ((fan.likely, 1e9), (fan.pilot, 0.0)):
        law = SwitchedLaw(pilot, rudder, taken_over)
        told = {name: state[name] for name in STATE}
        water = canal().with_water(current=state["current"])
        options = {"waterway": water, "controller": law, "rudder": rudder, "dt": 2.5, "contact": "corners"}
        voyage = nw.simulate(model, **told, duration=60.0, **options)
        sailed = np.stack([np.interp(fan.times[:6], voyage.t, voyage[name]) for name in ("x", "y", "psi")], axis=1)
        np.testing.assert_allclose(track[:6], sailed, atol=1e-3)
    assert fan.members.shape == (FAN_MEMBERS, 12, 3)
    np.testing.assert_allclose(fan.members[:, 2].mean(axis=0), fan.likely[2], atol=2.0)


def by_bank(bank: float, coefficients: dict[str, float]) -> nw.Model:
    banks = {term.name: bank * coefficients[term.name] for term in ship().terms.terms if term.from_bank}
    return replace(ship(), coefficients={**coefficients, **banks})


@pytest.mark.parametrize("coefficients", ["considered", "estimated"])
def test_every_lane_is_a_voyage(coefficients: str) -> None:
    """Of eight members and of the most likely run, in every case: one after the other by the plain engine."""
    now, one, met = estimate(100.0, 0.16, coefficients=coefficients), forecaster(coefficients), 0
    one(now, {"rudder": 0.02})
    drawn = one._members.drawn(now), one._members.likely(now)
    ends = one._lanes([one._ships(ships, 0.02) for ships in drawn])
    for ships, end, cases in zip(drawn, ends, (CASES, LIKELY), strict=True):
        for k in range(min(len(ships.states), 6)):
            state = dict(zip(now.states.names, ships.states[k], strict=True))
            model = by_bank(state["bank"], dict(zip(ship().terms.names, ships.coefficients[k], strict=True)))
            for number, case in list(enumerate(cases))[:: len(cases) // 8]:
                outcome = sailed(state, model, case, 0.02 + state["rudder_bias"])
                hit = outcome.kind in ("grounded", "left validity")
                assert np.isfinite(end.contact[number, k]) == hit, (k, case)
                if outcome.kind == "grounded":
                    assert end.contact[number, k] == pytest.approx(outcome.time, abs=2.5)  # a step
                    assert (end.side[number, k] > 0) == (outcome.side == "starboard")
                met += hit
    assert met > 8


@pytest.mark.parametrize("coefficients", ["considered", "estimated", "certain"])
def test_members_are_drawn_from_what_is_known(coefficients: str) -> None:
    now = estimate(60.0, 0.02, coefficients=coefficients)
    drawn = Members(estimator(coefficients).filter, 16000, 0).drawn(now)
    np.testing.assert_allclose(drawn.states.mean(axis=0), now.normal.mean, rtol=1e-9, atol=1e-12)
    size = np.sqrt(np.diag(now.covariance))
    off = (np.cov(drawn.states.T) - now.covariance) / np.outer(size, size)
    assert np.abs(off).max() < 0.1
    spread, told = drawn.coefficients.std(axis=0), np.sqrt(np.diag(ship().covariance))
    assert (spread <= 1.1 * told).all()
    assert (spread > 0.2 * told).sum() >= (coefficients != "certain") * len(told) / 2


def test_in_the_middle_nothing_is_met_and_towards_a_bank_everything() -> None:
    calm, lost = forecast(0.0), forecast(100.0, 0.3, 0.5)
    assert calm.as_it_is.soon == calm.pilot_now.probability == 0.0
    assert calm.likely.last_chance == calm.likely.contact == math.inf
    assert not calm.likely.gone
    assert lost.as_it_is.soon > 0.9
    assert lost.likely.gone
    assert lost.likely.side == lost.as_it_is.side == "starboard"
    assert lost.likely.contact < 60.0
    assert "last chance gone" in lost.summary()
    assert lost.to_dict()["cases"][AS_IS]["soon"] == lost.as_it_is.soon
    assert "no chance of grounding" in lost.notes[0]


def test_the_sooner_a_pilot_takes_over_the_better() -> None:
    told = forecast(40.0, 0.2, 0.5)
    shares = [told.cases[case.name].probability for case in CASES[1:8]]
    assert shares == sorted(shares)
    assert 0.0 < shares[-1]
    assert told.cases["hard to starboard"].probability > told.cases["hard to port"].probability


def test_the_last_chance_lies_before_the_contact() -> None:
    told = forecast(40.0, 0.3, 0.5)
    assert not told.likely.gone
    assert 0.0 < told.likely.last_chance < told.likely.contact


@pytest.mark.parametrize("x", [800.0, 4500.0])
def test_the_rudder_that_is_needed_is_that_of_the_steady_course(x: float) -> None:
    at = {"x": x, "y": 40.0, "u": SPEED}
    course = nw.control.linearize(ship(), y=40.0, u=SPEED, waterway=canal(), at=x).course["rudder"]
    assert rudder_needed(estimator().filter.ship, canal(), at, {}) == pytest.approx(float(course), abs=1e-6)
    strong = rudder_needed(estimator().filter.ship, canal(), {**at, "bank": 2.0}, {})
    assert abs(strong) > 1.5 * abs(float(course)) or x > 3000.0
    assert rudder_needed(estimator().filter.ship, canal(), {**at, "y": 140.0}, {}) == math.inf


def test_the_margin_is_what_the_gear_has_left() -> None:
    told = forecast(40.0)
    assert told.rudder_margin == pytest.approx(ship().configuration.gear.limit - abs(told.rudder_needed))


def test_what_cannot_be_forecast_is_said() -> None:
    with pytest.raises(nw.InputError, match="no terms of a rudder"):
        Forecaster(Estimator(nw.published("mikkelsen2025_dtc"), SENSORS[:-1]))
    with pytest.raises(nw.InputError, match="members = 1: give a whole number from 2"):
        Forecaster(estimator(), members=1)
    fresh = Estimator(ship(), SENSORS, waterway=canal())
    with pytest.raises(nw.InputError, match="nothing known of this ship yet"):
        forecaster()(fresh.update(0.0, {"gyro": 0.0}), {})
