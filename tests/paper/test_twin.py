"""Tests like the paper's, run on its own model: identification gives its coefficients back, or says that it cannot."""

from functools import cache

import numpy as np
import pytest

import narrows as nw

SEEDS = range(20)
NOISES = (0.0, 0.5, 2.0)
"""Correlation time of the noise [s]: white, and two that neighbouring rows share."""
FREE_OF_A_SINGLE_SPEED = nw.PAPER.names[3:]


@cache
def fitted(seed: int, correlation_time: float) -> nw.Fit:
    """Fit a twin whose runs differ by their noise alone, and say so."""
    return nw.identify(
        nw.twin(seed=seed, correlation_time=correlation_time), balance="rows", errors=nw.RunErrors(0, 0, 0)
    )


def errors(correlation_time: float) -> np.ndarray:
    """Distance from the truth in standard errors, (seeds, coefficients)."""
    truth = nw.published("mikkelsen2025_dtc").coefficients
    fits = [fitted(seed, correlation_time) for seed in SEEDS]
    return np.array([[(f.coefficients[n] - truth[n]) / f.std[n] for n in FREE_OF_A_SINGLE_SPEED] for f in fits])


def test_without_noise_the_truth_comes_back(dtc: nw.Model) -> None:
    fit = nw.identify(nw.twin(noise={}))
    for name in FREE_OF_A_SINGLE_SPEED:
        assert fit.coefficients[name] == pytest.approx(dtc.coefficients[name], rel=1e-7)
    assert fit.solution.kkt.satisfied


@pytest.mark.parametrize("correlation_time", NOISES)
def test_intervals_hold_the_truth(dtc: nw.Model, correlation_time: float) -> None:
    held = [
        low <= dtc.coefficients[name] <= high
        for seed in SEEDS
        for name, (low, high) in fitted(seed, correlation_time).intervals.items()
        if name in FREE_OF_A_SINGLE_SPEED
    ]
    assert len(held) == 280
    assert np.mean(held) >= 0.90
    assert not all(held), "intervals that always hold the truth are too wide to be 95 %"


@pytest.mark.parametrize("correlation_time", NOISES)
def test_no_estimate_is_far_off(correlation_time: float) -> None:
    assert np.abs(errors(correlation_time)).max() < 5


@pytest.mark.parametrize("correlation_time", NOISES)
def test_estimates_are_unbiased(correlation_time: float) -> None:
    """The mean error over independent seeds is within 4 of its own standard errors."""
    mean = errors(correlation_time).mean(axis=0) * np.sqrt(len(SEEDS))
    assert np.abs(mean).max() < 4


def test_correlated_noise_widens_the_intervals() -> None:
    """Row-wise formulas would give the same standard errors for both."""
    white, red = (np.mean([fitted(s, ct).std["b_bank"] for s in SEEDS]) for ct in (0.0, 2.0))
    assert red > 3 * white


def test_surge_inertia_is_flagged(twin_fit: nw.Fit) -> None:
    verdict = twin_fit.verdicts["a_udot"]
    assert (verdict.status, verdict.determined) == ("not excited", False)
    assert verdict.sentence("a_udot") == "a_udot is not identifiable: udot is 0 in every test."
    assert twin_fit.coefficients["a_udot"] == 0.0
    assert np.isnan(twin_fit.std["a_udot"])
    assert twin_fit.intervals["a_udot"] == nw.NONNEGATIVE


@pytest.mark.parametrize("name", ["a_u", "a_uu"])
def test_resistance_at_one_speed_is_flagged(twin_fit: nw.Fit, name: str) -> None:
    """The paper prints (0, 12.6) for what one speed determines in combination only."""
    verdict = twin_fit.verdicts[name]
    assert (verdict.status, verdict.determined) == ("not identifiable", False)
    assert "a_u and a_uu only in combination" in verdict.reasons[0]
    assert np.isnan(twin_fit.std[name])
    combined = twin_fit.coefficients["a_u"] * 1.0 + twin_fit.coefficients["a_uu"] * 1.0
    assert combined == pytest.approx(12.6, abs=0.1)


def test_two_speeds_tell_the_two_apart(dtc: nw.Model) -> None:
    runs = tuple(nw.HarmonicRun(f"{u}", "yaw", 0.5, 25.0, u) for u in (0.5, 1.0, 1.5))
    fit = nw.identify(nw.twin(dtc, runs))
    assert fit.verdicts["a_u"].determined
    assert fit.verdicts["a_uu"].determined
    low, high = fit.intervals["a_uu"]
    assert low <= 12.6 <= high


def test_full_rank_in_sway_and_yaw_short_in_surge(twin_fit: nw.Fit) -> None:
    """What the paper reads from fig. (corr)."""
    found = twin_fit.diagnostics.overall
    assert {force: (d.rank, len(d.names)) for force, d in found.items()} == {"X": (1, 3), "Y": (7, 7), "N": (7, 7)}


def test_shapley_agrees_with_the_paper_on_what_is_least(twin_fit: nw.Fit) -> None:
    """In the paper's table b_rdot (0.002) and b_rr (0.015) are the least of sway, each sum of sizes 1."""
    for shares in twin_fit.shapley().values():
        assert sum(map(abs, shares.values())) == pytest.approx(1.0, rel=1e-12)
    sizes = {name: abs(share) for name, share in twin_fit.shapley()["Y"].items()}
    assert set(sorted(sizes, key=sizes.__getitem__)[:2]) == {"b_rdot", "b_rr"}
    assert max(sizes["b_rdot"], sizes["b_rr"]) < 0.02


def test_shapley_ranks(twin_fit: nw.Fit) -> None:
    """Ranks on our twin, whose periods are ours: its table is not the paper's."""
    ranks = {"Y": "b_vv b_v b_vdot b_bank b_r b_rr b_rdot", "N": "c_v c_vv c_rdot c_rr c_bank c_r c_vdot"}
    for force, expected in ranks.items():
        shares = twin_fit.shapley()[force]
        assert sorted(shares, key=lambda name: -abs(shares[name])) == expected.split()


def test_a_fit_to_random_rows_predicts_the_others(dtc: nw.Model) -> None:
    tests = nw.twin(seed=3)
    keep = np.random.default_rng(1).random(tests.rows) < 0.8
    fit = nw.identify(tests.of_rows(keep))
    left_out = fit.score(tests.of_rows(~keep))
    for name in FREE_OF_A_SINGLE_SPEED:
        assert fit.coefficients[name] == pytest.approx(dtc.coefficients[name], abs=5 * fit.std[name])
    assert left_out["Y"].rmse == pytest.approx(0.5, rel=0.1)
    assert left_out["N"].rmse == pytest.approx(0.65, rel=0.1)
