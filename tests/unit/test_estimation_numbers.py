"""Numbers of the estimator against scaling laws and hand computations; no record is filtered here."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2, norm
from test_estimator import SENSORS, estimator, steered

from narrows.codegen.cache import compiled_loops
from narrows.estimation import (
    Consistency,
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
    settings,
    square_roots,
)
from narrows.estimation.consistency import Twins, _positions, _readings
from narrows.estimation.sensors import ErrorProcess, draw_reading, error_states
from narrows.estimation.ship_filter import MEMORIES, sigma_point_weights
from narrows.estimation.states import Estimate, EstimatedTrack, Gaussian, MarkovProcess, StateNames
from pictures import assert_readable


def drift(sums: np.ndarray, innovation: float) -> np.ndarray:
    """The statistic of one number."""
    return compiled_loops(square_roots).drift_statistics(sums, MEMORIES, np.zeros(1, int), np.array([innovation]), 5.0)


def test_sensors_read_once_a_second_and_without_delay_unless_told() -> None:
    for kind in (Gnss, Gyro, RateOfTurn, Log):
        assert (kind(0.1).period, kind(0.1).delay, kind(0.1).bias) == (1.0, 0.0, 0.0)


def test_noises_of_another_ship_follow_froudes_law() -> None:
    """A ship 16 times as long as that of 230 m: velocities 4 times, times 4 times; a walk gathers per root second."""
    usual, large = ProcessNoise().by_state(), ProcessNoise.of_length(16 * 230.0).by_state()
    factors = dict.fromkeys(("u", "v", "current", "current_across"), 2.0)  # velocity over the root of a time
    factors |= dict.fromkeys(("bank", "rudder_bias"), 0.5)
    for name, factor in {**factors, "r": 1 / 8}.items():
        assert large[name] == pytest.approx(factor * usual[name], rel=1e-12)
        assert usual[name] > 0.0
    assert large["x"] == large["y"] == large["psi"] == 0.0


def test_priors_of_another_ship_follow_froudes_law() -> None:
    usual, large = Prior(), Prior.of_length(16 * 230.0)
    assert large.sway == pytest.approx(4 * usual.sway)
    assert large.yaw_rate == pytest.approx(usual.yaw_rate / 4)
    assert (large.current, large.current_across) == pytest.approx((4 * usual.current, 4 * usual.current_across))
    assert large.bank == usual.bank


def test_sigma_points_meet_the_fourth_moment_of_a_gaussian() -> None:
    """Along each axis E[x^2] = 1 and E[x^4] = 3, which root 3 alone does (Julier and Uhlmann, 1997)."""
    weights = sigma_point_weights(5)
    second, fourth = (2 * weights.mean * weights.distance**power for power in (2, 4))
    assert (second, fourth) == pytest.approx((1.0, 3.0))
    # With n = 5, alpha = 1/2 and beta = 2: root(1 + (2 - 1/4) 5 / 3) = 1 + 5 bend.
    assert weights.bend == pytest.approx((np.sqrt(1 + 1.75 * 5 / 3) - 1) / 5)


def test_drifts_are_geometric_sums_of_innovations() -> None:
    """Innovations of 2 and 1, by a memory of 6 readings: (1 + 2 * 5/6) / root(1 + 25/36); the largest sum counts."""
    sums = np.zeros((2, 3, 1))
    assert drift(sums, 2.0) == pytest.approx([2.0])
    leans = [(1 + 2 * fading) / np.sqrt(1 + fading**2) for fading in (5 / 6, 11 / 12, 23 / 24)]
    assert drift(sums, 1.0) == pytest.approx([max(leans)])
    assert drift(np.zeros((2, 3, 1)), -70.0) == pytest.approx([5.0])  # what is larger is the gate's


def test_drawn_errors_have_the_declared_size_and_memory() -> None:
    """A Gauss-Markov error: its standard deviation, and a correlation of 1/e after its time, here 5 readings."""
    random = np.random.default_rng(3)
    process = ErrorProcess(Log(noise=1e-9, period=0.5, coloured=GaussMarkov(0.4, 2.5)), random)
    at = SimpleNamespace(u=0.0)
    drawn = np.array([process.reading(at) for _ in range(10_000)])
    assert drawn.std() == pytest.approx(0.4, rel=0.08)
    assert np.corrcoef(drawn[:-5], drawn[5:])[0, 1] == pytest.approx(np.exp(-1), abs=0.06)
    first = [ErrorProcess(process.sensor, random).reading(at) for _ in range(2000)]
    assert np.std(first) == pytest.approx(0.4, rel=0.08)  # stationary from the start


def test_settings_of_the_bank_of_filters() -> None:
    """Changes here change what navigators see: each is deliberate."""
    assert (settings.SILENT_PERIODS, settings.REFUSED_PERIODS, settings.START_READINGS) == (5.0, 5.0, 3)
    assert (settings.REPLAY_TIME, settings.JUDGE_WAIT, settings.RESTART_TIME) == (60.0, 5.0, 20.0)
    assert (settings.STUCK_READINGS, settings.LONGEST_GAP, settings.COEFFICIENT_MEMORY) == (20, 600.0, 1800.0)
    # What the comments of the settings state.
    assert norm.sf(settings.DRIFT_THRESHOLD) * 2 == pytest.approx(1 / 1.74e6, rel=0.01)
    assert settings.BANK_THRESHOLD == 3.5
    assert (settings.DRIFT_MEMORIES, settings.DRIFT_MOST_INNOVATION, settings.GROSS_ERROR_NIS) == (
        (6, 12, 24),
        5.0,
        1e4,
    )
    assert (settings.FAULT_STD, settings.FAULT_WALK, settings.MODEL_FAULT) == (100.0, 0.3, 3.0)
    assert (settings.RUDDER_FAULT_STD, settings.RUDDER_FAULT_TIME) == (pytest.approx(15 * DEGREE), 60.0)
    assert (settings.DRIFT_ONSETS, settings.DRIFT_START, settings.STEP_START) == ((60.0, 30.0, 15.0), 0.02, 0.1)
    assert (settings.LONGEST_FAULT, math.exp(settings.FAULT_PRIOR)) == (300.0, pytest.approx(50.0))
    assert (settings.TWIN_START_STD, settings.TWIN_SIDE_TIME) == ((3.0, pytest.approx(DEGREE)), 8.0)
    assert (settings.SETTLING_TIME, settings.CONFIDENCE, settings.REFERENCE_LENGTH) == (60.0, 0.95, 230.0)


DEGREE = math.pi / 180


def test_defaults_of_sensors_are_those_of_the_standards_that_they_name() -> None:
    """Gyrocompass within A.424(XI): 0.15 degrees; rate of turn within A.526(13): 0.5 degrees a minute."""
    assert Gyro().noise == pytest.approx(0.15 * DEGREE)
    assert RateOfTurn().noise == pytest.approx(0.01 * DEGREE)
    assert (Log().noise, Gnss().noise, CourseOverGround().noise) == (0.05, 1.5, 0.05)
    assert error_states(Gnss(1.2)) == {"gnss_x_wander": (0, 1.2, 60.0), "gnss_y_wander": (1, 1.2, 60.0)}
    assert RudderIndicator().bias == pytest.approx(DEGREE)
    walks, prior = ProcessNoise(), Prior()
    assert (walks.surge, walks.sway, walks.yaw, walks.bank) == (0.005, 0.003, 1.5e-5, 0.01)
    assert (walks.current, walks.current_across, walks.rudder_bias) == (0.002, 0.003, 1e-5)
    assert (prior.sway, prior.yaw_rate, prior.bank) == (0.15, 5e-4, 0.2)
    assert (prior.current, prior.current_across) == (0.3, 0.05)


def test_error_states_have_a_component_a_size_and_a_time_each() -> None:
    both = Gyro(0.01, bias=0.02, coloured=GaussMarkov(0.03, 40.0))
    assert error_states(both) == {"gyro_bias": (0, 0.02, math.inf), "gyro_wander": (0, 0.03, 40.0)}
    across = Gnss(1.0, coloured=GaussMarkov((0.0, 0.5), 9.0))
    assert error_states(across) == {"gnss_y_wander": (1, 0.5, 9.0)}
    # A fault: 100 deviations, which walk by 0.3 of one from reading to reading: 2 (100 / 0.3)^2 periods.
    time = pytest.approx(2 * (100 / 0.3) ** 2 * 0.5)
    assert error_states(Gyro(0.01, period=0.5), True) == {"gyro_fault": (0, pytest.approx(1.0), time)}
    twice = SimpleNamespace(fields=("a",), errors=(GaussMarkov(1.0), GaussMarkov(2.0)))
    assert error_states(twice) == {"a_bias": (0, 1.0, math.inf), "a_bias_1": (0, 2.0, math.inf)}


def test_velocities_over_ground_are_those_of_a_rigid_body() -> None:
    """An antenna 30 m ahead and 4 m to starboard, by differences of its position over a millisecond."""
    sensor, step = CourseOverGround(forward=30.0, starboard=4.0), 1e-3
    psi, u, v, r = 0.3, 5.0, -0.4, 0.02

    def antenna(t: float) -> np.ndarray:
        heading = psi + r * t
        ahead, right = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
        drift = np.array([u * np.cos(psi) - v * np.sin(psi) + 0.6, u * np.sin(psi) + v * np.cos(psi) - 0.2])
        return drift * t + 30.0 * ahead + 4.0 * right

    at: Any = SimpleNamespace(psi=psi, u=u, v=v, r=r, current=0.6, current_across=-0.2)
    np.testing.assert_allclose(sensor.measured(at), (antenna(step) - antenna(-step)) / (2 * step), rtol=1e-6)
    assert sensor.numbers((0.3, 2.0)) == pytest.approx((2 * math.cos(0.3), 2 * math.sin(0.3)))
    assert sensor.reading(sensor.numbers((-2.5, 2.0))) == pytest.approx((-2.5, 2.0))
    assert (sensor.start((0.3, 2.0)), Gnss(2.0).start((7.0, 8.0))) == ({}, {"x": (7.0, 2.0), "y": (8.0, 2.0)})


def test_drawn_readings_have_white_errors_and_given_slow_ones() -> None:
    sensor, random = Gnss(0.3, coloured=GaussMarkov(0.5, 9.0)), np.random.default_rng(1)
    at = SimpleNamespace(x=np.full(20_000, 4.0), y=np.full(20_000, -2.0))
    x, y = draw_reading(sensor, at, {"gnss_x_wander": 1.0, "gnss_y_wander": -3.0}, random)
    assert (x.mean(), y.mean()) == pytest.approx((5.0, -5.0), abs=0.01)
    assert (x.std(), y.std()) == pytest.approx((0.3, 0.3), rel=0.02)
    assert abs(np.corrcoef(x, y)[0, 1]) < 0.03


def test_markov_processes_keep_their_size_and_walks_grow() -> None:
    """A walk of 0.2 per root second over 9 s is 0.6; a process of deviation s and time T walks by s root(2 / T)."""
    std, time = 0.7, 5.0
    process = MarkovProcess(np.array([0.2, 0.0, std * math.sqrt(2 / time)]), np.array([math.inf, 3.0, time]), [(0, 1)])
    left, noise = process.over(9.0)
    np.testing.assert_allclose(left, [1.0, math.exp(-3.0), math.exp(-9 / 5)])
    covariance = noise.T @ noise
    rest = std**2 * (1 - math.exp(-18 / 5))
    np.testing.assert_allclose(covariance, [[0.36, -0.36, 0.0], [-0.36, 0.36, 0.0], [0.0, 0.0, rest]], atol=1e-12)
    assert process.over(9.0)[1] is noise
    drawn = process.after(np.tile([1.0, 2.0, 0.0], (50_000, 1)), 9.0, np.random.default_rng(2))
    np.testing.assert_allclose(drawn.mean(axis=0), [1.0, 2 * math.exp(-3.0), 0.0], atol=0.02)
    np.testing.assert_allclose(np.cov(drawn.T), covariance, atol=0.02)


# The filter of a ship of 4 m


def test_the_filters_of_faults_have_wide_errors() -> None:
    filter = estimator().filter
    scale = math.sqrt(steered().configuration.ship.length / 230.0)
    assert filter.time_scale == pytest.approx(scale)
    usual = filter.walks
    rudder, model = (filter.with_faults(frozenset({name})) for name in ("rudder", "model"))
    assert rudder.spreads["rudder_bias"] == pytest.approx(15 * DEGREE)
    assert filter.spreads["rudder_bias"] == pytest.approx(DEGREE)
    time = 60.0 * scale
    assert rudder.walks["rudder_bias"] == (pytest.approx(15 * DEGREE * math.sqrt(2 / time)), pytest.approx(time))
    for name in ("u", "v", "r"):
        assert model.walks[name] == (pytest.approx(3 * usual[name][0]), math.inf)
    assert model.walks["bank"] == usual["bank"]
    prior = Prior.of_length(steered().configuration.ship.length)
    assert (filter.spreads["v"], filter.spreads["r"], filter.spreads["bank"]) == (
        prior.sway,
        prior.yaw_rate,
        prior.bank,
    )
    assert filter.spreads["gnss_x_wander"] == 0.02
    assert filter.walks["gnss_x_wander"] == (pytest.approx(0.02 * math.sqrt(2 / 60)), 60.0)
    assert filter.with_faults(frozenset()) is filter
    assert filter.with_faults(frozenset({"rudder"})) is rudder
    assert filter.monitor().shape == (2, 3, 5)
    fading = estimator(memory=50.0).filter.disturbances
    assert fading.walks[-1] == pytest.approx(math.sqrt(2 / 50.0))
    assert fading.times[-1] == 50.0
    # When a current changes, the way through the water changes by as much in the other direction.
    _, noise = filter.disturbances.over(1.0)
    place = filter.states.places
    for current, speed in (("current", "u"), ("current_across", "v")):
        own = noise[:, place[current]] != 0
        np.testing.assert_array_equal(noise[own][:, place[speed]], -noise[own][:, place[current]])


def test_the_root_of_the_coefficients_is_that_of_their_covariance() -> None:
    """Forces ahead move nothing where the speed is held; what is certain has no direction of its own."""
    filter, model = estimator().filter, steered()
    names, root = list(model.terms.names), filter.root
    ahead = np.array([name.startswith("a_") and name not in ("a_udot", "a_vdot") for name in names])
    covariance = root @ root.T
    assert filter.estimated == root.shape[1] == np.linalg.matrix_rank(covariance)
    moving = covariance.diagonal() > 0
    np.testing.assert_allclose(covariance[np.ix_(moving, moving)], model.covariance[np.ix_(moving, moving)], rtol=1e-9)
    assert not moving[ahead].any()
    sure = replace(model, covariance=np.zeros_like(model.covariance))
    assert Estimator(sure, SENSORS).filter.estimated == 0
    assert estimator(coefficients="certain").filter.estimated == 0


def test_errors_of_the_rudders_indication_are_a_pair_of_points() -> None:
    """One more pair than states: both at the mean, with the rudder off by the noise times the distance."""
    exact, noisy = (Estimator(steered(), [*SENSORS, RudderIndicator(noise)]).filter for noise in (0.0, 0.02))
    assert exact.pairs == len(exact.states) + exact.estimated
    assert noisy.pairs == exact.pairs + 1
    np.testing.assert_array_equal(exact.rudder_noise, [[0.0]])
    added = noisy.rudder_noise[:, 0]
    assert added.size == 1 + 2 * noisy.pairs
    assert np.flatnonzero(added).tolist() == [noisy.pairs, 2 * noisy.pairs]
    assert added[[noisy.pairs, 2 * noisy.pairs]] == pytest.approx(0.02 * math.sqrt(3.0) * np.array([1.0, -1.0]))


def test_a_lean_of_one_gross_innovation_is_limited_and_a_gate_refuses_it() -> None:
    free, gated = (estimator(refusing=share).filter for share in (0.0, 1e-5))
    size = len(free.states) + free.estimated
    state = Gaussian(np.eye(size)[3], 1e-3 * np.eye(size))
    for filter, lean, refused in ((free, 5.0, ()), (gated, 0.0, ("log",))):
        monitor = filter.monitor()
        _, found = filter.update(0.0, state, {"log": (3.0,), "gyro": (2 * math.pi,)}, monitor)
        assert found.drift_statistic == pytest.approx(lean, abs=1e-6)  # a turn more is no innovation
        assert found.refused == refused
        assert found.nis["log"] == pytest.approx(2.0**2 / (0.01**2 + 1e-6), rel=1e-3)
        assert found.suspects == ()


# Estimates and tracks


def estimate(mean: list[float], root: np.ndarray) -> Estimate:
    return Estimate(2.0, StateNames(("x", "y", "psi", "u")), Gaussian(np.array(mean), root), True, {})


def test_an_estimate_leaves_out_the_coefficients_and_whole_turns() -> None:
    root = np.tril(np.arange(1.0, 26.0).reshape(5, 5)) / 10
    found = estimate([1.0, 2.0, 3 * math.pi - 0.1, 5.0, 9.0], root)
    assert found.values == {"x": 1.0, "y": 2.0, "psi": pytest.approx(math.pi - 0.1), "u": 5.0}
    np.testing.assert_allclose(found.covariance, (root @ root.T)[:4, :4])
    np.testing.assert_allclose(list(found.std.values()), np.sqrt(np.diag(root @ root.T)[:4]))
    assert "psi = 3.0" in found.summary()
    empty = Estimate(2.0, found.states, None, False, {})
    assert (empty.values, empty.std, empty.covariance.shape) == ({}, {}, (0, 0))


def test_a_track_counts_and_tabulates() -> None:
    covariance = np.array([np.diag([0.01, 0.04]), np.diag([0.09, 0.16]), np.diag([0.25, -1e-20])])
    flags = {"gnss": np.array([True, False, True])}, {"gnss": np.array([False, False, True])}
    mean = np.arange(6.0).reshape(3, 2)
    track = EstimatedTrack(
        np.array([0.0, 1.0, 3.0]), mean, covariance, ("y", "psi"), flags[0]["gnss"], *flags, True, ()
    )
    np.testing.assert_allclose(track.std, [[0.1, 0.2], [0.3, 0.4], [0.5, 0.0]])
    told = track.to_dict()
    assert told["median_std"] == {"y": pytest.approx(0.3), "psi": pytest.approx(0.2)}
    assert (told["times"], told["ready"], told["refused"], told["suspected"]) == (3, 2, {"gnss": 2}, {"gnss": 1})
    data = track.dataset()
    np.testing.assert_array_equal(data["psi"], [1.0, 3.0, 5.0])
    np.testing.assert_allclose(data["y_std"], [0.1, 0.3, 0.5])
    np.testing.assert_array_equal(data["covariance"], covariance)
    np.testing.assert_array_equal(data["gnss_refused"], [1, 0, 1])
    assert list(track.to_dataframe()["y"]) == [0.0, 2.0, 4.0]
    figure = track.plot()
    assert_readable(figure)
    offset, heading = figure.axes
    assert [axes.get_ylabel() for axes in figure.axes] == ["y [m]", "psi [deg]"]
    np.testing.assert_allclose(offset.lines[0].get_ydata(), [0.0, 2.0, 4.0])
    np.testing.assert_allclose(heading.lines[0].get_ydata(), np.degrees([1.0, 3.0, 5.0]))
    band = offset.collections[0].get_paths()[0].vertices[:, 1]
    assert (band.min(), band.max()) == pytest.approx((0.0 - 1.96 * 0.1, 4.0 + 1.96 * 0.5), abs=1e-4)
    assert {"95 % band", "gnss refused", "gnss suspected"} <= {own.get_label() for own in offset.collections}


# Twins


def consistent(error: np.ndarray, std: np.ndarray, nees: np.ndarray, nis: np.ndarray) -> Consistency:
    flags = {"gnss": nis > 1e9}
    return Consistency(
        np.arange(3.0), error, std, nees, {"gnss": nis}, flags, flags, {"gnss": 2}, ("y", "psi"), 1.0, 0, ()
    )


def test_statistics_of_two_twins_from_the_settling_time_on() -> None:
    """Three times, of which the last two count; one twin has no estimate at the last."""
    error = np.array([[[9.0, 9.0], [1.0, 2.0], [3.0, -2.0]], [[9.0, 9.0], [-1.0, 6.0], [np.nan, np.nan]]])
    nees = np.array([[99.0, 1.0, 5.0], [99.0, 3.0, np.nan]])
    nis = np.array([[99.0, np.nan, 3.0], [99.0, 1.0, 8.0]])
    found = consistent(error, np.full_like(error, 1.5), nees, nis)
    assert found.counted.tolist() == [False, True, True]
    assert found.mean_nees == pytest.approx(3.0 / 2)
    assert found.mean_nis == {"gnss": pytest.approx(4.0 / 2)}
    assert found.rmse == {"y": pytest.approx(math.sqrt(11 / 3)), "psi": pytest.approx(math.sqrt(44 / 3))}
    # Within 1.96 times 1.5: of y 1, -1 and not 3; of psi 2, -2 and not 6.
    assert found.covered == {"y": pytest.approx(2 / 3), "psi": pytest.approx(2 / 3)}
    low, high = found.bounds()
    assert (low, high) == pytest.approx((chi2.ppf(0.025, 4) / 4, chi2.ppf(0.975, 4) / 4))
    assert found.within == 1.0  # means of 1 and 2.5, from 0.12 to 2.79
    assert consistent(error, error, np.array([[0.0, 0.1, 5.9], [0.0, 0.1, 5.9]]), nis).within == 0.0


def test_twins_are_read_row_by_row() -> None:
    readings = {"gnss": np.array([[[1.0, 2.0]], [[np.nan, 2.0]]]), "log": np.array([[[3.0]], [[4.0]]])}
    twins = Twins(np.array([0.0, 0.5]), np.zeros((2, 1, 6)), np.array([[[0.1]], [[0.2]]]), readings, np.zeros(1, bool))
    (t0, first), (t1, then) = twins.rows(0, ("rudder",))
    assert (t0, t1) == (0.0, 0.5)
    assert (first["gnss"].tolist(), first["log"].tolist(), first["rudder"]) == ([1.0, 2.0], [3.0], 0.1)
    assert (set(then), then["log"].tolist(), then["rudder"]) == ({"log", "rudder"}, [4.0], 0.2)


def test_a_twins_rudder_swings_every_third_turn_within_its_gear() -> None:
    """Turns of eight roots of length over gravity: to port, still, still, to starboard, still, still."""
    ship, gear = SimpleNamespace(length=4 * 9.80665), SimpleNamespace(limit=0.5, rate=0.1)
    model = SimpleNamespace(configuration=SimpleNamespace(gear=gear, ship=ship))
    filter: Any = SimpleNamespace(actuators=("rudder", "revolutions"), states=StateNames(("x", "y")), model=model)
    seen: list[dict[str, Any]] = []
    law: Any = SimpleNamespace(dt=2.0, orders=lambda t, at: seen.append(at) or {"rudder": 0.3 + at["y"]})
    states, before = np.array([[1.0, 0.0], [2.0, 9.0]]), np.array([[0.25, 7.0], [0.4, 8.0]])
    found = [_positions(filter, law, 0.12, 16.0 * turn + 1.0, states, before) for turn in range(7)]
    # Orders of 0.3 -+ 0.12 from 0.25, at most 0.2 in 2 s; of the other, 0.5 whatever the swing.
    np.testing.assert_allclose([own[0, 0] for own in found], [0.18, 0.3, 0.3, 0.42, 0.3, 0.3, 0.18])
    np.testing.assert_allclose([own[1, 0] for own in found], 0.5)
    np.testing.assert_array_equal([own[:, 1] for own in found], [[7.0, 8.0]] * 7)
    np.testing.assert_allclose(_positions(filter, law, 0.0, 0.0, states, before - 1.0)[:, 0], [-0.55, -0.4])
    np.testing.assert_array_equal(seen[0]["rudder"], [0.25, 0.4])
    still: Any = SimpleNamespace(**{**vars(filter), "actuators": ("revolutions",)})
    np.testing.assert_array_equal(_positions(still, law, 0.12, 0.0, states, before), before)


def test_readings_of_twins_come_late_and_lie_between_the_times() -> None:
    """Speeds rise by 1 m/s a second: a reading of every second one, 0.75 s late, is that of the time between."""
    log: Any = Log(1e-9, period=1.0, delay=0.75)
    filter: Any = SimpleNamespace(states=StateNames(("x", "u")))
    lanes: Any = SimpleNamespace(bend=lambda x: 0.0)
    times, states = 0.5 * np.arange(6), np.zeros((6, 2, 2))
    states[..., 1] = times[:, None] + np.array([0.0, 10.0])
    found = _readings(log, lanes, filter, times, states, np.random.default_rng(0))[..., 0]
    nothing = math.nan
    np.testing.assert_allclose(found[:, 0], [nothing, nothing, 0.25, nothing, 1.25, nothing], atol=1e-6)
    np.testing.assert_allclose(found[:, 1] - found[:, 0], [nothing, nothing, 10.0, nothing, 10.0, nothing], atol=1e-6)


@pytest.mark.parametrize("curvature", [1e-3, -1e-3])
def test_an_antenna_ahead_in_a_bend_is_off_the_circle_by_its_chord(curvature: float) -> None:
    """At 100 m ahead on a tangent of a circle of 1000 m: hypot(1000, 100) from its centre, at an angle of atan(0.1)."""
    at: Any = SimpleNamespace(x=50.0, y=0.0, psi=0.0, curvature=curvature)
    x, y = Gnss(forward=100.0).measured(at)
    outward = math.hypot(1000.0, 100.0) - 1000.0
    assert (x, y) == pytest.approx((50.0 + 1000.0 * math.atan(0.1), -math.copysign(outward, curvature)))
