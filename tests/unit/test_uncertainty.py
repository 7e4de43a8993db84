"""Standard errors and left-out scores against explicit refits on the rows that are left."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

import narrows as nw
from narrows.captive.tests import cuts
from narrows.identification.uncertainty import MIN_TESTS, interval_factor, jackknife, pieces_for
from tables import many_runs, short_twin

COLUMNS = list(nw.Motion().values())


def without_rows(tests: nw.CaptiveTests, out: np.ndarray) -> nw.CaptiveTests:
    """Return the tests with some rows struck out."""
    lengths = [int((~out[a:b]).sum()) for a, b in zip(tests.starts, tests.starts[1:], strict=False)]
    return nw.CaptiveTests(
        {name: column[~out] for name, column in tests.columns.items()},
        tests.names,
        np.concatenate([[0], np.cumsum(lengths)]),
        tests.setting,
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
    one = fit.moments.columns["1"]
    assert [round(sums[one, one]) for sums in fit.clusters.sums] == [int(out.sum()) for out in rows]
    said = f"by test ({len(rows)} tests)" if fit.clusters.by_test else f"by {len(rows)} consecutive stretches"
    assert said in fit.clusters.sentence


def test_covariance_is_the_jackknife_of_refits(case) -> None:
    _, fit, rows, refits = case
    best = np.array([fit.coefficients[name] for name in nw.PAPER.names])
    moved = np.array([[refit.coefficients[name] for name in nw.PAPER.names] for refit in refits]) - best
    expected = (len(rows) - 1) / len(rows) * sum(np.outer(move, move) for move in moved)
    size = np.sqrt(np.diag(expected))
    size[size == 0] = 1.0
    np.testing.assert_allclose(fit.covariance / np.outer(size, size), expected / np.outer(size, size), atol=1e-7)
    for i, name in enumerate(nw.PAPER.names):
        if fit.verdicts[name].identifiable:
            assert fit.std[name] == pytest.approx(np.sqrt(expected[i, i]), rel=1e-6, abs=1e-12)


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


def test_intervals_are_students_t_cut_at_the_bounds(case) -> None:
    _, fit, rows, _ = case
    reach = stats.t.ppf(0.975, len(rows) - 1)
    for term in nw.PAPER.terms:
        low, high = fit.intervals[term.name]
        if not fit.verdicts[term.name].identifiable:
            assert (low, high) == term.bound
            continue
        half = reach * fit.std[term.name]
        assert low == pytest.approx(max(term.bound[0], fit.coefficients[term.name] - half), rel=1e-9, abs=1e-12)
        assert high == pytest.approx(min(term.bound[1], fit.coefficients[term.name] + half), rel=1e-9, abs=1e-12)


def test_an_interval_ends_at_the_bound(kcs_fits: dict[int, nw.Fit]) -> None:
    """b_vv of the KCS sits at 0 with a standard error: its interval begins there and not below."""
    fit = kcs_fits[100]
    assert fit.coefficients["b_vv"] == 0.0
    assert fit.std["b_vv"] > 100
    assert fit.intervals["b_vv"] == (0.0, pytest.approx(stats.t.ppf(0.975, 24) * fit.std["b_vv"], rel=1e-9))


@pytest.mark.parametrize("clusters", [2, 3, 10, 25, 400])
def test_reach_of_an_interval(clusters: int) -> None:
    assert interval_factor(clusters) == pytest.approx(stats.t.ppf(0.975, clusters - 1), rel=1e-10)
    assert interval_factor(clusters, 0.5) == pytest.approx(stats.t.ppf(0.75, clusters - 1), rel=1e-10)


def test_jackknife_of_a_mean_is_the_textbook_standard_error() -> None:
    """s / sqrt(n), for which the jackknife is exact."""
    values = np.random.default_rng(2).normal(size=40)
    without = ((values.sum() - values) / 39)[:, None]
    variance = jackknife(np.array([values.mean()]), without)[0, 0]
    assert variance == pytest.approx(values.var(ddof=1) / 40, rel=1e-12)


@pytest.mark.parametrize("tests", range(1, 13))
def test_few_tests_are_cut_into_thirty_or_more(tests: int) -> None:
    assert pieces_for(tests) * tests >= 30 if tests < MIN_TESTS else pieces_for(tests) == 1


@pytest.mark.parametrize(("rows", "pieces"), [(1, 1), (1, 30), (7, 3), (30, 30), (1000, 30)])
def test_stretches_cover_every_row_once(rows: int, pieces: int) -> None:
    edges = cuts(rows, pieces)
    assert (edges[0], edges[-1], len(edges)) == (0, rows, min(rows, pieces) + 1)
    assert set(np.diff(edges)) <= {rows // pieces, rows // pieces + 1} - {0}


def test_one_row_has_no_standard_error() -> None:
    with pytest.raises(nw.InputError, match="need two or more"):
        nw.identify(without_rows(short_twin(), np.arange(short_twin().rows) > 0).where([True, False, False, False]))
