"""Faults of one sensor on a twin whose truth is known: the right one is named and left out, and the truth is kept.

A ship of 4 m: a fault of 50 m or of 0.5 m/s at 230 m is one of 0.9 m or of 0.07 m/s here, a minute is 8 s.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from test_estimator import SENSORS, estimator, record, steered

import narrows as nw
from narrows.estimation import Estimate, Estimator, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from narrows.estimation.settings import STUCK_READINGS

BEGUN = 10.0
Fault = Callable[[float, dict[str, Any]], None]


def frozen(name: str, value: float | None = None, begun: float = BEGUN) -> Fault:
    kept: list[float] = []

    def fault(t: float, readings: dict[str, Any]) -> None:
        if t >= begun:
            kept.append(readings[name] if value is None else value)
            readings[name] = kept[0]

    return fault


def moved(across: Callable[[float], float]) -> Fault:
    def fault(t: float, readings: dict[str, Any]) -> None:
        x, y = readings["gnss"]
        readings["gnss"] = (x, y + across(t))

    return fault


def estimated(fault: Fault, seed: int = 3) -> tuple[list[Estimate], np.ndarray]:
    """The estimates and the truth, (times, states)."""
    table, truth = record(seed)
    one, found = estimator(), []
    for number, t in enumerate(table["t"].tolist()):
        told = {name: float(table[name][number]) for name in ("gyro", "rate_of_turn", "log", "rudder")}
        told["gnss"] = (table["gnss_x"][number], table["gnss_y"][number])
        fault(t, told)
        found.append(one.update(t, told))
    return found, truth


FAULTS: dict[str, tuple[Fault, str]] = {
    "log at 0": (frozen("log", 0.0), "log"),
    "fixes 0.9 m off": (moved(lambda t: 0.9 * (t >= BEGUN)), "gnss"),
    "fixes that creep": (moved(lambda t: 0.07 * max(t - BEGUN, 0.0)), "gnss"),
    "rate of turn at 0": (frozen("rate_of_turn", 0.0), "rate_of_turn"),
    "heading frozen": (frozen("gyro"), "gyro"),
    "rudder frozen": (frozen("rudder"), "rudder"),
}


@pytest.mark.parametrize("what", FAULTS)
def test_the_right_sensor_is_named_and_the_truth_kept(what: str) -> None:
    fault, name = FAULTS[what]
    found, truth = estimated(fault)
    assert name in found[-1].faults
    assert len(found[-1].faults) <= 1 + (name == "rudder")  # The rate of turn that a rudder explains may go too.
    assert any(f"{name} contradicts the others: left out" in note for note in found[-1].notes)
    off = np.abs([found[-1][state] - truth[-1, place] for place, state in enumerate(("x", "y", "psi", "u"))])
    np.testing.assert_array_less(off, [0.5, 0.12, 0.05, 0.2])
    assert (off < 3.5 * np.array([found[-1].std[state] for state in ("x", "y", "psi", "u")])).all()


def test_equal_readings_of_a_late_sensor_are_counted() -> None:
    one = estimator(SENSORS[0], Gyro(period=0.2, delay=0.4), *SENSORS[2:])
    for k, across in enumerate(np.random.default_rng(1).standard_normal(STUCK_READINGS + 5)):
        t = 0.2 * k
        one.update(
            t, gnss=(t, 0.02 * across), gyro=0.01, rate_of_turn=1e-4 * across, log=1.0 + 0.01 * across, rudder=0.0
        )
    assert one._bank._stuck({}) == {"gyro", "rudder"}


def test_a_log_at_0_from_the_start_is_found_out() -> None:
    """At 230 m and 4.5 m/s: within 15 s the speed is that of the fixes, and the log is named."""
    model = nw.scale_model(steered(), 230.0, 1025.0).model
    one = Estimator(model, [Gnss(), Gyro(0.0035), RateOfTurn(5e-4), Log(), RudderIndicator()])
    random = np.random.default_rng(2)
    for t in range(40):
        noise = random.standard_normal(4)
        fix = 4.5 * t + 1.5 * noise[0], 20.0 + 1.5 * noise[1]
        now = one.update(t, gnss=fix, gyro=0.0035 * noise[2], rate_of_turn=5e-4 * noise[3], log=0.0, rudder=0.0)
        if t == 15:
            assert now.faults == ("log",)
    assert abs(now["u"] - 4.5) < 1.0
    assert abs(now["x"] - 4.5 * 39) < 5.0


def blamed(seed: int) -> bool:
    """Whether a sensor is ever blamed where all are healthy."""
    return any(one.faults for one in estimated(lambda t, readings: None, seed)[0])


@pytest.mark.parametrize("seed", [1, 2])
def test_no_sensor_of_a_healthy_record_is_blamed(seed: int) -> None:
    assert not blamed(seed)


def test_in_one_record_of_twenty_at_most_a_healthy_sensor_is_blamed() -> None:
    """Each record is as long as 50 minutes at 230 m."""
    assert sum(map(blamed, range(1, 41))) <= 2


def test_a_band_widens_without_the_sensor_and_the_sensor_comes_back() -> None:
    found, truth = estimated(moved(lambda t: 0.9 * (8.0 <= t < 11.0)))
    faulty = [estimate.t for estimate in found if estimate.faults == ("gnss",)]
    assert 8.5 < faulty[0] < 10.0
    assert faulty[-1] < 18.0
    at = {round(estimate.t, 1): estimate for estimate in found}
    assert at[round(faulty[-1], 1)].std["y"] > 1.2 * at[7.8].std["y"]
    assert abs(found[-1]["y"] - truth[-1, 1]) < 0.08
    assert any(note.endswith("gnss agrees with the others again: used.") for one in found for note in one.notes)


def test_a_start_from_wrong_readings_is_begun_anew() -> None:
    """The first second of fixes lies 1 m off: within some seconds the estimate is that of the other fixes."""
    found, truth = estimated(moved(lambda t: 1.0 * (t < 1.0)))
    assert any("started again from the sensors that agree" in note for one in found for note in one.notes)
    assert abs(found[-1]["y"] - truth[-1, 1]) < 0.08
    assert not found[-1].faults


def test_adopted_states_are_marginals_of_the_others() -> None:
    """To a filter with a fault and back: the state is the same; with it, the fault is at its prior."""
    filter = estimator().filter
    now = estimated(lambda t, readings: None)[0][30].joint
    assert now is not None
    more = filter.with_faults(frozenset({"gyro"}))
    there = more.adopt(now, filter)
    back = filter.adopt(there, more)
    np.testing.assert_allclose(back.mean, now.mean)
    np.testing.assert_allclose(back.covariance, now.covariance, rtol=1e-9, atol=1e-15)
    place = more.states.places["gyro_fault"]
    assert math.sqrt(there.covariance[place, place]) == pytest.approx(100.0 * math.radians(0.15))


def test_a_likelihood_is_that_of_the_innovations() -> None:
    """Of the readings one after the other; a refused one counts as at its gate."""
    from scipy.stats import multivariate_normal

    one = estimator(Gnss(0.02, period=0.2, coloured=None), *SENSORS[1:]).filter
    size = len(one.states) + one.estimated
    state = np.zeros(size)
    state[3] = 1.0
    from narrows.estimation.states import Gaussian

    now = Gaussian(state, 0.01 * np.eye(size))
    _, seen = one.update(0.0, now, {"log": (1.02,), "gyro": (0.004,)}, one.monitor())
    spread = np.diag([1e-4 + 0.01**2, 1e-4 + math.radians(0.15) ** 2])
    whole = multivariate_normal([1.0, 0.0], spread).logpdf([1.02, 0.004]) + math.log(2.0 * math.pi)
    assert seen.log_likelihood == pytest.approx(whole)
