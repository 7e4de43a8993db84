"""Standard errors and left-out scores against dense algebra on the rows and against explicit refits."""

import numpy as np
import pytest
from scipy import linalg, stats

import narrows as nw
from narrows.captive.tests import cuts
from narrows.identification.uncertainty.error_model import covariance, lack_of_fit, pseudo_inverse
from narrows.identification.uncertainty.interval import bounded_interval, t_quantile
from tables import many_runs, short_twin

COLUMNS = list(nw.Motion().values())
SPREAD = nw.RunErrors(0.03, 0.01, 0.02)


def without_rows(tests: nw.CaptiveTests, out: np.ndarray) -> nw.CaptiveTests:
    """Return the tests with some rows struck out."""
    kept = np.array([int((~out[a:b]).sum()) for a, b in zip(tests.starts, tests.starts[1:], strict=False)])
    return nw.CaptiveTests(
        {name: column[~out] for name, column in tests.columns.items()},
        tuple(name for name, rows in zip(tests.names, kept, strict=True) if rows),
        np.concatenate([[0], np.cumsum(kept[kept > 0])]),
        tests.configuration,
    )


def repeated() -> nw.CaptiveTests:
    """Return twelve tests of nine motions: the first is made three times more, with other noise."""
    again = [nw.HarmonicRun(f"again {i}", "yaw", 0.3, 15.0, 0.7, 1) for i in range(3)]
    return short_twin(5, (*many_runs(9), *again))


@pytest.fixture(scope="module", params=["four motions", "repeats"])
def case(request: pytest.FixtureRequest) -> tuple[nw.CaptiveTests, nw.Fit, list[np.ndarray], list[nw.Fit]]:
    """Tests, their fit, the rows of each distinct motion, and refits without each."""
    tests = short_twin(5) if request.param == "four motions" else repeated()
    fit = nw.identify(tests, balance="rows", errors=SPREAD)
    test = np.repeat(tests.names, np.diff(tests.starts))
    rows = [np.isin(test, members) for members in fit.motions.members]
    return tests, fit, rows, [nw.identify(without_rows(tests, out), balance="rows") for out in rows]


def test_repeats_are_one_motion() -> None:
    fit = nw.identify(repeated())
    assert len(fit.motions) == 9
    assert fit.motions.members[0] == ("T00", "again 0", "again 1", "again 2")
    assert fit.motions.labels[0] == "T00 and 3 repeats"
    assert "9 distinct motions: 3 of the 12 tests are repeats" in fit.motions.sentence


def columns_of(tests: nw.CaptiveTests, rows: np.ndarray, terms: tuple[nw.Term, ...]) -> np.ndarray:
    values = {**tests.configuration.values(), **{name: column[rows] for name, column in tests.columns.items()}}
    return np.column_stack([np.broadcast_to(term.column(values), rows.sum()) for term in terms])


def test_the_second_level_is_least_squares_on_all_rows(case) -> None:
    """D'D and D'y of each motion and force are the sums of products over its rows."""
    tests, fit, rows, _ = case
    level, problem = fit.error_model.level, fit.problem
    if fit.error_model.held.any():
        pytest.skip("held parameters are taken out of the blocks")
    for block in range(len(level.y)):
        own = rows[level.motion[block]]
        force = "XYN"[level.force[block]]
        part = nw.PAPER.forces[force]
        slots = [problem.slot[term.name] for term in part]
        a = columns_of(tests, own, part) / problem.scale[slots]
        found = level.d[block][:, slots]
        np.testing.assert_allclose(found.T @ found, a.T @ a, atol=1e-7 * max(np.abs(a.T @ a).max(), 1e-12))
        right = a.T @ tests.columns[force][own]
        np.testing.assert_allclose(
            found.T @ level.y[block], right, rtol=1e-6, atol=1e-6 * max(np.abs(right).max(), 1e-12)
        )
        assert level.one[block] @ level.one[block] == pytest.approx(own.sum(), rel=1e-6)


def dense(fit: nw.Fit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """D, y and V of the second level as full matrices."""
    model = fit.error_model
    live = model.level.live.ravel()
    d, y = model.level.d.reshape(live.size, -1)[live], model.level.y.ravel()[live]
    return d, y, linalg.block_diag(*model.covariance)[np.ix_(live, live)]


def test_errors_are_those_of_dense_algebra(case) -> None:
    """W V W' of ordinary least squares, and the jackknife of refits with Satterthwaite's degrees of freedom."""
    _, fit, _, _ = case
    model = fit.error_model
    d, y, v = dense(fit)
    operator = np.linalg.pinv(d, rcond=1e-5)
    known = model.best.known
    np.testing.assert_allclose(
        (operator @ v @ operator.T)[np.ix_(known, known)],
        model.of_theta[np.ix_(known, known)],
        rtol=1e-4,
        atol=1e-9 * np.abs(model.of_theta).max(),
    )
    motion = np.repeat(model.level.motion, model.level.live.sum(axis=1))
    std, freedom = model.jackknife
    for slot in np.flatnonzero(known & ~model.held):
        moves = []
        for m in range(len(fit.motions)):
            kept = motion != m
            other = np.zeros_like(operator)
            other[:, kept] = np.linalg.pinv(d[kept], rcond=1e-5)
            moves.append(other[slot] - operator[slot])
        if not all(one.known[slot] for one in model.left_out):
            assert std[slot] == pytest.approx(np.sqrt(model.of_theta[slot, slot]))
            continue
        gram = np.array(moves) @ v @ np.array(moves).T
        count = len(moves)
        assert std[slot] == pytest.approx(np.sqrt((count - 1) / count * ((np.array(moves) @ y) ** 2).sum()), rel=1e-3)
        assert freedom[slot] == pytest.approx(np.trace(gram) ** 2 / (gram**2).sum(), rel=1e-3)


def test_lack_of_fit_is_that_of_generalised_least_squares(case) -> None:
    _, fit, _, _ = case
    model = fit.error_model
    v = covariance(model.level, model.level.d @ model.theta, model.errors, np.ones(3))
    live = model.level.live.ravel()
    full = linalg.block_diag(*v)[np.ix_(live, live)]
    d, y, _ = dense(fit)
    white = np.linalg.inv(np.linalg.cholesky(full))
    hat = white @ d @ np.linalg.pinv(white @ d, rcond=1e-5)
    left = white @ y - hat @ white @ y
    force = np.repeat(model.level.force, model.level.live.sum(axis=1))
    for number, found in enumerate(lack_of_fit(model.level, v)):
        own = force == number
        assert found.chi2 == pytest.approx((left[own] ** 2).sum(), rel=1e-3, abs=1e-6)
        assert found.freedom == pytest.approx(own.sum() - np.trace(hat[np.ix_(own, own)]), abs=1e-3)
        if np.isfinite(found.p):
            assert found.p == pytest.approx(stats.chi2.sf(found.chi2, found.freedom), rel=1e-2, abs=1e-9)


def test_repeats_say_what_gain_and_zero_scatter_by() -> None:
    """Runs of one motion whose gains and zeros are drawn from what is then looked for."""
    draw = np.random.default_rng(4)
    tests = nw.twin(runs=[nw.HarmonicRun(f"{i}", "yaw", 0.9, 25.0, 1.0, 2, 0.5) for i in range(60)], rate=5.0)
    columns, test = dict(tests.columns), np.repeat(np.arange(60), np.diff(tests.starts))
    size = np.sqrt(np.mean(columns["Y"] ** 2))
    columns["Y"] = (
        columns["Y"] * (1 + 0.05 * draw.standard_normal(60))[test] + 0.1 * size * draw.standard_normal(60)[test]
    )
    found = nw.identify(nw.CaptiveTests(columns, tests.names, tests.starts, tests.configuration)).error_model.repeats[
        "Y"
    ]
    assert found.zero_freedom == 59
    assert found.gain == pytest.approx(0.05, rel=0.3)
    assert found.zero == pytest.approx(0.1, rel=0.3)


def test_repeats_outvote_the_prior() -> None:
    tests = nw.twin(runs=[nw.HarmonicRun(f"{i}", "yaw", 0.9, 25.0, 1.0, 2, 0.5) for i in range(40)], rate=5.0)
    fit = nw.identify(tests, errors=nw.RunErrors(0.3, 0.3, 0.05))
    assert fit.error_model.errors.gain < 0.11
    assert fit.error_model.errors.zero < 0.11
    assert fit.error_model.errors.form == 0.05


@pytest.mark.parametrize("wrong", [{"gain": -0.1}, {"zero": 2.0}, {"form": float("nan")}, {"repeats_worth": 0.0}])
def test_run_errors_that_are_none(wrong: dict[str, float]) -> None:
    with pytest.raises(nw.InputError, match=next(iter(wrong))):
        nw.RunErrors(**wrong)


def test_an_inverse_over_what_has_data() -> None:
    columns = np.random.default_rng(1).normal(size=(9, 3)) * [1.0, 1e6, 1e-6]
    columns = np.column_stack([columns, columns[:, 0], np.zeros(9)])
    inverse, known = pseudo_inverse(columns.T @ columns)
    size = np.where(columns.any(axis=0), np.linalg.norm(columns, axis=0), 1.0)
    projection = columns / size @ np.linalg.pinv(columns / size, rcond=1e-6)
    assert known.tolist() == [False, True, True, False, False]
    np.testing.assert_allclose(columns @ inverse @ columns.T, projection, atol=1e-9)


def test_covariance_is_the_error_models(case) -> None:
    """Widened by one number for each force, so that correlations are those of the fit; at the median as the errors."""
    _, fit, _, _ = case
    slots = [fit.problem.slot[name] for name in nw.PAPER.names]
    plain = fit.error_model.of_theta[np.ix_(slots, slots)]
    known = (np.diag(plain) > 0) & ~fit.unbounded.held
    own, theirs = (
        m[np.ix_(known, known)] / np.sqrt(np.outer(np.diag(m)[known], np.diag(m)[known]))
        for m in (fit.covariance, plain)
    )
    np.testing.assert_allclose(own, theirs, atol=1e-9)
    ratio = np.sqrt(np.diag(fit.covariance))[known] / fit.unbounded.std[known]
    assert np.median(ratio) == pytest.approx(1.0, abs=0.1)
    assert np.linalg.eigvalsh(fit.covariance / np.abs(fit.covariance).max()).min() > -1e-12


def test_covariance_is_the_error_models_where_runs_do_not_differ() -> None:
    fit = nw.identify(repeated(), errors=nw.RunErrors(0, 0, 0))
    slots = [fit.problem.slot[name] for name in nw.PAPER.names]
    scale = fit.problem.scale[slots]
    plain = fit.error_model.of_theta[np.ix_(slots, slots)] / np.outer(scale, scale)
    np.testing.assert_allclose(fit.covariance, plain, rtol=1e-9, atol=1e-15 * np.abs(plain).max())


def test_one_motion_leaves_nothing_to_leave_out() -> None:
    fit = nw.identify(nw.twin(runs=[nw.HarmonicRun(name, "sway", 0.5, 15.0) for name in "AB"], rate=5.0))
    assert len(fit.motions) == 1
    assert all(np.isnan(score.rmse) for score in fit.left_out.values())
    assert any("none can be left out" in note for note in fit.notes)
    for name in ("b_vdot", "b_v", "b_bank", "c_v"):
        assert "it is the only motion" in fit.verdicts[name].reasons


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
        half = (
            stats.t.ppf(0.975, max(round(fit.unbounded.counts[i], int(fit.unbounded.counts[i] < 20)) - 1, 1))
            * fit.std[term.name]
        )
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


@pytest.mark.parametrize(("rows", "pieces"), [(1, 1), (1, 30), (7, 3), (30, 30), (1000, 30)])
def test_stretches_cover_every_row_once(rows: int, pieces: int) -> None:
    edges = cuts(rows, pieces)
    assert (edges[0], edges[-1], len(edges)) == (0, rows, min(rows, pieces) + 1)
    assert set(np.diff(edges)) <= {rows // pieces, rows // pieces + 1} - {0}


def test_one_row_has_no_standard_error() -> None:
    with pytest.raises(nw.InputError, match="need two or more"):
        nw.identify(without_rows(short_twin(), np.arange(short_twin().rows) > 0).where([True, False, False, False]))
