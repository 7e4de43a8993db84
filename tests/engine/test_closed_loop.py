"""The loop: small motions of voyages, python-control, exact delays that ground, sensors."""

import math
from functools import cache
from typing import Any

import control
import numpy as np
import pytest
from full_size import Exactly, full_size, geared

import narrows as nw
from narrows.control import ClosedLoop, PredictiveHelm, RegulatorWeights, closed_loop, regulator
from narrows.estimation import CourseOverGround, GaussMarkov, Gnss, Gyro, Log, RateOfTurn, RudderIndicator

SPEED, HOLD = 4.5, 50.0


@cache
def law() -> nw.control.Regulator:
    return regulator(full_size(), HOLD, SPEED)


def loop(**told: Any) -> ClosedLoop:
    return closed_loop(full_size(), law(), **told)


SLOW = nw.SteeringGear(dead_time=2.0, lag=2.5)


@pytest.mark.parametrize(("dt", "gear"), [(1.0, None), (1.0, SLOW), (0.25, SLOW)])
def test_small_motions_of_voyages_are_those_of_the_state_space(dt: float, gear: Any) -> None:
    made = loop(dt=dt, gear=gear)
    system = made.state_space()
    voyage = made.simulate(200.0, y=HOLD + 1e-3)
    begun = np.zeros(len(made.states))
    begun[made.states.index("y")] = 1e-3
    response = control.initial_response(system, np.arange(len(voyage.t)) * dt, begun).outputs
    np.testing.assert_allclose(voyage.y - HOLD, response[0], atol=2e-6)
    np.testing.assert_allclose(voyage.rudder - made.course["rudder"], response[2], atol=2e-3 * abs(response[2]).max())


def test_poles_are_those_of_python_control() -> None:
    made = loop(gear=SLOW)
    found = made.state_space().poles()
    rates = np.log(found[np.abs(found) > 1e-12].astype(complex)).real
    assert made.poles()[0].real == pytest.approx(rates.max(), rel=1e-8)
    assert made.poles()[0].real < 0


def test_margins_bring_the_opened_loop_to_instability() -> None:
    made = loop(gear=SLOW)
    margins, opened = made.margins(), made.state_space(opened=True)

    def grows(factor: complex, steps: int = 0) -> bool:
        later = control.ss(np.eye(steps, k=-1), np.eye(steps)[:, :1], np.eye(steps)[-1:], 0, 1.0) if steps else 1.0
        return bool(np.abs(control.feedback(opened * later * factor, 1).poles()).max() > 1.0)

    assert not grows(1.0)
    for name in ("gain", "gain_down"):
        outward = 1.01 if name == "gain" else 1 / 1.01
        assert grows(margins[name] * outward)
        assert not grows(margins[name] / outward)
    steps = math.floor(margins["delay"])
    assert not grows(1.0, steps)
    assert grows(1.0, steps + 1)
    assert margins["sensitivity_peak"] == pytest.approx(1 / margins["distance"])


def test_an_unstable_loop_has_no_margins_and_is_described() -> None:
    far = regulator(full_size(), HOLD, SPEED, weights=RegulatorWeights(1e-3))
    made = closed_loop(full_size(), far, gear=nw.SteeringGear(dead_time=60.0, lag=5.0))
    assert made.poles()[0].real > 0
    margins = made.margins()
    assert margins.pop("sensitivity_peak") == math.inf
    assert set(margins.values()) == {0.0}
    assert made.summary() == (
        "Regulator at y = 50 m and u = 4.5 m/s, an order every 1 s, 60 s of dead time, 5 s of lag"
    )


def test_the_delay_that_it_tells_is_the_one_that_loses_the_ship() -> None:
    """Orders heard exactly so many seconds later, by a list of orders."""
    told = loop().margins()["delay"]

    def farthest(steps: int) -> float:
        begun = {"u": SPEED, "dt": 1.0, "duration": 3000.0, **loop().course}
        voyage = nw.simulate(full_size(), HOLD - 1.0, controller=Exactly(law(), steps), **begun)
        return float(np.abs(voyage.y[voyage.t > 1500.0] - HOLD).max(initial=0.0)) if len(voyage.t) > 1501 else math.inf

    assert farthest(math.floor(0.9 * told)) < 0.5
    assert farthest(math.ceil(1.1 * told)) > 1.5


def test_a_slow_gear_leaves_as_much_delay_as_the_margin() -> None:
    """More dead time of the gear, from a metre off: with 0.9 of the margin the ship keeps its line, not with 1.1."""
    left = loop(gear=nw.SteeringGear(dead_time=5.0, lag=4.0)).margins()["delay"]
    late = []
    for share in (0.9, 1.1):
        slower = loop(gear=nw.SteeringGear(dead_time=5.0 + share * left, lag=4.0))
        voyage = slower.simulate(6000.0, y=HOLD - 1.0)
        late.append(np.abs(voyage.y - HOLD)[voyage.t > 3000.0].max(initial=0.0) if voyage.t[-1] > 3001 else math.inf)
    assert late[0] < 0.05 < 0.1 < late[1]


def test_margins_of_gains_are_those_of_the_law_at_short_steps() -> None:
    """Continuous, by python-control: states, then the ordered rudder and the integral of the offset."""
    linear = nw.control.linearize(full_size(), HOLD, SPEED)
    whole = np.zeros((6, 6))
    whole[:4, :4], whole[4], whole[5, 0] = linear.A, np.negative(law().lines[0].gains), 1.0
    opened = control.ss(whole, np.append(linear.B[:, 0], [0.0, 0.0])[:, None], -np.eye(6)[4:5], 0)
    gains, phases, distances, _, crossings, _ = control.stability_margins(opened, returnall=True)
    sampled = loop(dt=0.05).margins()
    assert max(gains[gains < 1]) == pytest.approx(sampled["gain_down"], rel=0.01)
    assert min(abs(phases)) == pytest.approx(sampled["phase_deg"], rel=0.01)
    assert min(np.radians(phases % 360) / crossings) == pytest.approx(sampled["delay"], rel=0.01)
    assert min(distances) == pytest.approx(sampled["distance"], rel=0.01)


@pytest.mark.parametrize("dt", [0.1, 1.0, 2.0])
@pytest.mark.parametrize("helm", ["regulator", "predictive"])
def test_every_controller_holds_its_line_with_delay_and_lag(helm: str, dt: float) -> None:
    """5 s of delay and 4 s of lag."""
    made: dict[str, Any] = {"regulator": regulator, "predictive": PredictiveHelm}
    if helm == "predictive":
        pytest.importorskip("daqp")
    gear = nw.SteeringGear(dead_time=5.0, lag=4.0)
    law = made[helm](full_size(), HOLD, SPEED)
    voyage = closed_loop(full_size(), law, gear=gear, u=SPEED, dt=dt).simulate(400.0, y=HOLD + 1.0)
    assert voyage.outcome.kind == "afloat"
    assert np.abs(voyage.y - HOLD).max() < 2.0


SENSORS = [Gnss(1.5), Gyro(), RateOfTurn(), Log(), RudderIndicator()]


def test_a_loop_with_sensors_keeps_its_line() -> None:
    made = loop(sensors=SENSORS)
    one, same, other = (made.simulate(duration, seed) for duration, seed in ((200.0, 1), (60.0, 1), (60.0, 2)))
    assert np.abs(one.y - HOLD).max() < 4.0
    np.testing.assert_array_equal(one.y[: len(same.y)], same.y)
    assert np.abs(same.y - other.y).max() > 0.01


def test_easy_weights_need_twice_the_rudder_travel_of_true_states_at_most() -> None:
    """Two gusts of 15 m/s on 6000 m2; with the default weights the travel is 2.5 times that with true states."""
    helm = regulator(full_size(), HOLD, SPEED, weights=RegulatorWeights(heading_deg=5.0, stroke_time=0.3))
    gust = nw.wind_force(15.0, 6000.0)
    force = [(100.0, gust), (160.0, 0.0), (300.0, -gust), (360.0, 0.0)]
    pushed = {"Y": force, "N": [(t, 20.0 * value) for t, value in force]}
    sensors = [Gnss(1.5, coloured=None), CourseOverGround(), *SENSORS[1:]]
    voyages = [closed_loop(full_size(), helm, sensors=own).simulate(600.0, 1, **pushed) for own in ((), sensors)]
    true, seen = (np.abs(np.diff(voyage.rudder)).sum() for voyage in voyages)
    assert true < seen < 2 * true


def test_a_voyage_of_a_loop_lasts_forty_ship_lengths() -> None:
    length = full_size().configuration.ship.length
    assert loop(dt=2.0).simulate().t[-1] == pytest.approx(40 * length / SPEED, abs=2.0)


def test_declared_errors_of_sensors_are_drawn() -> None:
    """Fixes with a slow error of 1.5 m move the ship off its line by about as much; certain ones do not."""
    sure, slow = ([Gnss(0.1, coloured=error), *SENSORS[1:]] for error in (None, GaussMarkov(1.5, 60.0)))
    off = [
        np.std([loop(sensors=own).simulate(200.0, seed).y[100:] - HOLD for seed in range(2)]) for own in (sure, slow)
    ]
    assert off[0] < 0.5 < off[1] < 3.0


def test_a_helm_reads_the_rudder_with_the_noise_of_its_indicator() -> None:
    read: list[float] = []

    def amidships(t: float, state: Any) -> float:
        read.append(state.rudder)
        return 0.0

    noisy = [*SENSORS[:-1], RudderIndicator(noise=0.01, bias=0.0)]
    closed_loop(full_size(), amidships, y=HOLD, u=SPEED, sensors=noisy).simulate(300.0, 1)
    assert np.std(read[30:]) == pytest.approx(0.01, rel=0.2)  # Once the rudder is amidships


def test_late_readings_are_of_the_past() -> None:
    late = [Gnss(1.5, delay=3.0), *SENSORS[1:]]
    assert np.abs(loop(sensors=late).simulate(200.0, 1).y - HOLD).max() < 4.0


def test_a_ship_that_is_another_than_the_law_was_made_for_is_linearised_where_it_settles() -> None:
    other = full_size().with_coefficients(c_bank=1.1 * full_size().coefficients["c_bank"])
    assert closed_loop(other, law()).poles()[0].real < 0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: closed_loop(nw.published("mikkelsen2025_dtc"), law()), "no terms of a rudder"),
        (lambda: closed_loop(full_size(), lambda t, state: 0.0), "does not say for which y"),
        (lambda: loop(dt=0.0), "no time between orders"),
        (lambda: loop(estimator=object()), "give sensors too"),
        (lambda: closed_loop(full_size(), lambda t, state: 0.0, y=0.0, u=SPEED).margins(), "no law in arithmetic"),
        (lambda: closed_loop(full_size(), nw.ConstantRudder(0.3), y=0.0, u=SPEED).poles(), "does not keep this ship"),
    ],
)
def test_what_is_no_loop_is_one_sentence(make: Any, words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        make()


def test_a_gear_of_the_loop_is_its_ships() -> None:
    assert loop(gear=SLOW).model == geared(full_size(), dead_time=2.0, lag=2.5)
