"""What is said of coefficients, against refits: bootstrap, influence, coverage."""

import numpy as np
import pytest

import narrows as nw
from narrows.captive.tests import CaptiveTests
from tables import many_runs, short_twin

NAMES = nw.PAPER.names
NOISE = nw.RunErrors(0, 0, 0)


@pytest.fixture(scope="module")
def fit() -> nw.Fit:
    return nw.identify(short_twin(5, many_runs(12)), errors=NOISE)


def repeated(tests: CaptiveTests, times: np.ndarray) -> CaptiveTests:
    """Return tests, each as often as it was drawn."""
    rows = np.concatenate(
        [np.tile(np.arange(tests.starts[i], tests.starts[i + 1]), n) for i, n in enumerate(times) if n]
    )
    names = tuple(f"{tests.names[i]}-{k}" for i, n in enumerate(times) for k in range(n))
    starts = np.concatenate([[0], np.cumsum(np.repeat(np.diff(tests.starts), times))])
    return CaptiveTests({n: c[rows] for n, c in tests.columns.items()}, names, starts, tests.configuration)


def test_a_resample_is_the_fit_to_the_tests_that_were_drawn(fit: nw.Fit) -> None:
    found = fit.bootstrap(20, seed=3)
    times = np.random.default_rng(3).multinomial(12, np.full(12, 1 / 12), size=20)
    for i in (0, 19):
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
    with pytest.raises(nw.InputError, match="no spread"):
        fit.bootstrap(1)


def test_bootstrap_and_posterior_agree(fit: nw.Fit) -> None:
    found = fit.bootstrap(4000)
    known = [i for i, n in enumerate(NAMES) if fit.verdicts[n].determined]
    assert np.median(np.array(found.std)[known] / fit.estimates.free_std[known]) == pytest.approx(1.0, abs=0.3)
    for name, (low, high) in found.intervals().items():
        assert low <= high, name
    one, two, other = (fit.bootstrap(50, seed).samples for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, two)
    assert not np.array_equal(one, other)


def test_influence_is_that_of_estimates_without_the_motion(fit: nw.Fit) -> None:
    influence = fit.influence
    assert ((influence >= 0) & (influence <= 1)).all(axis=None)
    most = {name: influence[name].idxmax() for name in influence}
    without = {  # One fit for each motion, of which some inform several coefficients
        motion: nw.identify(fit.tests.where([own != motion for own in fit.tests.names]), errors=NOISE)
        for motion in set(most.values())
    }
    for name in influence:
        rest = without[most[name]]
        if fit.verdicts[name].determined and rest.verdicts[name].determined:
            ratio = (fit.estimates.free_std / rest.estimates.free_std)[NAMES.index(name)] ** 2
            assert 1 - ratio == pytest.approx(influence[name].max(), abs=0.15), name


def test_the_one_sway_run_informs_sway() -> None:
    runs = (*(nw.HarmonicRun(f"Y{i}", "yaw", 0.3 + 0.1 * i, 14.0 + i) for i in range(4)),)
    fit = nw.identify(short_twin(1, (*runs, nw.HarmonicRun("the sway", "sway", 0.9, 20.0))))
    for name in ("b_v", "c_vv", "b_vdot"):
        assert fit.influence[name].idxmax() == "the sway"
        assert fit.influence[name].max() > 0.9


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
def test_an_estimate_lies_in_its_own_interval(terms: str, kcs_fits: dict[int, nw.Fit]) -> None:
    for paper in kcs_fits.values():
        fit = paper if terms == "paper" else nw.identify(paper.tests, terms)
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
