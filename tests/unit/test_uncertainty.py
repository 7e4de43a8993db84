"""Standard errors and left-out scores against explicit refits on the rows that are left."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

import narrows as nw
from narrows.captive.tests import cuts
from narrows.identification.uncertainty.clusters import MIN_TESTS, jackknife, pieces_for
from narrows.identification.uncertainty.interval import bounded_interval, t_quantile
from tables import many_runs, short_twin

COLUMNS = list(nw.Motion().values())


def without_rows(tests: nw.CaptiveTests, out: np.ndarray) -> nw.CaptiveTests:
    """Return the tests with some rows struck out."""
    lengths = [int((~out[a:b]).sum()) for a, b in zip(tests.starts, tests.starts[1:], strict=False)]
    return nw.CaptiveTests(
        {name: column[~out] for name, column in tests.columns.items()},
        tests.names,
        np.concatenate([[0], np.cumsum(lengths)]),
        tests.configuration,
    )


def clusters_of_rows(tests: nw.CaptiveTests) -> list[np.ndarray]:
    """Which rows each cluster holds: a test, or about 30 / tests stretches of each."""
    pieces = 1 if len(tests.names) >= 10 else -(-30 // len(tests.names))
    found = []
    for start, stop in zip(tests.starts, tests.starts[1:], strict=False):
        edges = start + np.floor(np.arange(pieces + 1) * (stop - start) / pieces).astype(int)
        for a, b in pairwise(edges):
            found.append((np.arange(tests.rows) >= a) & (np.arange(tests.rows) < b))
    return found


@pytest.fixture(scope="module", params=[4, 12], ids=["stretches", "tests"])
def case(request: pytest.FixtureRequest) -> tuple[nw.CaptiveTests, nw.Fit, list[np.ndarray], list[nw.Fit]]:
    tests = short_twin(5) if request.param == 4 else short_twin(5, many_runs(request.param))
    rows = clusters_of_rows(tests)
    return tests, nw.identify(tests), rows, [nw.identify(without_rows(tests, out)) for out in rows]


def test_clusters(case) -> None:
    tests, fit, rows, _ = case
    assert len(fit.clusters.labels) == len(rows)
    assert fit.clusters.by_test == (len(tests.names) >= MIN_TESTS)
    one = fit.normal_equations.columns["1"]
    assert [round(sums[one, one]) for sums in fit.clusters.sums] == [int(out.sum()) for out in rows]
    said = f"by test ({len(rows)} tests)" if fit.clusters.by_test else f"by {len(rows)} consecutive stretches"
    assert said in fit.clusters.sentence


def unbounded() -> nw.TermTable:
    """The paper's terms with every bound let go."""
    free = {force: [replace(term, bound=nw.FREE) for term in own] for force, own in nw.PAPER.forces.items()}
    return nw.PAPER.with_terms("unbounded", free["X"], free["Y"], free["N"])


def excess_of(tests: nw.CaptiveTests, rows: list[np.ndarray]) -> np.ndarray:
    """By how much independent errors of one size make the jackknife variance of each coefficient too large."""
    values = {**tests.configuration.values(), **tests.columns}
    names = [name for name in nw.PAPER.names if name != "c_vdot"]
    blocks = []
    for own in nw.PAPER.forces.values():
        block = np.zeros((tests.rows, len(names)))
        for term in own:
            block[:, names.index({"c_vdot": "b_rdot"}.get(term.name, term.name))] += term.column(values)
        blocks.append(block)
    live = [i for i in range(len(names)) if any(block[:, i].any() for block in blocks)]
    scale = np.sqrt(sum((block[:, live] ** 2).sum(axis=0) for block in blocks))

    def variances(kept: np.ndarray) -> np.ndarray:
        gram = sum((block[kept][:, live] / scale).T @ (block[kept][:, live] / scale) for block in blocks)
        return np.diag(np.linalg.inv(gram))

    whole = variances(np.ones(tests.rows, bool))
    grown = np.array([variances(~out) / whole - 1 for out in rows])
    found = dict.fromkeys(nw.PAPER.names, 1.0)
    for i, own in enumerate(live):
        if (grown[:, i] < 9).all():
            found[names[own]] = (1 - 1 / len(rows)) * grown[:, i].sum()
    found["c_vdot"] = found["b_rdot"]
    return np.array([found[name] for name in nw.PAPER.names])


def test_standard_errors_are_the_corrected_jackknife_of_refits_without_bounds(case) -> None:
    tests, fit, rows, _ = case
    table = unbounded()
    best = nw.identify(tests, table).coefficients
    moved = [
        [refit.coefficients[name] - best[name] for name in nw.PAPER.names]
        for refit in (nw.identify(without_rows(tests, out), table) for out in rows)
    ]
    variance = (len(rows) - 1) / len(rows) * (np.array(moved) ** 2).sum(axis=0) / excess_of(tests, rows)
    told = 0
    for i, name in enumerate(nw.PAPER.names):
        if fit.verdicts[name].determined and not fit.unbounded.few[i] and not fit.unbounded.held.any():
            assert fit.std[name] == pytest.approx(np.sqrt(variance[i]), rel=1e-4)
            told += 1
    assert told > 10


def test_covariance_has_the_standard_errors(case) -> None:
    _, fit, _, _ = case
    known = ~fit.unbounded.held
    np.testing.assert_allclose(np.sqrt(np.diag(fit.covariance))[known], fit.unbounded.std[known], rtol=1e-9)
    assert np.linalg.eigvalsh(fit.covariance / np.abs(fit.covariance).max()).min() > -1e-12


@pytest.mark.parametrize("force", ["X", "Y", "N"])
def test_left_out_scores_are_those_of_refits(case, force: str) -> None:
    tests, fit, rows, refits = case
    error = 0.0
    for out, refit in zip(rows, refits, strict=True):
        motion = nw.Motion(**{name: tests.columns[name][out] for name in COLUMNS})
        error += ((tests.columns[force][out] - refit.model.forces(motion)[force]) ** 2).sum()
    assert fit.left_out[force].rmse == pytest.approx(np.sqrt(error / tests.rows), rel=1e-7)
    spread = tests.rows * tests.columns[force].var()
    assert fit.left_out[force].r2 == pytest.approx(1 - error / spread, rel=1e-7, abs=1e-9)


def test_intervals_are_students_t_away_from_the_bounds(case) -> None:
    _, fit, _, _ = case
    for i, term in enumerate(nw.PAPER.terms):
        low, high = fit.intervals[term.name]
        if not fit.verdicts[term.name].determined:
            assert (low, high) == term.bound
            continue
        half = stats.t.ppf(0.975, max(round(fit.unbounded.counts[i], 1) - 1, 1)) * fit.std[term.name]
        if fit.unbounded.values[i] - 2 * half > term.bound[0]:
            assert low == pytest.approx(fit.unbounded.values[i] - half, rel=1e-9)
            assert high == pytest.approx(fit.unbounded.values[i] + half, rel=1e-9)
        assert term.bound[0] <= low <= fit.coefficients[term.name] + 1e-9 * abs(low) or term.name in fit.at_bound


def test_an_interval_starts_at_the_bound(kcs_fits: dict[int, nw.Fit]) -> None:
    """b_vv of the KCS sits at 0: its interval begins there and not below, and is not empty."""
    fit = kcs_fits[100]
    assert fit.coefficients["b_vv"] == 0.0
    low, high = fit.intervals["b_vv"]
    assert low == 0.0
    assert 100 < high < 1500


@pytest.mark.parametrize("clusters", [2, 3, 10, 25, 400])
def test_reach_of_an_interval(clusters: int) -> None:
    assert t_quantile(clusters) == pytest.approx(stats.t.ppf(0.975, clusters - 1), rel=1e-10)
    assert t_quantile(clusters, 0.5) == pytest.approx(stats.t.ppf(0.75, clusters - 1), rel=1e-10)


@pytest.mark.parametrize(
    ("seen", "low", "high"),
    [(-3.0, 0.0, 0.42), (-1.0, 0.0, 1.10), (0.0, 0.0, 1.96), (1.0, 0.0, 2.96), (2.0, 0.35, 3.96), (3.0, 1.14, 4.96)],
)
def test_bounded_interval_is_that_of_feldman_and_cousins(seen: float, low: float, high: float) -> None:
    """Their table for the mean of a Gaussian that is not negative, 95 %, to its two decimals."""
    found = bounded_interval(seen, 1.0, (0.0, np.inf), 1e6)
    assert found == (pytest.approx(low, abs=0.006), pytest.approx(high, abs=0.006))
    mirrored = bounded_interval(-seen, 1.0, (-np.inf, 0.0), 1e6)
    assert mirrored == (pytest.approx(-found[1]), pytest.approx(-found[0]))


@pytest.mark.parametrize("truth", [0.0, 0.3, 1.0, 1.7, 2.5, 6.0])
@pytest.mark.parametrize("clusters", [4, 20, 1000])
def test_bounded_interval_covers_wherever_the_truth_is(truth: float, clusters: int) -> None:
    draw = np.random.default_rng(7)
    seen = truth + draw.standard_normal(2000)
    std = np.sqrt(draw.chisquare(clusters - 1, 2000) / (clusters - 1))
    pairs = (bounded_interval(a, b, (0.0, np.inf), clusters) for a, b in zip(seen, std, strict=True))
    assert np.mean([low <= truth <= high for low, high in pairs]) == pytest.approx(0.95, abs=0.02)


def test_jackknife_of_a_mean_is_the_textbook_standard_error() -> None:
    """s / sqrt(n), for which the jackknife is exact."""
    values = np.random.default_rng(2).normal(size=40)
    without = ((values.sum() - values) / 39)[:, None]
    variance = jackknife(np.array([values.mean()]), without)[0, 0]
    assert variance == pytest.approx(values.var(ddof=1) / 40, rel=1e-12)


@pytest.mark.parametrize("tests", range(1, 13))
def test_tests_are_cut_into_thirty_or_more(tests: int) -> None:
    assert pieces_for(tests) * tests >= 30
    assert pieces_for(tests) >= 3


@pytest.mark.parametrize(("rows", "pieces"), [(1, 1), (1, 30), (7, 3), (30, 30), (1000, 30)])
def test_stretches_cover_every_row_once(rows: int, pieces: int) -> None:
    edges = cuts(rows, pieces)
    assert (edges[0], edges[-1], len(edges)) == (0, rows, min(rows, pieces) + 1)
    assert set(np.diff(edges)) <= {rows // pieces, rows // pieces + 1} - {0}


def test_one_row_has_no_standard_error() -> None:
    with pytest.raises(nw.InputError, match="need two or more"):
        nw.identify(without_rows(short_twin(), np.arange(short_twin().rows) > 0).where([True, False, False, False]))
