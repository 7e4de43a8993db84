"""The estimator beside voyages of the engine, exact derivatives, the map, and itself by another way."""

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import narrows as nw
from engine_models import bent
from narrows.codegen.cache import compiled_loops
from narrows.estimation import (
    CourseOverGround,
    Estimator,
    GaussMarkov,
    Gnss,
    Gyro,
    Log,
    Prior,
    ProcessNoise,
    RateOfTurn,
    RudderIndicator,
    square_roots,
)
from narrows.estimation.consistency import sail_twins
from narrows.estimation.ship_filter import MEMORIES
from narrows.estimation.states import Columns, Gaussian, StateNames
from nightly import draws

SENSORS = (Gnss(0.02, period=0.2), Gyro(period=0.2), RateOfTurn(0.002, period=0.2), Log(0.01, period=0.2))
POSE = ("x", "y", "psi", "u", "v", "r")


@cache
def steered() -> nw.Model:
    """The published hull with a rudder beside weak banks, its coefficients known to 5 %."""
    own = nw.published("mikkelsen2025_dtc")
    lift = {f"{axis}_u{motion}": own.coefficients[f"{axis}_{motion}"] for axis in "bc" for motion in "vr"}
    helm = {"a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}
    cross = {"a_vv": 40.0, "a_vr": -300.0, "a_rr": 30.0, "b_vr": 120.0, "b_rv": -60.0, "c_vr": -45.0, "c_rv": 80.0}
    known = {**own.coefficients, **lift, **helm, **cross, "b_bank": 0.05, "c_bank": 0.02}
    values = {name: known[name] for name in nw.STEERED.names}
    ship = replace(own.configuration.ship, flow_straightening=0.5)
    configuration = replace(own.configuration, ship=ship, steering=nw.SteeringGear(25.0, 18.0))
    covariance = np.diag((0.05 * np.array(list(values.values()))) ** 2)
    return replace(nw.Model(configuration, nw.STEERED, values), covariance=covariance)


def estimator(*sensors: Any, **options: Any) -> Estimator:
    return Estimator(steered(), [*(sensors or SENSORS), RudderIndicator()], **options)


def lanes(count: int = 3, waterway: nw.Waterway | None = None) -> Any:
    from narrows.simulation.kernel_run import ShipLanes

    return ShipLanes(estimator().filter.ship, estimator().filter.states.names, count, waterway)


STATE = {"x": 3.0, "y": 0.4, "psi": 0.03, "u": 1.0, "v": 0.02, "r": 0.01, "bank": 1.0}


def row(**changed: float) -> np.ndarray:
    return estimator().filter.states.vector({**STATE, **changed})


def rows(**changed: float) -> np.ndarray:
    return np.tile(row(**changed), (3, 1))


def rudder(angle: float) -> np.ndarray:
    return np.full((3, 1), angle)


def after(states: np.ndarray, **told: Any) -> np.ndarray:
    made = lanes(3, told.pop("waterway", None))
    return made.advance(states, 0.2, rudder(told.get("start", 0.1)), rudder(told.get("end", 0.1)))[0]


def sailed(model: nw.Model, **told: Any) -> list[float]:
    start = {name: value for name, value in STATE.items() if name in POSE}
    voyage = nw.simulate(model, **{**start, "duration": 0.2, "dt": 0.2, "rudder": 0.1, **told})
    return [voyage.outcome.state[name] for name in POSE]


def test_lanes_move_as_voyages_do() -> None:
    np.testing.assert_allclose(after(rows())[:6], sailed(steered()), rtol=1e-12, atol=1e-14)


def test_states_are_those_that_may_deviate() -> None:
    """The motion, then what has a prior or a walk: a rudder without an error of its zero has no state for it."""
    usual = ("x", "y", "psi", "u", "v", "r", "bank", "current", "current_across", "rudder_bias")
    of_gnss = ("gnss_x_wander", "gnss_y_wander")
    assert estimator().filter.states.names == (*usual, *of_gnss)
    exact = Estimator(steered(), [*SENSORS, RudderIndicator(bias=0.0)], prior=Prior(current=0.0, current_across=0.0))
    assert exact.filter.states.names == (*usual[:-1], *of_gnss)  # a current may walk from 0
    calm = ProcessNoise(current=0.0, current_across=0.0, bank=0.0)
    still = Estimator(steered(), SENSORS, prior=Prior(current=0.0, current_across=0.0, bank=0.0), noise=calm)
    assert still.filter.states.names == (*usual[:6], *of_gnss)


def test_a_long_time_is_taken_in_steps_no_longer_than_the_limit() -> None:
    """The rudder turns on from step to step, as in as many calls."""
    made = replace(estimator().filter, step=0.25)
    begun = Gaussian(np.append(row(), np.zeros(made.estimated)), 0.01 * np.eye(len(made.states) + made.estimated))
    turned, now = [0.1 + 0.02 * n for n in range(6)], begun
    for number, (first, then) in enumerate(pairwise(turned), 1):
        (one,) = made.advance(now, 0.25, np.array([first]), np.array([then]))
        now = one.state
        whole = made.advance(begun, 0.25 * number, np.array([turned[0]]), np.array([then]))
        assert len(whole) == number
        np.testing.assert_allclose(whole[-1].state.mean, now.mean, rtol=1e-12, atol=1e-14)


def test_the_strength_of_the_bank_is_a_factor_on_its_terms() -> None:
    stronger = {term.name: 1.7 * steered().coefficients[term.name] for term in steered().terms.terms if term.from_bank}
    model = steered().with_coefficients(**stronger)
    np.testing.assert_allclose(after(rows(bank=1.7))[:6], sailed(model), rtol=1e-12, atol=1e-14)
    assert not np.allclose(after(rows(bank=1.7))[1:6], sailed(steered())[1:], rtol=1e-9)


def test_the_bias_of_the_rudder_is_an_angle_more() -> None:
    np.testing.assert_allclose(
        after(rows(rudder_bias=0.04), start=0.06, end=0.06)[:6], sailed(steered()), rtol=1e-12, atol=1e-14
    )


def test_a_current_is_that_of_the_engine() -> None:
    """Known to the waterway or only to the state: the same way, to the second order of a step."""
    still = nw.straight_waterway(nw.Canal(7.0), 100.0)
    flowing = replace(still, current=0.3)
    known = after(rows(current=0.3), waterway=flowing)
    np.testing.assert_allclose(known[:6], sailed(steered(), waterway=flowing), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(after(rows(current=0.3), waterway=still)[:6], known[:6], rtol=1e-9)
    assert known[0] > after(rows(), waterway=still)[0] + 0.05


def test_a_current_carries_round_a_bend_as_the_engine_does() -> None:
    still = bent(4.0, 7.0)
    flowing = replace(still, current=0.3)
    known = after(rows(x=60.0, current=0.3), waterway=flowing)
    np.testing.assert_allclose(after(rows(x=60.0, current=0.3), waterway=still)[:6], known[:6], rtol=0, atol=1e-4)
    turned = known[2] - after(rows(x=60.0), waterway=still)[2]
    assert turned == pytest.approx(-0.06 * lanes(3, still).bend(60.0), rel=0.05)
    assert turned != 0.0


def test_coefficients_move_the_state_as_the_exact_derivatives_do() -> None:
    """After a short step the covariance of state and coefficients is the Jacobian by these times their root."""
    made = estimator(memory=math.inf).filter
    size, more, duration = len(made.states), made.estimated, 1e-3
    start = Gaussian(np.append(row(), np.zeros(more)), np.diag([0.0] * size + [1.0] * more))
    moved = made.predict(start, duration, np.array([0.1]), np.array([0.1])).state
    numbers = {name: value for name, value in STATE.items() if name in POSE}
    slopes = nw.jacobian(steered(), **numbers, rudder=0.1).G @ made.root
    np.testing.assert_allclose(moved.covariance[3:6, size:] / duration, slopes[3:6], rtol=1e-2, atol=1e-9)


@pytest.mark.parametrize("memory", [5.0, math.inf])
def test_what_was_learned_of_a_coefficient_fades_exponentially(memory: float) -> None:
    """A first-order chain: its mean goes as exp(-t / memory), and its variance back to that of the fit."""
    made = estimator(memory=memory).filter
    size, more, duration = len(made.states), made.estimated, 0.05
    learned = Gaussian(
        np.concatenate([row(), np.full(more, 1.5)]),
        np.diag(np.concatenate([np.full(size, 1e-6), np.full(more, 0.5)])),
    )
    after = made.predict(learned, duration, np.array([0.1]), np.array([0.1])).state
    left = math.exp(-duration / memory)
    np.testing.assert_allclose(after.mean[size:], 1.5 * left, rtol=1e-9)
    spread = (after.root[size:] ** 2).sum(axis=1)
    np.testing.assert_allclose(spread, 1.0 + (0.25 - 1.0) * left**2, rtol=1e-3 if math.isfinite(memory) else 1e-9)


@pytest.mark.parametrize("place", [40.0, 60.0, 90.0])
def test_an_antenna_stands_where_the_map_says(place: float) -> None:
    way = bent(4.0, 7.0)
    bend = lanes(3, way).bend(place)
    at = Columns(np.array([[place, 0.7, 0.2, 1.0, 0.0, 0.0]]), StateNames(POSE), bend)
    x, y = Gnss(forward=1.1, starboard=-0.3).measured(at)
    (midship,), (heading,) = way.to_map(np.array([place]), np.array([0.7]), np.array([0.2]))
    north, east = math.cos(heading), math.sin(heading)
    antenna = midship + 1.1 * np.array([east, north]) - 0.3 * np.array([north, -east])
    (there,), _ = way.to_map(np.asarray(x), np.asarray(y), np.zeros(1))
    np.testing.assert_allclose(there, antenna, atol=2e-3)


@cache
def record(seed: int = 3, *sensors: Any) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """What a twin's sensors tell, and its truth."""
    made = estimator(*sensors).filter
    pilot = nw.control.regulator(steered(), 0.4, 1.0)
    twins = sail_twins(made, pilot, (0.0, 0.4, 1.0, pilot.lines[0].psi), 1, 20.0, False, 0.05, seed)
    table = {"t": twins.t, "rudder": twins.indicated[:, 0, 0]}
    for name, sensor in made.sensors.items():
        table |= {field: twins.readings[name][:, 0, k] for k, field in enumerate(sensor.fields)}
    return table, twins.states[:, 0]


def beginning() -> dict[str, np.ndarray]:
    """The first seconds of a record."""
    return {name: column[:30] for name, column in record()[0].items()}


def test_a_late_reading_is_put_where_it_belongs() -> None:
    """A second receiver whose fixes come two steps late tells what one does whose fixes come at once."""
    table = beginning()
    fixes = np.stack([table["gnss_x"], table["gnss_y"]], axis=1) + 0.01
    late, punctual = (
        estimator(*SENSORS, Gnss(0.03, period=0.2, delay=age, name="aft"), refusing=0.0) for age in (0.4, 0.0)
    )
    for number, t in enumerate(table["t"].tolist()):
        told = {name: float(table[name][number]) for name in ("gyro", "rate_of_turn", "log", "rudder")}
        told |= {"gnss": (table["gnss_x"][number], table["gnss_y"][number])}
        now = punctual.update(t, {**told, "aft": fixes[number]} if number > 2 else told)
        then = late.update(t, {**told, "aft": fixes[number - 2]} if number > 4 else told)
    end = float(table["t"][-1])
    for k in (1, 2):
        now = punctual.update(end + 0.2 * k)
        then = late.update(end + 0.2 * k, aft=fixes[k - 3])
    np.testing.assert_allclose(list(then.values.values()), list(now.values.values()), rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(then.covariance, now.covariance, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("late", [("gnss",), ("gyro",), ("gnss", "gyro", "log")])
def test_a_start_from_late_readings_is_carried_to_the_present(late: tuple[str, ...]) -> None:
    """A ship at 1 m/s that is at x = t; the readings of the late sensors are 0.4 s old."""
    sensors = [replace(sensor, delay=0.4 * (sensor.name in late)) for sensor in SENSORS]
    one, age = estimator(*sensors), 0.4 * ("gnss" in late)
    for t in (5.0, 5.2, 5.4):
        now = one.update(t, gnss=(t - age, 0.4), gyro=0.0, log=1.0, rudder=0.0)
    assert now.ready
    assert (now.t, now["x"]) == (5.4, pytest.approx(5.4, abs=0.01))


def test_fixes_before_the_start_are_carried_by_the_current() -> None:
    """Three fixes 10 s apart, at 1 m/s through water that flows at 0.3 m/s."""
    flowing = replace(nw.straight_waterway(nw.Canal(7.0), 100.0), current=0.3)
    one = estimator(Gnss(0.02, period=10.0), Gyro(period=10.0), Log(0.01, period=10.0), waterway=flowing)
    for t in (0.0, 10.0, 20.0):
        now = one.update(t, gnss=(1.3 * t, 0.4), gyro=0.0, log=1.0, rudder=0.0)
    assert now["x"] == pytest.approx(26.0, abs=0.1)


def test_a_turn_more_is_the_same_heading() -> None:
    table = beginning()
    turned = {**table, "gyro": table["gyro"] + 2 * math.pi}
    one, other = estimator().run(table), estimator().run(turned)
    np.testing.assert_allclose(one.mean, other.mean, atol=1e-9)


def test_records_are_the_readings_one_by_one() -> None:
    table, truth = beginning(), record()[1][:30]
    track, one = estimator().run(table), estimator()
    for number, t in enumerate(table["t"].tolist()):
        told = {name: float(table[name][number]) for name in ("gyro", "rate_of_turn", "log", "rudder")}
        estimate = one.update(t, {**told, "gnss": (table["gnss_x"][number], table["gnss_y"][number])})
    np.testing.assert_allclose(track.mean[-1], list(estimate.values.values()), rtol=1e-9)
    assert np.abs(track["y"] - truth[2:, 1]).max() < 0.1


def test_the_smoother_knows_more_than_the_filter() -> None:
    table, truth = record()
    forward, back = estimator().run(table), estimator().smooth(table)
    middle = slice(20, 80)
    assert (back.std[middle, :6] < 1.01 * forward.std[middle, :6]).all()
    assert (back.std[middle, :6] < 0.9 * forward.std[middle, :6]).mean() > 0.5
    off = [np.sqrt(np.mean((track.mean - truth[2:])[middle, :3] ** 2, axis=0)) for track in (forward, back)]
    assert (off[1] < off[0]).sum() >= 2
    # At the end both know the same of the readings, if not of the coefficients.
    certain = estimator(coefficients="certain", refusing=0.0)
    same = replace(certain.filter.model, covariance=None)
    plain = Estimator(same, [*SENSORS, RudderIndicator()], refusing=0.0)
    np.testing.assert_allclose(plain.smooth(table).mean[-1], plain.run(table).mean[-1], rtol=1e-6, atol=1e-8)


def test_a_position_is_held_until_the_next_is_told() -> None:
    """Every other indication of the rudder, none in the first second: at rest until then."""
    table = {name: column[:40] for name, column in record()[0].items()}
    told, held = np.where(np.arange(40) % 2 == 0, table["rudder"], np.nan), np.repeat(table["rudder"][::2], 2)
    told[:6], held[:6] = np.nan, 0.0
    found = [estimator().smooth({**table, "rudder": rudder}).mean for rudder in (told, held)]
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9, atol=1e-12)


def test_a_table_goes_in_as_frame_or_dataset() -> None:
    import pandas as pd

    table = beginning()
    frame = pd.DataFrame(table)
    dataset = xr.Dataset({name: ("t", column) for name, column in table.items() if name != "t"}, {"t": table["t"]})
    plain = estimator().run(table).mean
    np.testing.assert_array_equal(estimator().run(frame).mean, plain)
    np.testing.assert_array_equal(estimator().run(frame.set_index("t")).mean, plain)
    np.testing.assert_array_equal(estimator().run(dataset).mean, plain)


def begin(*sensors: Any, **options: Any) -> Estimator:
    return started(estimator(*sensors, **options))


def started(one: Estimator, t: float = 0.0, x: float = 0.0, y: float = 0.4, psi: float = 0.0) -> Estimator:
    """After three readings of each sensor, of a ship at 1 m/s, the last of them at a time."""
    for ago in (0.4, 0.2, 0.0):
        fix = x - ago * math.cos(psi), y - ago * math.sin(psi)
        one.update(t - ago, gnss=fix, gyro=psi, log=1.0, rudder=0.0)
    return one


def test_there_is_nothing_before_a_place_a_heading_and_a_speed() -> None:
    one = estimator()
    waiting = one.update(0.0, gyro=0.1, rudder=0.0)
    assert waiting.values == {}
    assert not waiting.ready
    assert waiting.notes == (
        "An estimate starts from 3 readings each; it lacks a place and a heading and a speed through the water.",
    )
    assert [one.update(0.2 * k, gnss=(0.0, 0.4), log=1.0, gyro=0.1).ready for k in (1, 2, 3)] == [False, False, True]


def test_a_start_takes_the_antenna_to_midship() -> None:
    one = estimator(Gnss(0.02, forward=1.0, starboard=0.2), *SENSORS[1:])
    start = started(one, x=5.0, psi=0.1).update(0.0)
    assert start["x"] == pytest.approx(5.0 - math.cos(0.1) + 0.2 * math.sin(0.1))
    assert start["y"] == pytest.approx(0.4 - math.sin(0.1) - 0.2 * math.cos(0.1))
    # An error of the heading turns midship about the antenna.
    covariance = start.covariance / Gyro().noise ** 2
    ahead, side = math.cos(0.1) - 0.2 * math.sin(0.1), math.sin(0.1) + 0.2 * math.cos(0.1)
    assert (covariance[0, 2], covariance[1, 2]) == pytest.approx((side, -ahead), rel=1e-5)


def test_the_bias_of_a_compass_is_found_by_course_and_speed() -> None:
    """With the gyro 1 degree off, and the course over ground beside the model's drift to tell."""
    sensors = (SENSORS[0], Gyro(bias=math.radians(1.0), period=0.2), *SENSORS[2:], CourseOverGround(0.01, period=0.2))
    table, _ = record(8, *SENSORS, CourseOverGround(0.01, period=0.2))
    off = {**table, "gyro": table["gyro"] + math.radians(1.0)}
    track = estimator(*sensors).run(off)
    found, std = track["gyro_bias"][-1], track.std[-1, track.states.index("gyro_bias")]
    assert abs(found - math.radians(1.0)) < 3 * std
    assert std < math.radians(0.5)


def test_a_jump_is_refused_and_said() -> None:
    one = begin()
    one.update(0.2, gnss=(0.2, 0.4), rudder=0.0)
    jumped = one.update(0.4, gnss=(0.4, 1.4))
    assert jumped.refused == ("gnss",)
    assert "The reading of gnss is too far from the prediction: refused." in jumped.notes
    assert abs(jumped["y"] - 0.4) < 0.05
    free = begin(refusing=0.0)
    free.update(0.2, gnss=(0.2, 0.4), rudder=0.0)
    assert free.update(0.4, gnss=(0.4, 1.4))["y"] > 0.5


def test_sensors_that_agree_against_the_model_are_believed() -> None:
    """Compass and rate gyro tell of the same turn, which no rudder made; garbage in both at once is refused."""
    one = begin()
    turned = one.update(0.2, gyro=0.05, rate_of_turn=0.25, rudder=0.0)
    assert turned.refused == ()
    assert "The readings of gyro and rate_of_turn contradict the prediction: the model is wrong." in turned.notes
    assert turned["psi"] > 0.02
    odd = begin().update(0.2, gyro=3.0, rate_of_turn=-40.0, rudder=0.0)
    assert odd.refused == ("gyro", "rate_of_turn")
    spoofed = begin(*SENSORS, CourseOverGround(0.01, period=0.2)).update(0.2, gnss=(0.2, 1.4), course=(0.8, 1.0))
    assert spoofed.refused == ("gnss", "course")


def test_an_estimate_in_the_bank_begins_anew() -> None:
    one = begin()
    for number in range(1, 300):
        now = one.update(0.2 * number, rudder=0.4)
        if not now.ready:
            break
    assert not now.ready
    assert any("lay in a bank or beyond the waterway: it begins anew." in note for note in now.notes)
    assert all(map(math.isfinite, now.values.values()))
    again = started(one, 0.2 * number + 1.0, 9.0, 0.1).update(0.2 * number + 1.0)
    assert again.ready
    assert again["y"] == pytest.approx(0.1)


def test_a_reading_of_none_is_one_that_did_not_come() -> None:
    one, other = begin(), begin()
    empty = one.update(0.2, gyro=None, gnss=(None, 0.4), log=1.0)
    assert empty.values == other.update(0.2, gyro=math.nan, gnss=(math.nan, 0.4), log=1.0).values
    assert empty.notes[0] == "The reading of gyro and gnss is not a number and was not used."


def test_a_start_is_the_median_of_three_readings() -> None:
    """One reading of each is wrong: the log at 0, a fix 40 m off, a heading half a turn off."""
    one = estimator()
    one.update(-0.4, gnss=(-0.4, 40.4), gyro=0.0, log=1.0)
    one.update(-0.2, gnss=(-0.2, 0.4), gyro=0.0, log=0.0)
    start = one.update(0.0, gnss=(0.0, 0.4), gyro=math.pi, log=1.0)
    assert start.ready
    assert [start[name] for name in ("x", "y", "psi", "u")] == pytest.approx([0.0, 0.4, 0.0, 1.0], abs=1e-9)


def test_time_that_goes_back_is_said_and_changes_nothing_else() -> None:
    one = begin()
    now = one.update(1.0, gnss=(1.0, 0.4), rudder=0.0)
    back = one.update(0.5, gnss=(0.5, 0.4))
    assert any(note.startswith("The time went back from 1 to 0.5 s") for note in back.notes)
    assert any("before anything that is kept: not used" in note for note in back.notes)
    assert back.values == now.values


def test_silence_is_told() -> None:
    one = begin()
    assert not any("No reading" in note for note in one.update(0.2, gyro=0.0).notes)
    assert "No reading of gnss came for 4 s." in one.update(4.0, gyro=0.0).notes
    assert any("begins anew" in note for note in one.update(4000.0, gyro=0.0).notes)


def test_a_clock_that_strays_far_blocks_nothing() -> None:
    """Once far ahead and back again: both are said, and the estimate begins anew with what comes next."""
    one = begin()
    assert any("begins anew" in note for note in one.update(1e9, gnss=(0.0, 0.4), gyro=0.0, log=1.0).notes)
    started(one, 1e9 + 1.0)
    assert any(note.startswith("The time went back by") for note in one.update(0.5, gyro=0.0).notes)
    back = started(one, 1.0, 1.0, 0.3).update(1.0)
    assert back.ready
    assert back["y"] == pytest.approx(0.3)


def test_what_was_told_long_ago_starts_nothing() -> None:
    one = estimator()
    one.update(0.0, gyro=0.1, log=1.0)
    later = one.update(30.0, gnss=(0.0, 0.4))
    assert not later.ready
    assert any("a heading and a speed through the water" in note for note in later.notes)


NUMBER = st.floats(allow_nan=True, allow_infinity=True, width=32)
READING = st.fixed_dictionaries(
    {},
    optional={
        "gnss": st.tuples(NUMBER, NUMBER),
        "gyro": NUMBER,
        "log": NUMBER,
        "rate_of_turn": NUMBER,
        "rudder": NUMBER,
    },
)


EVENTS = st.lists(st.tuples(st.floats(-20.0, 20.0) | st.sampled_from([1e3, -1e12, 1e12]), READING), max_size=12)


@given(EVENTS, st.sampled_from([0.0, 1e-5]))
@settings(max_examples=draws(15))
def test_whatever_comes_in_finite_numbers_come_out(events: list[tuple[float, dict[str, Any]]], refusing: float) -> None:
    one = begin(refusing=refusing)
    for t, readings in events:
        now = one.update(t, readings)
        assert all(map(math.isfinite, now.values.values()))
        assert np.isfinite(now.covariance).all()
        assert (np.linalg.eigvalsh(now.covariance) > -1e-9 * np.trace(now.covariance)).all()
        assert np.isfinite(list(now.nis.values())).all()


REFUSED = {
    "unknown sensor": lambda: begin().update(1.0, gyroo=0.0),
    "too many numbers": lambda: begin().update(1.0, gyro=(0.0, 1.0)),
    "words": lambda: begin().update(1.0, gyro="north"),
    "no time": lambda: begin().update(math.nan),
    "no sensor": lambda: Estimator(steered(), [RudderIndicator()]),
    "not a list": lambda: Estimator(steered(), Gnss()),
    "a class": lambda: Estimator(steered(), [Gnss]),
    "two of one name": lambda: estimator(Gnss(), Gnss()),
    "two rudders": lambda: estimator(*SENSORS, RudderIndicator()),
    "no probability": lambda: estimator(refusing=2.0),
    "no memory": lambda: estimator(memory=math.nan),
    "no such way": lambda: estimator(coefficients="guessed"),
    "noise": lambda: Gnss(noise=0.0),
    "negative bias": lambda: Gyro(bias=-0.1),
    "no correlation time": lambda: GaussMarkov(1.0, 0.0),
    "no size of an error": lambda: GaussMarkov((1.0, math.nan)),
    "early": lambda: Log(delay=-1.0),
    "no place": lambda: CourseOverGround(forward=math.nan),
    "process noise": lambda: ProcessNoise(sway=-1.0),
    "prior": lambda: Prior(bank=math.inf),
    "no time in records": lambda: estimator().run({"gyro": np.zeros(3)}),
    "unknown column": lambda: estimator().run({"t": np.arange(3.0), "gyo": np.zeros(3)}),
    "times that fall": lambda: estimator().run({"t": np.array([0.0, 2.0, 1.0]), "gyro": np.zeros(3)}),
    "columns of two lengths": lambda: estimator().run({"t": np.arange(3.0), "gyro": np.zeros(2)}),
    "never enough": lambda: estimator().run({"t": np.arange(3.0), "gyro": np.zeros(3)}),
    "never enough to smooth": lambda: estimator().smooth({"t": np.arange(3.0), "gyro": np.zeros(3)}),
    "no table": lambda: estimator().run(3.0),
}


@pytest.mark.parametrize("call", REFUSED.values(), ids=REFUSED)
def test_what_is_wrong_is_refused_in_one_sentence(call: Any) -> None:
    with pytest.raises(nw.InputError) as caught:
        call()
    assert "\n" not in str(caught.value)


OTHERS: dict[str, dict[str, Any]] = {
    "waterway": {"waterway": nw.straight_waterway(nw.Canal(3.0), 500.0)}, "noise": {"noise": ProcessNoise(sway=0.01)},
    "prior": {"prior": Prior(bank=0.6)}, "coefficients": {"coefficients": "certain"}, "refusing": {"refusing": 0.5},
    "memory": {"memory": 20.0},
}  # fmt: skip


def test_every_option_changes_the_estimate() -> None:
    table, _ = record()
    found = {name: estimator(**told).run(table).covariance[-1, :6, :6].tobytes() for name, told in OTHERS.items()}
    found["usual"] = estimator().run(table).covariance[-1, :6, :6].tobytes()
    assert len(set(found.values())) == len(found)


SENSED: dict[str, Any] = {
    "noise of the fix": (Gnss(0.03, period=0.2), *SENSORS[1:]),
    "forward": (Gnss(0.02, forward=1.0, period=0.2), *SENSORS[1:]),
    "starboard": (Gnss(0.02, starboard=0.3, period=0.2), *SENSORS[1:]), "late": (Gnss(0.02, delay=0.2), *SENSORS[1:]),
    "noise of the gyro": (SENSORS[0], Gyro(0.01), *SENSORS[2:]),
    "its bias": (SENSORS[0], Gyro(bias=0.01), *SENSORS[2:]),
    "white fixes": (Gnss(0.02, period=0.2, coloured=None), *SENSORS[1:]),
    "slow errors": (Gnss(0.02, period=0.2, coloured=GaussMarkov(0.05, 5.0)), *SENSORS[1:]),
    "their time": (Gnss(0.02, period=0.2, coloured=GaussMarkov(0.05, 9.0)), *SENSORS[1:]),
    "noise of the rate": (*SENSORS[:2], RateOfTurn(0.01), SENSORS[3]), "noise of the log": (*SENSORS[:3], Log(0.1)),
}  # fmt: skip


def test_every_number_of_a_sensor_changes_the_estimate() -> None:
    table = {name: column[:40] for name, column in record()[0].items()}
    found = {name: estimator(*sensors).run(table).mean[-1, :6].tobytes() for name, sensors in SENSED.items()}
    found["usual"] = estimator().run(table).mean[-1, :6].tobytes()
    for indicator in (RudderIndicator(0.02), RudderIndicator(bias=0.05)):
        found[repr(indicator)] = Estimator(steered(), [*SENSORS, indicator]).run(table).mean[-1, :6].tobytes()
    assert len(set(found.values())) == len(found)


def test_white_innovations_seldom_lean_and_a_drift_soon_does() -> None:
    random, sums, statistics = (
        np.random.default_rng(1),
        np.zeros((2, 3, 2)),
        compiled_loops(square_roots).drift_statistics,
    )

    def lean(innovation: np.ndarray) -> np.ndarray:
        return np.asarray(statistics(sums, MEMORIES, np.arange(2), innovation, 5.0))

    leans = np.array([lean(random.standard_normal(2)) for _ in range(36_000)])
    assert (leans < 5.0).all()
    assert 1.0 < leans.mean() < 1.4
    drift = np.array([0.0, 1.5])
    found = next(n for n in range(100) if lean(random.standard_normal(2) + drift).max() > 5.0)
    assert found < 25


def test_results_speak_of_units_and_go_into_files(tmp_path: Any) -> None:
    table, _ = record()
    track = estimator().smooth(table)
    data = track.dataset()
    assert data["y"].attrs["units"] == "m"
    assert data["psi_std"].attrs["units"] == "rad"
    track.save(tmp_path / "a.nc")
    track.save(tmp_path / "a.csv")
    with xr.open_dataset(tmp_path / "a.nc", engine="scipy") as again:
        np.testing.assert_array_equal(again["y"], data["y"])
    assert "known to" in track.summary()
    assert len(track.to_dataframe()) == len(track.t)
