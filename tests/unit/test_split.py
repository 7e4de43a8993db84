"""The random split: seeded, the same at every pass, nothing lost, nothing twice."""

from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.captive.split import random_split
from narrows.identification.normal_equations import accumulate
from tables import frame_of, short_twin, written


def rows(part) -> np.ndarray:
    """Every row that a part yields, by a column that tells them apart."""
    return np.concatenate([block.values["Y"] for block in part.blocks(1)])


def test_parts_share_nothing_and_leave_nothing(short: nw.CaptiveTests) -> None:
    drawn, rest = random_split(short, 0.8, seed=4)
    np.testing.assert_array_equal(np.sort([*rows(drawn), *rows(rest)]), np.sort(short.columns["Y"]))
    assert len(rows(drawn)) == pytest.approx(0.8 * short.rows, rel=0.1)


def test_every_pass_and_every_block_size_draws_the_same(
    short: nw.CaptiveTests, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn, rest = random_split(short, seed=7)
    first, other = rows(drawn), rows(rest)
    np.testing.assert_array_equal(rows(drawn), first)
    for size in (1, 10, 333):
        monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", size)
        np.testing.assert_array_equal(rows(drawn), first)
        np.testing.assert_array_equal(rows(rest), other)


def test_another_seed_draws_other_rows(short: nw.CaptiveTests) -> None:
    one, other = (rows(random_split(short, seed=seed)[0]) for seed in (1, 2))
    assert set(one) != set(other)


def test_from_disk_draws_what_memory_draws(short: nw.CaptiveTests, tmp_path: Path) -> None:
    path = written(frame_of(short), tmp_path / "t.csv")
    streamed = nw.stream_captive(path, short.configuration)
    np.testing.assert_array_equal(rows(random_split(streamed, seed=3)[0]), rows(random_split(short, seed=3)[0]))


def test_fit_and_check_are_on_their_own_rows(short: nw.CaptiveTests) -> None:
    """Refit by hand on the drawn rows, checked by hand on the rest."""
    fit = nw.identify(short, balance="rows", split="random", seed=9)
    keep = np.random.default_rng(9).random(short.rows) < 0.8
    lengths = [int(keep[a:b].sum()) for a, b in zip(short.starts, short.starts[1:], strict=False)]
    drawn = nw.CaptiveTests(
        {name: column[keep] for name, column in short.columns.items()},
        short.names, np.concatenate([[0], np.cumsum(lengths)]), short.configuration,
    )  # fmt: skip
    again = nw.identify(drawn, balance="rows")
    for name in nw.PAPER.names:
        assert fit.least_squares[name] == pytest.approx(again.least_squares[name], rel=1e-9, abs=1e-12)
    motion = nw.Motion(**{name: short.columns[name][~keep] for name in nw.Motion().values()})
    for force, estimated in again.model.with_coefficients(**again.least_squares).forces(motion).items():
        error = short.columns[force][~keep] - estimated
        assert fit.left_out[force].rmse == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)
        r2 = 1 - np.mean(error**2) / short.columns[force][~keep].var()
        assert fit.left_out[force].r2 == pytest.approx(r2, rel=1e-9, abs=1e-9)
    assert fit.tests.notes == ("80% of the rows, drawn at random with seed 9",)


def test_spans_follow_the_rows_that_stay(short: nw.CaptiveTests) -> None:
    drawn, _ = random_split(short, seed=5)
    equations, _ = accumulate(drawn, nw.PAPER, 3)
    one = equations.columns["1"]
    assert round(equations.sums[:, one, one].sum()) == len(rows(drawn))
    assert set(equations.names) == set(short.names)


@pytest.mark.parametrize("size", [1, 2, 3])
def test_a_block_without_a_drawn_row_does_no_harm(size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = nw.identify(short_twin(), split="random", seed=1)
    monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", size)
    assert nw.identify(short_twin(), split="random", seed=1).coefficients == pytest.approx(whole.coefficients, rel=1e-7)


@pytest.mark.parametrize(("options", "word"), [({"seed": -1}, "seed = -1"), ({"split": "rows"}, "'rows'")])
def test_options_that_make_no_sense(short: nw.CaptiveTests, options: dict, word: str) -> None:
    with pytest.raises(nw.InputError, match=word):
        nw.identify(short, **{"split": "random", **options})


@pytest.mark.parametrize("fraction", [0.0, 1.0, 80])
def test_fraction_is_a_share(short: nw.CaptiveTests, fraction: float) -> None:
    with pytest.raises(nw.InputError, match="between 0 and 1"):
        random_split(short, fraction)
