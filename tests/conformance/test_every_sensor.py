"""Every sensor of ``SENSORS``: readings and numbers go both ways, what it expects is what it reads, and it informs."""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.estimation import Estimator, GaussMarkov, Gnss, Gyro, Log, RateOfTurn, RudderIndicator, Sensor, sensors
from narrows.estimation.consistency import Twins, sail_twins
from narrows.estimation.sensors import SENSORS
from narrows.estimation.states import STATES, Columns, StateNames

every_sensor = pytest.mark.parametrize("make", SENSORS.values(), ids=list(SENSORS))
OTHERS = (Gnss(0.05, period=0.2), Gyro(0.01, period=0.2), RateOfTurn(0.005, period=0.2), Log(0.02, period=0.2))
SIZES = {"x": 5.0, "y": 0.5, "psi": 0.1, "u": 1.0, "v": 0.05, "r": 0.02, "bank": 1.0}


def states(count: int) -> np.ndarray:
    draw = np.random.default_rng(2).uniform(0.5, 1.5, (count, len(STATES)))
    return draw * [SIZES.get(name, 0.05) for name in STATES]


def columns(points: np.ndarray) -> Columns:
    return Columns(points, StateNames(tuple(STATES)))


def measured(sensor: Sensor, points: np.ndarray) -> np.ndarray:
    """Its numbers, a row a state."""
    return np.stack([np.broadcast_to(one, len(points)) for one in sensor.measured(columns(points))], axis=1)


def test_no_sensor_is_forgotten() -> None:
    own = {one for one in vars(sensors).values() if isinstance(one, type) and issubclass(one, Sensor)}
    assert own - {Sensor, sensors.Antenna} == {*SENSORS.values()}, "give it a name, and name it in __all__"


def test_a_state_that_no_ship_has_is_refused() -> None:
    own = type("Sway", (Gyro,), {"state": "sway"})
    with pytest.raises(nw.InputError, match=r"sensor tested reads an unknown state 'sway'; known: .*psi, r, "):
        estimator(own(0.1, name="tested"))
    error = type("Heeling", (Gyro,), {"state": "other_bias"})  # An error that another sensor declares is a state too
    assert estimator(Gyro(0.1, name="other", bias=0.1), error(0.1, name="tested"))


@every_sensor
def test_it_is_a_sensor(make: type[Sensor]) -> None:
    sensor = make()
    assert isinstance(sensor, Sensor)
    assert len(sensor.fields) == len(sensor.sigma) == len(sensor.angles) == measured(sensor, states(1)).shape[1]
    assert len(set(sensor.fields)) == len(sensor.fields)
    assert all(field.startswith("mine") for field in make(name="mine").fields)


@every_sensor
def test_a_reading_is_its_numbers_backwards(make: type[Sensor]) -> None:
    for numbers in measured(make(), states(20)):
        reading = make().reading(tuple(numbers))
        np.testing.assert_allclose(make().numbers([float(one) for one in reading]), numbers, rtol=1e-12)


@every_sensor
def test_states_are_measured_alike_one_by_one_and_together(make: type[Sensor]) -> None:
    together = measured(make(), states(20))
    alone = [measured(make(), state[None, :])[0] for state in states(20)]
    np.testing.assert_array_equal(together, alone)
    assert np.ptp(together, axis=0).all(), "it measures what no state changes"


@every_sensor
def test_what_is_said_to_be_linear_is(make: type[Sensor]) -> None:
    sensor, (one, other) = make(), states(2)
    if sensor.is_linear:
        both = measured(sensor, np.stack([0.3 * one + 0.7 * other, one, other]))
        np.testing.assert_allclose(both[0], 0.3 * both[1] + 0.7 * both[2], rtol=1e-12)


@every_sensor
def test_a_start_is_the_state_that_was_measured(make: type[Sensor]) -> None:
    sensor, state = make(), states(1)
    reading = [float(one) for one in sensor.reading(tuple(measured(sensor, state)[0]))]
    for name, (value, sigma) in sensor.start(reading).items():
        assert value == pytest.approx(state[0, list(STATES).index(name)], rel=1e-9)
        assert sigma > 0


@cache
def ship() -> nw.Model:
    """A ship beside weak banks, for which the coefficients are certain."""
    return steered().with_coefficients(b_bank=0.05, c_bank=0.02)


def estimator(*sensors: Sensor) -> Estimator:
    return Estimator(ship(), [*OTHERS, *sensors, RudderIndicator()])


def accurate(make: type[Sensor], **told: Any) -> Sensor:
    """As good as a ship of 4 m needs it."""
    return make(0.02 * make().noise, name="tested", period=0.2, **told)


def sailed(filter: Estimator, duration: float = 12.0) -> tuple[dict[str, np.ndarray], Twins]:
    """What a twin's sensors read, as a table of records, and the twin."""
    pilot = nw.control.regulator(ship(), 0.4, 1.0)
    twins = sail_twins(filter.filter, pilot, (0.0, 0.4, 1.0, pilot.lines[0].psi), 1, duration, False, 0.05, 4)
    table = {"t": twins.t, "rudder": twins.indicated[:, 0, 0]}
    for name, sensor in filter.filter.sensors.items():
        table |= {field: twins.readings[name][:, 0, k] for k, field in enumerate(sensor.fields)}
    return table, twins


@every_sensor
def test_what_a_twin_reads_is_what_the_filter_expects(make: type[Sensor]) -> None:
    """No sound reading is refused, the truth stays within the estimate's errors, and the sensor makes them less."""
    own = estimator(accurate(make))
    table, twins = sailed(own)
    others = {name: told for name, told in table.items() if name not in accurate(make).fields}
    track, without = own.run(table), estimator().run(others)
    assert not any("refused" in note for note in track.notes), track.notes
    truth, late = twins.states[-len(track.t) :, 0], slice(len(twins.t) // 2, None)
    off = (np.stack([track[name] for name in track.states], axis=1) - truth) / track.std
    assert np.sqrt((off[late] ** 2).mean(axis=0)).max() < 3.5
    assert (track.std[-1, : len(without.states)] < 0.95 * without.std[-1]).any()


@every_sensor
def test_a_late_reading_is_of_the_time_when_it_was_measured(make: type[Sensor]) -> None:
    sensor = accurate(make, delay=0.6)
    table, twins = sailed(estimator(sensor), 3.0)
    own = np.stack([table[field] for field in sensor.fields], axis=1)
    assert np.isnan(own[twins.t < 0.6 - 1e-9]).all()
    names = StateNames(tuple(estimator(sensor).filter.states.names))
    then = Columns(twins.states[: len(own) - 3, 0], names)
    expected = np.stack([np.asarray(one) for one in sensor.measured(then)], axis=1)
    numbers = np.array([sensor.numbers(row) for row in own[3:].tolist()])
    np.testing.assert_array_less(abs(numbers - expected), 9 * sensor.noise)


@every_sensor
def test_its_errors_become_states_that_are_as_large_as_declared(make: type[Sensor]) -> None:
    """A bias and a slow error, ten times the noise: each a state at its spread, and readings of twins have them."""
    size = 0.2 * make().noise
    sensor = accurate(make, bias=size, coloured=GaussMarkov(size, 30.0))
    own = estimator(sensor)
    names = [f"{field}_{kind}" for field in sensor.fields for kind in ("bias", "wander")]
    assert set(names) <= set(own.filter.states.names)
    pilot = nw.control.regulator(ship(), 0.4, 1.0)
    twins = sail_twins(own.filter, pilot, (0.0, 0.4, 1.0, pilot.lines[0].psi), 200, 0.2, False, 0.0, 4)
    for name in names:
        drawn = twins.states[0, :, own.filter.states.places[name]]
        assert drawn.std() == pytest.approx(size, rel=0.2)
    at = Columns(twins.states[0], own.filter.states)
    numbers = np.array([sensor.numbers(row) for row in twins.readings["tested"][0].tolist()])
    off = numbers - np.stack([np.asarray(one) for one in sensor.measured(at)], axis=1)
    assert off.std() == pytest.approx(math.sqrt(2.0 * size**2 + sensor.noise**2), rel=0.15)


@every_sensor
@pytest.mark.parametrize("told", [{"noise": 0.0}, {"noise": np.nan}, {"period": 0.0}, {"delay": -1.0}, {"noise": "1"}])
def test_numbers_that_are_none_are_refused(make: type[Sensor], told: dict[str, float]) -> None:
    with pytest.raises(nw.InputError):
        replace(make(), **told)
