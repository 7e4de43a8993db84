"""The Kalman filter of a record: against the dense normal distribution, its slopes against differences, its scores."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from test_predict_information import OWN, SPEED, posed, ship

import narrows as nw
from narrows.codegen.cache import compiled_loops
from narrows.logbook.filtering import kalman_loops
from narrows.logbook.filtering.likelihood import RecordLikelihood, readings_for_one
from narrows.logbook.filtering.log_problem import SWAY, YAW, Estimated, Process, StochasticModel
from narrows.logbook.learning.log_setup import LogSetup, log_problem
from narrows.logbook.transits import recorded, wandering
from narrows.simulation.controllers import Order

STEPS, READINGS = 5, 3


@dataclass(frozen=True)
class System:
    """A random linear system: six states and three processes, of which two drive the ship."""

    seed: int

    @cached_property
    def parts(self) -> dict[str, np.ndarray]:
        draw = np.random.default_rng(self.seed)
        roots = draw.normal(size=(3, 9, 9))
        return {
            "covariance": roots[2] @ roots[2].T,
            "slopes": 0.5 * draw.normal(size=(STEPS, 6, 9)) * (np.arange(9) != 7),
            "misses": draw.normal(size=(STEPS, 6)),
            "kept": draw.uniform(0.2, 1.0, 3),
            "fresh": roots[0][:3, :3] @ roots[0][:3, :3].T,
            "walk": draw.uniform(0.1, 1.0, (STEPS, 6)),
            "first": READINGS * np.arange(STEPS + 1),
            "rows": draw.normal(size=(STEPS * READINGS, 9)),
            "residual": draw.normal(size=STEPS * READINGS),
            "variance": draw.uniform(0.5, 2.0, STEPS * READINGS),
        }

    @cached_property
    def filtered(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Innovations, their variances, and smoothed means."""
        p, count = self.parts, STEPS * READINGS
        innovations, spread, gains = np.empty(count), np.empty(count), np.empty((count, 9))
        means, covariances = np.empty((STEPS, 9)), np.empty((STEPS, 9, 9))
        loops = compiled_loops(kalman_loops)
        loops.filter_readings(*p.values(), innovations, spread, gains, means, covariances)
        loops.smooth(p["slopes"], p["kept"], p["first"], p["rows"], innovations, spread, gains, means, covariances)
        return innovations, spread, means

    @cached_property
    def dense(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and covariance of the states of all steps, one after the other."""
        p, mean, size = self.parts, np.zeros(9 * STEPS), 9 * STEPS
        covariance = np.zeros((size, size))
        covariance[:9, :9] = p["covariance"]
        for k in range(STEPS - 1):
            here, then = slice(9 * k, 9 * k + 9), slice(9 * k + 9, 9 * k + 18)
            moved = np.zeros((9, 9))
            moved[:6] = p["slopes"][k]
            moved[6:, 6:] = np.diag(p["kept"])
            noise = np.zeros((9, 9))
            noise[:6, :6], noise[6:, 6:] = np.diag(p["walk"][k]), p["fresh"]
            mean[then] = moved @ mean[here] + np.append(p["misses"][k], np.zeros(3))
            covariance[then, : 9 * k + 9] = moved @ covariance[here, : 9 * k + 9]
            covariance[: 9 * k + 9, then] = covariance[then, : 9 * k + 9].T
            covariance[then, then] = moved @ covariance[here, here] @ moved.T + noise
        return mean, covariance

    @cached_property
    def read(self) -> np.ndarray:
        """Slopes of all readings by the states of all steps."""
        rows = np.zeros((STEPS * READINGS, 9 * STEPS))
        for place, row in enumerate(self.parts["rows"]):
            step = place // READINGS
            rows[place, 9 * step : 9 * step + 9] = row
        return rows


@pytest.mark.parametrize("seed", range(3))
def test_the_likelihood_is_that_of_the_dense_normal_distribution(seed: int) -> None:
    system = System(seed)
    innovations, spread, _ = system.filtered
    mean, covariance = system.dense
    dense = multivariate_normal(
        system.read @ mean, system.read @ covariance @ system.read.T + np.diag(system.parts["variance"])
    )
    ours = -0.5 * np.sum(innovations**2 / spread + np.log(2 * np.pi * spread))
    assert ours == pytest.approx(dense.logpdf(system.parts["residual"]), rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_smoothed_states_are_the_conditional_mean(seed: int) -> None:
    system = System(seed)
    mean, covariance = system.dense
    read, noise = system.read, np.diag(system.parts["variance"])
    gain = np.linalg.solve(read @ covariance @ read.T + noise, read @ covariance).T
    smoothed = mean + gain @ (system.parts["residual"] - read @ mean)
    np.testing.assert_allclose(system.filtered[2].ravel(), smoothed, rtol=1e-7, atol=1e-9)


def test_the_score_is_the_slope_of_the_likelihood() -> None:
    """About a path, by central differences: coefficients, gusts and noise."""
    log = posed(1)
    (grid,) = log
    likelihood, draw = RecordLikelihood(log.problem, grid), np.random.default_rng(0)
    unknowns = 0.1 * draw.normal(size=len(log.problem.precision))
    path = likelihood.smoothed(unknowns, None, 2)
    assert path is not None
    found = likelihood.scored(unknowns, path)
    for place in range(len(log.problem.precision)):
        step = 1e-3 * (np.arange(len(unknowns)) == place)
        up, down = (likelihood.cost(unknowns + sign * step, path) for sign in (1, -1))
        size = np.sqrt(found.information[place, place])
        assert found.score[place] == pytest.approx((down - up) / 4e-3, rel=0.01, abs=0.02 * size)
    y, u = np.abs(path.states[:, [1, 3]]).T
    np.testing.assert_allclose(found.ranges, [[y.min(), u.min()], [y.max(), u.max()]])
    assert {name: count for name, (_, count) in found.outliers.items()} == {
        name: len(read.values) for name, read in grid.readings.items()
    }
    assert sum(far for far, _ in found.outliers.values()) == (path.weights < 1).sum()
    innovations = likelihood.linear(unknowns, path).filtered(log.problem.model_at(unknowns), path.weights)[0]
    normal = np.clip(innovations[0] / np.sqrt(innovations[1]), -4.0, 4.0)
    parts = grid.by_signal(normal).values()
    assert found.autocovariance[0] == pytest.approx(float(normal @ normal))
    assert found.autocovariance[3] == pytest.approx(sum(float(part[3:] @ part[:-3]) for part in parts))


@dataclass(frozen=True)
class Schedule:
    """Rudder angles that answer nothing."""

    seed: int

    def begin(self) -> Order:
        return lambda t, at: 0.03 * np.sin(0.6 * t + self.seed)


def scheduled(seed: int) -> LogSetup:
    """A record of the ship under rudder angles that answer nothing, in the gusts that the problem takes for usual."""
    step, duration, draw = 0.2, 60.0, np.random.default_rng((seed, 1))
    log = posed(1)
    sizes = {one.name: one for one in log.problem.model.processes}
    pushes = {}
    for name, inertia in zip((SWAY, YAW), log.problem.at(np.zeros(log.problem.count))[1][1:], strict=True):
        gust, steady = sizes[name], sizes[f"steady_{name}"]
        series = wandering(gust.std, gust.memory, step, round(duration / step), draw)[:, 0]
        series += 0.05 * steady.std * draw.standard_normal()
        pushes[name] = list(zip((step * np.arange(len(series))).tolist(), (inertia * series).tolist(), strict=True))
    voyage = nw.simulate(
        ship(), u=SPEED, duration=duration, dt=0.1, controller=Schedule(seed), **pushes
    )  # fmt: skip
    exact = replace(OWN, signals={name: replace(one, zero=0.0) for name, one in OWN.signals.items()})
    return log_problem(ship(), recorded(f"{seed}", voyage, exact, seed, current=0.0), OWN, gusts=True)


def test_scores_at_the_truth_have_a_mean_of_zero() -> None:
    """Where nothing but the ship answers: of coefficients, in units of what their scatter allows."""
    scores, information = [], []
    for seed in range(12):
        log = scheduled(seed)
        (grid,) = log
        likelihood = RecordLikelihood(log.problem, grid)
        path = likelihood.smoothed(np.zeros(len(log.problem.precision)), None, 3)
        assert path is not None
        found = likelihood.scored(np.zeros(len(log.problem.precision)), path)
        scores.append(found.score)
        information.append(np.diag(found.information))
    names = log.problem.prior.names
    of = [names.index(name) for name in ("b_bank", "c_bank")]
    normal = np.sum(scores, axis=0)[of] / np.sqrt(np.sum(information, axis=0)[of])
    assert np.abs(normal).max() < 3.0


def test_gusts_that_were_stationary_stay_so() -> None:
    gusts = (Process(SWAY, SWAY, 1.0, 40.0), Process(YAW, YAW, 2.0, 40.0), Process("zero", "zero", 0.5, np.inf))
    model = StochasticModel(gusts, {"y": 0.1}, (Estimated("correlation", (SWAY, YAW), 1.0),), gusts=(SWAY, YAW)).at(
        [0.5]
    )
    kept = model.kept(10.0)
    assert kept == pytest.approx([np.exp(-0.25), np.exp(-0.25), 1.0])
    assert model.covariance()[0, 1] / 2.0 == pytest.approx(np.tanh(0.5), abs=0.01)


def test_readings_that_remember_count_less() -> None:
    """An autoregression of the first order: as many for one as (1 + a) / (1 - a), of the part that is above noise."""
    kept = 0.8
    assert readings_for_one(1000 * kept ** np.arange(400.0)) == pytest.approx((1 + kept) / (1 - kept), rel=0.06)
    assert readings_for_one(np.append(1000.0, np.zeros(399))) == 1.0
