"""What is said of coefficients, against refits: bootstrap, trade-offs, influence, coverage."""

import numpy as np
import pytest

import narrows as nw
from narrows.captive.tests import CaptiveTests
from narrows.report.fit_page import section
from tables import many_runs, short_twin

NAMES = nw.PAPER.names


@pytest.fixture(scope="module")
def fit() -> nw.Fit:
    return nw.identify(short_twin(5, many_runs(12)), errors=nw.RunErrors(0, 0, 0))


def repeated(tests: CaptiveTests, times: np.ndarray) -> CaptiveTests:
    """Return tests, each as often as it was drawn."""
    rows = np.concatenate(
        [np.tile(np.arange(tests.starts[i], tests.starts[i + 1]), n) for i, n in enumerate(times) if n]
    )
    names = tuple(f"{tests.names[i]}-{k}" for i, n in enumerate(times) for k in range(n))
    lengths = np.repeat(np.diff(tests.starts), times)
    starts = np.concatenate([[0], np.cumsum(lengths)])
    return CaptiveTests({n: c[rows] for n, c in tests.columns.items()}, names, starts, tests.configuration)


def test_a_resample_is_the_fit_to_the_tests_that_were_drawn(fit: nw.Fit) -> None:
    found = fit.bootstrap(20, seed=3)
    times = np.random.default_rng(3).multinomial(12, np.full(12, 1 / 12), size=20)
    for i in (0, 7, 19):
        refit = nw.identify(repeated(fit.tests, times[i]))
        known = [n for n in NAMES if fit.verdicts[n].determined and refit.verdicts[n].determined]
        for name in known:
            own = found.samples[i, NAMES.index(name)]
            assert own == pytest.approx(refit.least_squares[name], rel=1e-5, abs=1e-6 * abs(fit.std[name]))


def test_draws_keep_the_bounds_and_the_tie(fit: nw.Fit) -> None:
    draws = dict(zip(NAMES, fit.bootstrap(400).samples.T, strict=True))
    np.testing.assert_array_equal(draws["b_rdot"], draws["c_vdot"])
    for term in nw.PAPER.terms:
        assert (draws[term.name] >= term.bound[0] - 1e-9).all()


def test_bootstrap_and_jackknife_agree(fit: nw.Fit) -> None:
    found = fit.bootstrap(4000)
    known = [i for i, n in enumerate(NAMES) if fit.verdicts[n].determined]
    ratio = found.std[known] / fit.estimates.free_std[known]
    assert np.median(ratio) == pytest.approx(1.0, abs=0.3)
    for name, (low, high) in found.intervals().items():
        assert low <= high, name


def test_the_same_seed_gives_the_same_draws(fit: nw.Fit) -> None:
    one, two, other = (fit.bootstrap(50, seed).samples for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, two)
    assert not np.array_equal(one, other)


def test_one_resample_is_refused(fit: nw.Fit) -> None:
    with pytest.raises(nw.InputError, match="no spread"):
        fit.bootstrap(1)


def test_a_trade_off_is_that_of_harmonic_yaw() -> None:
    """y = -(U/w^2) r: at 1 m/s a yaw damping up by 1 takes w^2 / (1/2 C_B rho L T delta'(0)) off the bank."""
    fit = nw.identify(
        nw.twin(runs=(nw.HarmonicRun("yaw", "yaw", 0.9, 25.0), nw.HarmonicRun("sway", "sway", 0.9, 25.0))),
        errors=nw.RunErrors(0, 0, 0),
    )
    pair = next(p for p in fit.correlations if {p.first, p.second} == {"b_r", "b_bank"})
    assert abs(pair.correlation) > 0.98
    slope = pair.slope if pair.first == "b_r" else 1 / pair.slope
    assert slope == pytest.approx(-((2 * np.pi / 25) ** 2) / (214.624 * 0.120603), rel=0.2)
    assert pair.first in pair.sentence
    assert pair.second in pair.sentence


def test_influence_is_that_of_refits(fit: nw.Fit) -> None:
    for i in (0, 5):
        kept = [j != i for j in range(12)]
        refit = nw.identify(fit.tests.where(kept))
        for j, name in enumerate(NAMES):
            if fit.verdicts[name].determined and refit.verdicts[name].determined:
                moved = fit.least_squares[name] - refit.least_squares[name]
                assert fit.influence.moved[i, j] == pytest.approx(moved, rel=1e-4, abs=1e-6 * fit.std[name])
    assert ((fit.influence.information >= 0) & (fit.influence.information <= 1)).all()


def test_the_one_sway_run_informs_sway() -> None:
    runs = (*(nw.HarmonicRun(f"Y{i}", "yaw", 0.3 + 0.1 * i, 14.0 + i) for i in range(4)),)
    fit = nw.identify(short_twin(1, (*runs, nw.HarmonicRun("the sway", "sway", 0.9, 20.0))))
    for name in ("b_v", "c_vv", "b_vdot"):
        test, share = fit.influence.most_informing(name)
        assert test == "the sway"
        assert share > 0.9
        moving, by = fit.influence.most_moving(name)
        assert moving == "the sway"
        assert np.isnan(by)
    assert "not determined without it" in {entry[4] for entry in section("", fit, 0)["influence"]}


@pytest.mark.parametrize("time", [0.0, 1.0])
@pytest.mark.slow
def test_intervals_cover_the_truth(time: float) -> None:
    """Also of b_v and c_r, which are at their bounds."""
    truth = nw.published("mikkelsen2025_dtc").with_coefficients(b_v=0.0, c_r=0.0)
    held = []
    for seed in range(40):
        tests = nw.twin(truth, many_runs(16), rate=4.0, seed=seed, correlation_time=time)
        errors = nw.RunErrors(0, 0, 0) if time == 0 else nw.RunErrors()
        intervals = nw.identify(tests, errors=errors).intervals
        held.append([intervals[n][0] <= truth.coefficients[n] <= intervals[n][1] for n in NAMES[3:]])
    share = np.mean(held, axis=0)
    assert 0.93 < share.mean() <= 1.0
    assert share.min() > 0.85


def test_one_harmonic_run_has_intervals() -> None:
    """Bank and yaw rate depend on each other to rounding: the covariance is nearly singular."""
    fit = nw.identify(nw.twin(runs=[nw.HarmonicRun("yaw", "yaw", 0.9, 25.0)], correlation_time=0.5, rate=10.0))
    assert np.isfinite(fit.intervals["b_bank"]).all()


def test_harmonic_yaw_alone_does_not_identify_a_bank_until_straight_runs_are_added() -> None:
    yaw = (nw.HarmonicRun("A", "yaw", 0.9, 25.0), nw.HarmonicRun("B", "yaw", 0.5, 25.0))
    alone = nw.identify(nw.twin(runs=yaw))
    separating = (nw.StraightRun("s1", 0.9), nw.StraightRun("s2", 1.5), nw.StraightRun("s3", -1.2))
    separated = nw.identify(nw.twin(runs=(*yaw, *separating)))
    for name in ("b_bank", "c_bank"):
        assert alone.verdicts[name].status != "identified"
        assert separated.verdicts[name].status == "identified"
        assert separated.verdicts[name].limits


@pytest.mark.parametrize("terms", ["paper", "speed", "mixed", "crossflow"])
def test_an_estimate_lies_in_its_own_interval(terms: str, kcs_tests: dict[int, nw.CaptiveTests]) -> None:
    for tests in kcs_tests.values():
        fit = nw.identify(tests, terms)
        for name, (low, high) in fit.intervals.items():
            slack = 1e-5 * max(abs(low), abs(high)) if np.isfinite([low, high]).all() else 0.0
            assert low - slack <= fit.coefficients[name] <= high + slack, (terms, name)


def test_samples_keep_what_the_tests_determine(kcs_fits: dict[int, nw.Fit]) -> None:
    """b_v and b_vv trade: where one is brought back to its bound, the force at the speeds of the tests stays."""
    from narrows.simulation.grid import grid_of

    fit = kcs_fits[100]
    values = grid_of(fit.model, {}, 4000, 0).values
    v = 0.05
    force = values["b_v"].to_numpy() * v + values["b_vv"].to_numpy() * v * v
    direction = np.array([{"b_v": v, "b_vv": v * v}.get(name, 0.0) for name in NAMES])
    spread = np.sqrt(direction @ fit.covariance @ direction)
    assert force.mean() == pytest.approx(direction @ [fit.coefficients[n] for n in NAMES], abs=0.5 * spread)
    assert force.std() == pytest.approx(spread, rel=0.3)
    assert (values["b_vv"] >= 0).all()


@pytest.mark.parametrize("level", [0.0, 1.0, 95.0, -1.0])
def test_a_level_that_is_no_share_is_refused(fit: nw.Fit, level: float) -> None:
    with pytest.raises(nw.InputError, match="between 0 and 1"):
        fit.bootstrap(50).intervals(level)
