"""Numbers of the estimator against scaling laws and hand computations; no filter runs here."""

from types import SimpleNamespace

import numpy as np
import pytest

from narrows.codegen.cache import compiled_loops
from narrows.estimation import GaussMarkov, Log, Prior, ProcessNoise, settings, square_roots
from narrows.estimation.sensors import ErrorProcess
from narrows.estimation.ship_filter import MEMORIES, sigma_point_weights


def drift(sums: np.ndarray, innovation: float) -> np.ndarray:
    """The statistic of one number."""
    return compiled_loops(square_roots).drift_statistics(sums, MEMORIES, np.zeros(1, int), np.array([innovation]), 5.0)


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
    """A Gauss-Markov error: its standard deviation, and a correlation of 1/e after its time, here 20 readings."""
    random = np.random.default_rng(3)
    process = ErrorProcess(Log(noise=1e-9, period=0.5, coloured=GaussMarkov(0.4, 10.0)), random)
    at = SimpleNamespace(u=0.0)
    drawn = np.array([process.reading(at) for _ in range(40_000)])
    assert drawn.std() == pytest.approx(0.4, rel=0.08)
    assert np.corrcoef(drawn[:-20], drawn[20:])[0, 1] == pytest.approx(np.exp(-1), abs=0.06)
    first = [ErrorProcess(process.sensor, random).reading(at) for _ in range(2000)]
    assert np.std(first) == pytest.approx(0.4, rel=0.08)  # stationary from the start


def test_settings_of_the_bank_of_filters() -> None:
    """Changes here change what navigators see: each is deliberate."""
    assert (settings.SILENT_PERIODS, settings.REFUSED_PERIODS, settings.START_READINGS) == (5.0, 5.0, 3)
    assert (settings.REPLAY_TIME, settings.JUDGE_WAIT, settings.RESTART_TIME) == (60.0, 5.0, 20.0)
    assert (settings.STUCK_READINGS, settings.LONGEST_GAP, settings.COEFFICIENT_MEMORY) == (20, 600.0, 1800.0)
