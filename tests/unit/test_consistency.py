"""Consistency on twins: chi-squared where the filter is told the truth, and far from it where it is told a lie."""

import json
from dataclasses import KW_ONLY, dataclass, replace
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.stats import chi2
from test_estimator import SENSORS, steered

import narrows as nw
from engine_models import bent
from narrows.base.files import to_json
from narrows.base.results import BaseResult
from narrows.estimation import Consistency, Estimator, Gnss, Prior, ProcessNoise, RudderIndicator, Sensor, consistency
from narrows.estimation.consistency import sail_twins
from narrows.simulation.kernel_run import ShipLanes

ALL = (*SENSORS, RudderIndicator())


@cache
def tried(**options: Any) -> Consistency:
    told = {"y": 0.4, "u": 1.0, "twins": 12, "duration": 40.0, "excitation": 0.05, "seed": 4, **options}
    return consistency(steered(), ALL, **told)


def test_a_filter_that_knows_its_ship_is_as_sure_as_it_should_be() -> None:
    """Twelve twins, whose errors hang together over time: the mean of each is one number."""
    found = tried(coefficients="certain")
    each = np.nanmean(found.nees[:, found.counted], axis=1) / len(found.states)
    assert abs(each.mean() - 1.0) < 4 * each.std() / np.sqrt(len(each))
    for name, nis in found.nis.items():
        told = nis[:, found.counted]
        count = np.isfinite(told).sum() * found.numbers[name]
        assert chi2.ppf(1e-4, count) < np.nansum(told) < chi2.isf(1e-4, count), name
    assert all(0.8 < share for share in found.covered.values())


def test_bounds_are_those_of_chi_squared() -> None:
    found = tried(coefficients="certain")
    draws = np.random.default_rng(0).chisquare(len(found.states), (20_000, 12)).mean(axis=1) / len(found.states)
    low, high = found.bounds()
    assert np.mean((low <= draws) & (draws <= high)) == pytest.approx(0.95, abs=0.01)


def test_coefficients_that_are_wrong_show_in_the_state_and_not_in_the_innovations() -> None:
    """Coefficients known to 50 %: the innovations of a filter that trusts them are as good as its errors are bad.

    The mean of 12 twins is decided by one of them.
    """
    vague = replace(steered(), covariance=100.0 * np.asarray(steered().covariance))
    told = {"y": 0.2, "u": 1.0, "twins": 24, "duration": 40.0, "excitation": 0.1, "seed": 4, "drawn": True}
    trusting, honest = (consistency(vague, ALL, coefficients=how, **told) for how in ("certain", "estimated"))
    assert trusting.mean_nees > 2.0 * honest.mean_nees
    assert abs(trusting.mean_nis["gnss"] - 1.0) < 0.1
    each = np.nanmean(honest.nees[:, honest.counted], axis=1) / len(honest.states)
    assert each.mean() - 4 * each.std() / np.sqrt(len(each)) < 1.0


def test_a_fault_is_told_to_the_estimator_alone() -> None:
    def jump(t: float, readings: dict[str, Any]) -> dict[str, Any]:
        return {**readings, "gnss": readings["gnss"] + np.array([0.0, 1.0 * (t >= 30.0)])}

    found = tried(fault=jump)
    told = found.refused["gnss"] | found.suspected["gnss"]
    assert told[:, found.t >= 30.0].mean() > 0.9
    assert not found.refused["gnss"][:, found.t < 30.0].any()
    before = found.t < 30.0
    np.testing.assert_array_equal(found.error[:, before], tried().error[:, before])


def test_a_twin_whose_estimate_lies_in_a_bank_is_not_judged_until_the_next_start() -> None:
    """From 1 s on a rudder of 0.4 rad is indicated, which no twin has, and no sensor contradicts it."""

    def lost(t: float, readings: dict[str, Any]) -> dict[str, Any]:
        return {"rudder": np.array([0.4])} if t >= 1.0 else readings

    found = consistency(steered(), ALL, 0.4, 1.0, twins=2, duration=12.0, coefficients="certain", fault=lost)
    assert found.aground == 0
    for own in (found.nees, found.error[..., 1], found.std[..., 1]):
        assert np.isfinite(own[:, (found.t > 1.0) & (found.t < 10.0)]).all()
        assert np.isnan(own[:, found.t > 11.0]).all()


def test_a_gyro_that_counts_whole_turns_has_the_same_errors() -> None:
    short = {"y": 0.4, "u": 1.0, "twins": 2, "duration": 4.0}
    once = consistency(steered(), ALL, **short)
    turned = consistency(steered(), ALL, **short, fault=lambda t, told: {**told, "gyro": told["gyro"] + 2 * np.pi})
    np.testing.assert_allclose(turned.error, once.error, atol=1e-9)
    np.testing.assert_allclose(turned.nees, once.nees, rtol=1e-6)


OTHERS: dict[str, Any] = {
    "y": 0.2, "u": 0.9, "twins": 11, "duration": 30.0, "drawn": True, "seed": 5, "x": 2.0, "excitation": 0.0,
    "controller": nw.ConstantRudder(0.0), "fault": lambda t, readings: {},
    "waterway": nw.straight_waterway(nw.Canal(7.5), 500.0), "noise": ProcessNoise(sway=0.01), "coefficients": "certain",
    "memory": 5.0, "refusing": 0.3,
}  # fmt: skip


@pytest.mark.parametrize("name", OTHERS)
def test_every_argument_changes_the_answer(name: str) -> None:
    short = {"y": 0.4, "u": 1.0, "twins": 3, "duration": 4.0}
    model = steered()
    first = consistency(model, ALL, **short)
    other = consistency(model, ALL, **{**short, name: OTHERS[name]})
    assert first.std.tobytes() != other.std.tobytes() or first.error.tobytes() != other.error.tobytes()


def test_twins_sail_in_the_middle_at_the_speed_of_a_voyage_unless_given() -> None:
    short = {"twins": 1, "duration": 2.0}
    usual = consistency(steered(), ALL, **short)
    given = consistency(steered(), ALL, 0.0, nw.simulate(steered(), y=0.4, duration=1.0).u[0], **short)
    assert usual.error.tobytes() == given.error.tobytes()


REFUSED = {
    "no twins": lambda: consistency(steered(), ALL, twins=0),
    "no time": lambda: consistency(steered(), ALL, duration=-1.0),
    "a helm that is none": lambda: consistency(steered(), ALL, controller=3.0),
    "a place in the bank": lambda: consistency(steered(), ALL, 3.4),
    "all aground": lambda: consistency(
        steered(), ALL, 0.4, 1.0, twins=2, duration=20.0, controller=nw.ConstantRudder(0.4)
    ),
    "no sensors": lambda: consistency(steered(), [], 0.4, 1.0),
}


@pytest.mark.parametrize("call", REFUSED.values(), ids=REFUSED)
def test_what_is_wrong_is_refused(call: Any) -> None:
    with pytest.raises(nw.InputError):
        call()


def test_a_sensor_of_ones_own_is_a_sensor() -> None:
    """A receiver that tells but the offset, written by a user."""

    @dataclass(frozen=True)
    class Across(Sensor):
        noise: float = 0.05
        _: KW_ONLY
        name: str = "laser"
        state: ClassVar[str] = "y"

        def start(self, reading: Any) -> Any:
            return {}

    told = {"y": 0.4, "u": 1.0, "twins": 4, "duration": 20.0, "coefficients": "certain"}
    with_it, without = (consistency(steered(), sensors, **told) for sensors in ([*ALL, Across(period=0.2)], ALL))
    assert 0.8 < with_it.mean_nis["laser"] < 1.2
    y = with_it.states.index("y")
    assert np.nanmean(with_it.std[..., y]) < np.nanmean(without.std[..., y])
    assert with_it.rmse["y"] < 0.05


def test_twins_see_the_bend_ahead_as_a_voyage_does() -> None:
    """The regulator, on twins without noise: where they are is where the engine's own voyage is."""
    way, model = bent(6.0, 7.5), steered()
    helm = nw.control.regulator(model, 0.2, 1.0, waterway=way)
    calm = ProcessNoise(**dict.fromkeys(vars(ProcessNoise()), 0.0))
    known = Prior(sway=0.0, yaw_rate=0.0, bank=0.0, current=0.0, current_across=0.0)
    sensors = (*SENSORS, RudderIndicator(bias=0.0, noise=0.0))
    silent = Estimator(model, sensors, waterway=way, noise=calm, prior=known).filter
    twins = sail_twins(silent, helm, (30.0, 0.2, 1.0, 0.0), 2, 30.0, False, 0.0, 0)
    start = dict(zip(silent.states.names, twins.states[0, 0], strict=True))
    voyage = nw.simulate(
        model, **{name: start[name] for name in ("x", "y", "psi", "u", "v", "r")}, duration=30.0, dt=0.2,
        controller=helm, waterway=way,
    )  # fmt: skip
    assert np.ptp(voyage.psi) > 0.02
    assert np.abs(twins.states[::5, 0, 1] - np.interp(twins.t[::5], voyage.t, voyage.y)).max() < 0.02


def test_results_speak_and_draw() -> None:
    found = tried(twins=2, duration=12.0)
    assert isinstance(found, BaseResult)
    assert json.loads(to_json(found.to_dict()))["twins"] == len(found.nees)
    assert found.plot().axes[0].has_data()
    assert list(found.to_dataframe().index) == list(found.states)
    assert found.summary().splitlines()[0].startswith("NEES of ")


def test_late_and_seldom_sensors_come_when_they_are_due() -> None:
    from narrows.estimation import Estimator
    from narrows.estimation.consistency import sail_twins

    one = Estimator(steered(), [*SENSORS[1:], Gnss(0.02, period=0.6, delay=0.4, coloured=None), RudderIndicator()])
    pilot = nw.control.regulator(steered(), 0.4, 1.0)
    twins = sail_twins(one.filter, pilot, (0.0, 0.4, 1.0, 0.0), 40, 6.0, False, 0.0, 1)
    told = twins.readings["gnss"]
    due = np.isfinite(told[:, 0, 0])
    np.testing.assert_allclose(twins.t[due], np.arange(0.6, 6.01, 0.6))
    off = told[due] - twins.states[np.flatnonzero(due) - 2][..., :2]
    assert off.std() == pytest.approx(0.02, rel=0.1)


@pytest.mark.parametrize("period", [0.05, 1.0])
def test_the_rudder_of_a_twin_turns_evenly_from_order_to_order(period: float) -> None:
    """Twins without noise, beside forty steps of the engine between two readings, with the rudder linear in time."""
    calm, model = ProcessNoise(**dict.fromkeys(vars(ProcessNoise()), 0.0)), steered()
    known = Prior(sway=0.0, yaw_rate=0.0, bank=0.0, current=0.0, current_across=0.0)
    sensors = (*(replace(sensor, period=period) for sensor in SENSORS), RudderIndicator(bias=0.0))
    silent = Estimator(model, sensors, noise=calm, prior=known).filter
    helm = nw.control.regulator(model, 0.3, 1.0)
    twins = sail_twins(silent, helm, (0.0, 0.3, 1.0, 0.0), 2, 8 * period, False, 0.3, 0)
    lanes = ShipLanes(silent.ship, silent.states.names, 2, None)
    assert np.abs(np.diff(twins.indicated[:, 0, 0])).max() > 0.1 * period
    for k in range(8):
        now, (before, after) = twins.states[k], twins.indicated[k : k + 2]
        for part in range(40):
            here, there = (before + share / 40 * (after - before) for share in (part, part + 1))
            now = lanes.advance(now, period / 40, here, there)
        np.testing.assert_allclose(twins.states[k + 1][:, :6], now[:, :6], rtol=2e-4, atol=1e-6)
