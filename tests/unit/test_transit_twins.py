"""Twins of transits: gusts, pilots and records by formulas and by moments; plans of legs by an exhaustive choice."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.logbook.steady_legs import usual_offsets, usual_speeds
from narrows.logbook.steady_readings import left_over, shared_errors, steady_push
from narrows.logbook.transits import (
    TransitConditions,
    TransitPilot,
    TransitTwin,
    gust_push,
    recorded,
    wandering,
)
from twins import CURRENT, drawn_truth

DEGREE, KNOT = math.pi / 180, 1852 / 3600
DENSITY = 1.225  # of air [kg/m3]


@pytest.fixture(scope="module")
def ship() -> nw.Model:
    return steered()


def test_a_wander_is_stationary_with_its_size_and_memory() -> None:
    """From the first value on: standard deviation 3, correlation exp(-2 / 5) from step to step of 2 s."""
    walks = wandering(3.0, 5.0, 2.0, 4, np.random.default_rng(0), 100_000)
    np.testing.assert_allclose(walks.std(axis=1), 3.0, rtol=0.01)
    correlation = np.corrcoef(walks)
    expected = np.exp(-0.4 * np.abs(np.subtract.outer(np.arange(4), np.arange(4))))
    np.testing.assert_allclose(correlation, expected, atol=0.01)
    np.testing.assert_allclose(walks.mean(axis=1), 0.0, atol=0.05)


def test_gusts_of_force_and_moment_are_correlated_as_stated(ship: nw.Model) -> None:
    conditions = TransitConditions(wind=6.0, gust=0.4, gust_correlation=0.6)
    push, (force, moment) = gust_push(conditions, ship), steady_push(conditions, ship)
    expected = 0.16 * np.array([[force**2, 0.6 * force * moment], [0.6 * force * moment, moment**2]])
    np.testing.assert_allclose(push @ push.T, expected)
    with pytest.raises(nw.InputError, match="a correlation is 1 at most"):
        TransitConditions(gust_correlation=1.1)
    assert TransitConditions(gust_correlation=1.0).gust_correlation == 1.0


def test_a_beam_wind_pushes_a_tenth_of_a_length_off_midship(ship: nw.Model) -> None:
    """Usual windage a tenth of the squared length; the force as the square of the wind and as the area."""
    length = ship.configuration.ship.length
    force, moment = steady_push(TransitConditions(wind=8.0), ship)
    assert moment == pytest.approx(0.1 * length * force)
    assert steady_push(TransitConditions(wind=4.0), ship)[0] == pytest.approx(force / 4)
    own = steady_push(TransitConditions(wind=8.0, windage=0.2 * length**2, wind_lever=0.5), ship)
    np.testing.assert_allclose(own, [2 * force, force])
    assert 0.3 < force / (0.5 * DENSITY * 64.0 * 0.1 * length**2) < 1.5  # a drag coefficient of a hull abeam


def test_errors_of_all_legs_and_of_each_are_those_stated(ship: nw.Model) -> None:
    conditions = nw.SteadyConditions(
        wind=5.0, wind_change=0.3, rudder_zero_deg=2.0, drift_zero_deg=0.5, y_zero=0.07, yaw_rate_deg=0.01,
        yaw_change_deg=0.04, sway_change=0.06, leg_time=30.0,
    )  # fmt: skip
    push = steady_push(conditions, ship)
    np.testing.assert_allclose(shared_errors(conditions, ship), [*push, 2 * DEGREE, 0.5 * DEGREE, 0.07])
    np.testing.assert_allclose(
        left_over(conditions, ship), [*(0.3 * push), 0.01 * DEGREE, 0.06 / 30.0, 0.04 * DEGREE / 30.0]
    )
    usual = shared_errors(nw.SteadyConditions(), ship)
    np.testing.assert_allclose(usual[2:], [DEGREE, DEGREE, ship.configuration.ship.beam / 30])


def voyage(duration: float = 400.0) -> SimpleNamespace:
    """A ship that turns: u = 4, v = 0.3, its heading a tenth of a radian each 20 s."""
    t = np.arange(0.0, duration + 0.5, 0.5)
    values = {"t": t, "x": 4.0 * t, "y": 2.0 + 0.1 * t, "psi": 0.005 * t, "r": np.full(len(t), 0.005)}
    values |= {"u": np.full(len(t), 4.0), "v": np.full(len(t), 0.3), "rudder": 0.001 * t}

    class Known(SimpleNamespace):
        def __getitem__(self, name: str) -> np.ndarray:
            return getattr(self, name)

    return Known(**values)


SIGNALS = ("x", "y", "psi", "r", "u", "v", "rudder", "u_ground", "v_ground", "speed_over_ground")


def exact(noise: float = 1e-9, **errors: float) -> nw.SensorGrade:
    return nw.SensorGrade("own", "", dict.fromkeys(SIGNALS, nw.SignalGrade(noise, **errors)))


def test_a_record_without_errors_is_the_voyage_in_a_current() -> None:
    """The current is along the canal: the place over ground drifts by it, velocities by its parts along and across."""
    sailed, told = voyage(), recorded("A", voyage(), exact(period=2.0), 5, CURRENT)
    t = told["x"].t
    np.testing.assert_allclose(t, np.arange(0.0, 400.0, 2.0))
    drift = (told["x"].values[1:] - 4.0 * t[1:]) / t[1:]
    assert 0.01 < abs(drift[0]) < 1.2
    np.testing.assert_allclose(drift, drift[0], atol=1e-6)
    ahead, aside = 4.0 + drift[0] * np.cos(0.005 * t), 0.3 - drift[0] * np.sin(0.005 * t)
    np.testing.assert_allclose(told["u_ground"].values, ahead, atol=1e-4)
    np.testing.assert_allclose(told["v_ground"].values, aside, atol=1e-4)
    np.testing.assert_allclose(told["speed_over_ground"].values, np.hypot(ahead, aside), atol=1e-4)
    for name in ("y", "psi", "r", "u", "v", "rudder"):
        np.testing.assert_allclose(told[name].values, np.interp(t, sailed.t, sailed[name]), atol=1e-6)
    still = recorded("A", voyage(), exact(), 5, current=0.0)
    np.testing.assert_allclose(still["x"].values, 4.0 * still["x"].t, atol=1e-6)


def test_currents_zeros_noise_and_wander_have_their_standard_deviations() -> None:
    """Over 300 records: 0.3 m/s of current; a zero of 2 in each; noise of 0.5 from value to value; a wander of 1."""

    def off(grade: nw.SensorGrade, current: float) -> np.ndarray:
        told = (recorded("A", voyage(40.0), grade, seed, current) for seed in range(300))
        return np.array([one["x"].values - 4.0 * one["x"].t for one in told])

    drifts = off(exact(), 0.3)[:, -1] / 39.0
    assert drifts.std() == pytest.approx(0.3, rel=0.1)
    zeros = off(exact(zero=2.0), 0.0)
    assert zeros[:, 0].std() == pytest.approx(2.0, rel=0.1)
    np.testing.assert_allclose(np.diff(zeros), 0.0, atol=1e-6)
    noise = off(exact(0.5), 0.0)
    assert noise.std() == pytest.approx(0.5, rel=0.03)
    assert np.corrcoef(noise[:, :-1].ravel(), noise[:, 1:].ravel())[0, 1] == pytest.approx(0.0, abs=0.05)
    wander = off(exact(wander=1.0, memory=20.0), 0.0)
    assert wander.std() == pytest.approx(1.0, rel=0.15)
    assert np.corrcoef(wander[:, 0], wander[:, 5])[0, 1] == pytest.approx(math.exp(-5 / 20), abs=0.1)


def test_pushes_of_a_transit_are_a_wind_for_all_of_it_and_gusts(ship: nw.Model) -> None:
    conditions = TransitConditions(wind=6.0, gust=0.5, gust_time=4.0, gust_correlation=0.0)
    twin, (force, moment) = TransitTwin(ship, 0.7, 40.0, conditions), steady_push(conditions, ship)
    drawn = [twin._pushes(np.random.default_rng(seed)) for seed in range(400)]
    times = np.array(drawn[0]["Y"])[:, 0]
    np.testing.assert_allclose(np.diff(times), 0.8)  # a fifth of the time of a gust
    for name, size in (("Y", force), ("N", moment)):
        values = np.array([[value for _, value in one[name]] for one in drawn]) / size
        assert values.std() == pytest.approx(math.sqrt(1.25), rel=0.06)
        gusts = values - values.mean(axis=1, keepdims=True)
        assert 0.3 < gusts.std() < 0.5
    both = np.array([[one[name][0][1] for name in "YN"] for one in drawn])
    assert np.corrcoef(both.T)[0, 1] == pytest.approx(0.0, abs=0.15)


def test_a_truth_is_drawn_from_the_covariance_within_bounds(ship: nw.Model) -> None:
    names = ship.terms.names
    sizes = np.array([0.2 * abs(ship[name]) if name in ("b_uv", "c_r", "c_bank") else 0.0 for name in names])
    mixed = np.where(np.eye(len(names)), 1.0, 0.5)
    model = replace(ship, covariance=mixed * np.outer(sizes, sizes))
    drawn = [drawn_truth(model, seed, b_bank=7.0) for seed in range(300)]
    moved = [name for name, size in zip(names, sizes, strict=True) if size]
    assert len(moved) >= 2
    values = np.array([[(one[name] - ship[name]) / (0.2 * abs(ship[name])) for name in moved] for one in drawn])
    np.testing.assert_allclose(values.std(axis=0), 1.0, rtol=0.15)
    assert np.corrcoef(values[:, :2].T)[0, 1] == pytest.approx(0.5, abs=0.15)
    assert {one["b_bank"] for one in drawn} == {7.0}
    term = ship.terms["c_bank"]
    if math.isfinite(term.bound[0]):
        wide = replace(model, covariance=25 * np.asarray(model.covariance))
        assert min(drawn_truth(wide, seed)["c_bank"] for seed in range(30)) >= term.bound[0]


def pilot(ship: nw.Model, waterway: object = None, aim: float = 3.0) -> TransitPilot:
    one = TransitPilot(ship, 0.5, np.array([0.0, 100.0]), np.full(2, aim), waterway)
    y = np.array([-10.0, 10.0])
    line = SimpleNamespace(gains=(0.01, 0.5, 0.2, 2.0, 0.3, 0.001), turning=(1.0, 2.0, 3.0))
    one.__dict__["courses"] = np.stack([y, 0.01 * y, 0.002 * y, -0.001 * y])
    one.__dict__["law"] = SimpleNamespace(lines=[line], lead=6.0)
    return one


def state(**changed: float) -> SimpleNamespace:
    return SimpleNamespace(
        **{"x": 50.0, "y": 4.0, "psi": 0.05, "v": 0.02, "r": 0.01, "rudder": 0.1, "u": 0.5, **changed}
    )


def test_a_pilot_orders_what_a_regulator_gives_in_whole_degrees(ship: nw.Model) -> None:
    """At 3 m the steady rudder is 0.03, the heading 0.006, the sway -0.003; from a second order on the time counts."""
    order, interval = pilot(ship).begin(), min(4.0, ship.configuration.ship.length / 0.5 / 20)
    assert order(0.0, state()) == pytest.approx(round(0.1 / DEGREE) * DEGREE)
    assert order(interval / 2, state(rudder=0.4)) == pytest.approx(round(0.1 / DEGREE) * DEGREE)
    rate = 0.01 * 1.0 + 0.5 * 0.044 + 0.2 * 0.023 + 2.0 * 0.01 + 0.3 * 0.07
    asked = 0.1 - interval * rate / (1 + interval * 0.3)
    assert order(interval, state()) == pytest.approx(round(asked / DEGREE) * DEGREE)
    for turn in range(2, 40):
        last = order(turn * interval, state())
    summed = 38 * interval * 1.0  # metres off for seconds, by the order before
    assert last == pytest.approx(0.1 - interval * (rate + 0.001 * summed) / (1 + interval * 0.3), abs=0.51 * DEGREE)


def test_the_integral_of_a_pilot_waits_at_the_end_of_the_rudder(ship: nw.Model) -> None:
    order, gear = pilot(ship).begin(), ship.configuration.gear
    for turn in range(20):
        order(5.0 * turn, state(rudder=gear.limit + 5.0, y=8.0))
    free = order(100.0, state())
    again = pilot(ship).begin()
    again(95.0, state(y=3.0))
    assert free == again(100.0, state())


def test_a_pilot_in_a_bend_turns_with_it(ship: nw.Model) -> None:
    """Looking 6 s ahead, at 53 m, in a current of 0.1: a curvature of 0.02 is a turn of 0.012."""
    way = SimpleNamespace(
        line=SimpleNamespace(length=52.0), section=lambda s: SimpleNamespace(curvature=0.02 if s == 52.0 else 9.0),
        current_at=lambda s: 0.1,
    )  # fmt: skip
    aim, rudder, psi, v, turn = pilot(ship, way)._held(10.0, state())
    assert (aim, turn) == (3.0, pytest.approx(0.012))
    assert (rudder, psi, v) == pytest.approx((0.03 + 3 * 0.012, 0.006 + 0.012, -0.003 + 2 * 0.012))
    assert pilot(ship)._held(10.0, state())[1:] == pytest.approx((0.03, 0.006, -0.003, 0.0))


def test_the_course_of_a_pilot_is_tabulated_to_either_side(ship: nw.Model) -> None:
    one = TransitPilot(ship, 0.6, np.array([0.0, 9.0]), np.array([0.2, -0.3]))
    y, rudder, psi, v = one.courses
    np.testing.assert_allclose(y, np.linspace(-0.3, 0.3, 21))
    held = nw.steady_course(ship, y=0.3, u=0.6)
    assert (rudder[-1], psi[-1], v[-1]) == pytest.approx(tuple(float(held[name]) for name in ("rudder", "psi", "v")))


def test_a_pilot_steers_by_the_regulator_of_its_outermost_aim(ship: nw.Model) -> None:
    one = TransitPilot(ship, 0.6, np.array([0.0, 9.0]), np.array([0.2, -0.3]))
    (line,) = one.law.lines
    assert line.y == pytest.approx(0.3)
    assert line.gains == pytest.approx(nw.regulator(ship, 0.3, 0.6).lines[0].gains)


def canal(ship: nw.Model, width: float, speed: tuple[float, float] | None, depth: float | None = None) -> nw.Model:
    own = replace(ship.configuration, canal=nw.Canal(width, depth))
    return replace(ship, configuration=own, data_range=replace(ship.data_range, speed=speed))


def test_usual_offsets_are_in_round_steps_of_about_a_twentieth(ship: nw.Model) -> None:
    """Half of the width less a beam: of 2.93 m steps of 0.1 m. In a canal of two beams there is none."""
    beam = ship.configuration.ship.beam
    for room, step, count in ((2.93, 0.1, 29), (0.85, 0.04, 21)):
        found = usual_offsets(canal(ship, 2 * (room + beam), None))
        np.testing.assert_allclose(found, step * np.arange(1, count + 1))
    with pytest.raises(nw.InputError, match="leaves no offset"):
        usual_offsets(canal(ship, 2 * beam, None))


def test_usual_speeds_are_round_numbers_of_knots_within_the_tests(ship: nw.Model) -> None:
    """Without a depth from half the largest speed of the tests to that, three of them, to the second digit of knots."""
    found = usual_speeds(canal(ship, 7.0, (0.2, 1.0))) / KNOT
    np.testing.assert_allclose(found, [1.0, 1.5, 1.9], atol=1e-9)
    fast = usual_speeds(canal(ship, 7.0, (3.0, 10.0))) / KNOT
    np.testing.assert_allclose(fast, [10.0, 15.0, 19.0], atol=1e-9)
    choke = nw.choke_speed(canal(ship, 7.0, None, 0.5).configuration)
    deep = usual_speeds(canal(ship, 7.0, None, 0.5)) / KNOT
    expected = np.array([0.35, 0.525, 0.7]) * choke / KNOT
    np.testing.assert_allclose(deep, expected, atol=0.0501)
    limited = usual_speeds(canal(ship, 7.0, (0.5 * choke, 0.6 * choke), 0.5))
    assert limited.min() > 0.5 * choke - 0.051 * KNOT
    assert limited.max() < 0.6 * choke + 0.051 * KNOT
    with pytest.raises(nw.InputError, match="give the speeds to look at"):
        usual_speeds(canal(ship, 7.0, None))
