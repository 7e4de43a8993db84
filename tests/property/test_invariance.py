"""What identification must not depend on: the order of tests, the size of blocks, where rows live, a column's unit."""

import itertools
from functools import cache, wraps
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import narrows as nw
from narrows.identification.normal_equations import accumulate
from nightly import draws
from tables import SHORT_RUNS, frame_of, many_runs, short_twin, written

BLOCKS = st.sampled_from([1, 7, 64, 100, 444, 445, 1000])


def assert_same(one: nw.Fit, other: nw.Fit, rel: float = 1e-7) -> None:
    """Compare to the rounding that sums of products leave, in standard errors where there are some."""
    for name in one.terms.names:
        size = one.std[name] if one.std[name] > 0 else max(abs(one.coefficients[name]), 1.0)
        assert other.coefficients[name] == pytest.approx(one.coefficients[name], abs=rel * size)
        assert other.std[name] == pytest.approx(one.std[name], rel=1e-3, nan_ok=True)
        assert other.verdicts[name].status == one.verdicts[name].status
    for force, own in one.scores.items():
        assert other.scores[force] == pytest.approx(own, rel=rel)
        assert other.left_out[force] == pytest.approx(one.left_out[force], rel=rel)
    for name in ("speed", "abs_y", "abs_psi", "abs_r", "depth_to_draft"):
        assert getattr(other.data_range, name) == getattr(one.data_range, name)


@cache
def short_fit() -> nw.Fit:
    return nw.identify(short_twin())


def reordered(tests: nw.CaptiveTests, order: tuple[int, ...]) -> nw.CaptiveTests:
    parts = [tests.where([i == k for i in range(len(tests.names))]) for k in order]
    return nw.CaptiveTests(
        {name: np.concatenate([part.columns[name] for part in parts]) for name in tests.columns},
        tuple(part.names[0] for part in parts),
        np.concatenate([[0], np.cumsum([part.rows for part in parts])]),
        tests.configuration,
    )


@given(order=st.permutations(range(len(SHORT_RUNS))))
@settings(max_examples=draws(2))
def test_order_of_tests(order: list[int]) -> None:
    assert_same(short_fit(), nw.identify(reordered(short_twin(), tuple(order))))


@given(rows=BLOCKS)
@settings(max_examples=draws(2))
def test_size_of_blocks(rows: int) -> None:
    whole = short_fit()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("narrows.captive.tests.BLOCK_ROWS", rows)
        assert_same(whole, nw.identify(short_twin()))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("rows", [13, 100, 32_000])
@pytest.mark.parametrize("runs", [SHORT_RUNS, many_runs()], ids=["few tests", "many tests"])
def test_streamed_is_in_memory(
    runs: tuple[nw.HarmonicRun, ...], rows: int, suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tests = short_twin(1, runs)
    path = written(frame_of(tests), tmp_path / f"t{suffix}")
    monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", rows)
    whole, streamed = nw.read_captive(path, tests.configuration), nw.stream_captive(path, tests.configuration)
    one, other = nw.identify(whole), nw.identify(streamed)
    assert_same(one, other)
    assert other.motions.labels == one.motions.labels
    found = other.shapley()
    for force, shares in one.shapley().items():
        assert found[force] == pytest.approx(shares, rel=1e-7, abs=1e-12)


def test_table_in_memory_or_from_disk(short: nw.CaptiveTests, tmp_path: Path) -> None:
    """CSV and Parquet keep every bit of a double."""
    for suffix in (".csv", ".parquet"):
        again = nw.read_captive(written(frame_of(short), tmp_path / f"t{suffix}"), short.configuration)
        assert again.names == short.names
        np.testing.assert_array_equal(again.starts, short.starts)
        for name, column in short.columns.items():
            np.testing.assert_array_equal(again.columns[name], column)


@cache
def in_unit(name: str, of: float) -> tuple[str, nw.Fit]:
    """The force of a term, and the fit with its regressor times a factor."""
    term, untied = nw.PAPER[name], nw.TermTable("untied", nw.PAPER.surge, nw.PAPER.sway, nw.PAPER.yaw)

    @wraps(term.regressor)
    def rescaled(*values: float) -> float:
        return of * term.regressor(*values)

    force = next(force for force, terms in untied.forces.items() if term in terms)
    place = {"X": "surge", "Y": "sway", "N": "yaw"}[force]
    own = nw.Term(name, term.symbol, rescaled, term.dimension, term.bound)
    return force, nw.identify(short_twin(), untied.with_terms("rescaled", **{place: [own]}))


@given(factor=st.sampled_from([1e-9, 1e-4, 10.0, 1e6]), name=st.sampled_from(["b_v", "b_rr", "c_vdot", "c_rr", "a_uu"]))
@settings(max_examples=draws(2))
def test_unit_of_a_column(factor: float, name: str) -> None:
    """A regressor in another unit gives its coefficient in the inverse unit and changes nothing else."""
    (force, one), (_, other) = in_unit(name, 1.0), in_unit(name, factor)
    for coefficient in one.terms.names:
        unit = factor if coefficient == name else 1.0
        assert other.least_squares[coefficient] * unit == pytest.approx(one.least_squares[coefficient], rel=1e-6)
        std = one.std[coefficient]
        assert other.std[coefficient] * unit == pytest.approx(std, rel=1e-3, nan_ok=True)
        if std > 0:  # The value of one that is not excited is the prior's, in the unit of its empty column.
            assert other.coefficients[coefficient] * unit == pytest.approx(
                one.coefficients[coefficient], abs=1e-3 * std
            )
        assert other.verdicts[coefficient].status == one.verdicts[coefficient].status
    assert other.shapley()[force] == pytest.approx(one.shapley()[force], rel=1e-3, abs=1e-12)


@given(factor=st.sampled_from([1e-8, 1e-3, 1e5]))
@settings(max_examples=draws(3))
def test_unit_of_one_of_two_dependent_columns(factor: float) -> None:
    """At one speed a_u and a_uu are one column; that must show whatever unit either is in."""

    def slow(u: float) -> float:
        return -u * factor

    table = nw.PAPER.with_terms("slow", surge=[nw.Term("a_u", "a_u", slow, nw.Dimension(), nw.NONNEGATIVE)])
    fit = nw.identify(short_twin(runs=SHORT_RUNS[1:2]), table)
    for name in ("a_u", "a_uu"):
        assert not fit.verdicts[name].determined
        assert np.isnan(fit.std[name])
        assert "a_u and a_uu only in combination" in fit.verdicts[name].reasons[0]


@given(seed=st.integers(0, 1000))
@settings(max_examples=8)
def test_score_from_sums_is_score_from_rows(seed: int) -> None:
    from narrows.identification.normal_equations import score

    tests = short_twin(seed)
    draw = np.random.default_rng(seed)
    coefficients = {name: float(draw.normal()) * 100 for name in nw.PAPER.names}
    equations, _ = accumulate(tests, nw.PAPER)
    predicted = nw.Model(tests.configuration, nw.PAPER, coefficients).forces(
        nw.Motion(**{name: tests.columns[name] for name in nw.Motion().values()})
    )
    for force, own in score(equations, equations.total, nw.PAPER, coefficients).items():
        error = tests.columns[force] - predicted[force]
        assert own.rmse == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)
        assert own.r2 == pytest.approx(1 - np.mean(error**2) / np.var(tests.columns[force]), rel=1e-9, abs=1e-9)


def test_scores_do_not_depend_on_pieces(short: nw.CaptiveTests) -> None:
    sums = [accumulate(short, nw.PAPER, pieces)[0].total for pieces in (1, 3, 10)]
    for one, other in itertools.pairwise(sums):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-9)
