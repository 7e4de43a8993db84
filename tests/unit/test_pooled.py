"""Tests at several depths together: hulls of their own, one bank, and whether it changes."""

import json
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.identification import estimates
from narrows.identification.estimates import DepthTest
from narrows.identification.mixed_model import integrate
from narrows.model.additions import pooled
from narrows.model.tables import table_named
from tables import frame_of, written

DEPTHS = (0.246, 0.3075, 0.41)


def made(bank: tuple[float, float], seed: int = 0) -> nw.CaptiveTests:
    """Twins at two depths: a hull that doubles, and a bank of either size."""
    dtc, parts = nw.published("mikkelsen2025_dtc"), []
    for depth, grown, b_bank in ((0.4, 1.0, bank[0]), (0.25, 2.0, bank[1])):
        runs = [nw.HarmonicRun(f"{k} {a} {depth}", k, a, p, 1.0, 2, 0.0, depth) for k, a, p in
                (("yaw", 0.9, 25.0), ("yaw", 0.5, 16.0), ("sway", 0.6, 20.0), ("sway", 0.4, 14.0))]  # fmt: skip
        runs += [nw.StraightRun(f"y {y} {depth}", y, 1.0, 20.0, 0.0, depth) for y in (-1.4, -0.8, 0.9, 1.5)]
        hull = {name: value * grown for name, value in dtc.coefficients.items() if "bank" not in name}
        parts.append(nw.twin(dtc.with_coefficients(**hull, b_bank=b_bank), runs, rate=5.0, seed=seed))
    lengths = np.concatenate([np.diff(part.starts) for part in parts])
    return nw.CaptiveTests(
        {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns},
        sum((part.names for part in parts), ()), np.concatenate([[0], np.cumsum(lengths)]), parts[0].configuration,
    )  # fmt: skip


def test_at_a_depth_of_the_tests_its_own_hull_counts_alone() -> None:
    table = pooled(nw.PAPER, DEPTHS)
    for depth in DEPTHS:
        for term in nw.PAPER.terms:
            if term.from_bank:
                continue
            values = {"u": 1.0, "v": 0.2, "r": 0.1, "udot": 0.3, "vdot": 0.4, "rdot": 0.5, "depth": depth}
            for other in DEPTHS:
                share = term.column(values) if other == depth else 0.0
                assert table[f"{term.name}@{other:g}"].column(values) == share


def test_between_depths_hulls_are_linear() -> None:
    table = pooled(nw.PAPER, DEPTHS)
    shares = [table[f"b_v@{h:g}"].column({"v": -1.0, "depth": 0.26}) for h in DEPTHS]
    assert sum(shares) == pytest.approx(1.0)
    assert shares[0] == pytest.approx((0.3075 - 0.26) / (0.3075 - 0.246))
    assert table["b_v@0.41"].column({"v": -1.0, "depth": 5.0}) == 1.0
    assert table["b_v@0.246"].column({"v": -1.0, "depth": 0.1}) == 1.0


@cache
def alike() -> nw.Fit:
    """Twins whose bank is the same at both depths, together."""
    return nw.identify(made((1.0, 1.0)), pool="depth")


@cache
def alone() -> list[nw.Fit]:
    tests = made((1.0, 1.0))
    return [nw.identify(tests.where([name.endswith(depth) for name in tests.names])) for depth in (" 0.4", " 0.25")]


def test_a_model_of_several_depths_is_kept_in_a_file(tmp_path) -> None:
    path = tmp_path / "twins.toml"
    alike().model.save(path)
    again = nw.load_model(path)
    assert again.terms.name == "paper@0.25,0.4"
    assert again.coefficients == alike().coefficients
    assert table_named("paper@0.25,0.4").names == alike().terms.names


def test_hulls_are_those_of_each_depth() -> None:
    for fit, depth in zip(alone(), (0.4, 0.25), strict=True):
        assert alike().coefficients[f"c_rdot@{depth:g}"] == pytest.approx(fit.coefficients["c_rdot"], rel=0.04)
    assert len(alike().motions) == sum(len(fit.motions) for fit in alone())


def test_hulls_of_the_kcs_are_those_of_each_depth(kcs_fits: dict[int, nw.Fit]) -> None:
    kcs = nw.identify(nw.measured_tests("kcs"), pool="depth")
    for fit, depth in zip(kcs_fits.values(), (0.41, 0.3075, 0.246), strict=True):
        assert kcs.coefficients[f"c_rdot@{depth:g}"] == pytest.approx(fit.coefficients["c_rdot"], rel=0.04)
    assert len(kcs.motions) == 36


def test_the_bank_is_better_known_by_both_depths() -> None:
    assert alike().std["b_bank"] < 0.9 * min(fit.std["b_bank"] for fit in alone())


def test_the_bank_of_the_kcs_is_better_known_by_all_depths(monkeypatch: pytest.MonkeyPatch) -> None:
    """By four times the usual points, as 128 repeat a standard error to 4 %, and the depths differ by 2 %."""
    monkeypatch.setattr(estimates, "integrate", partial(integrate, points=512))
    tests = nw.measured_tests("kcs")
    alone = [nw.identify(part).std["b_bank"] for part in tests.by_condition().values()]
    assert nw.identify(tests, pool="depth").std["b_bank"] < min(alone)


def test_whether_the_bank_changes_with_depth_is_tested() -> None:
    same, other = alike(), nw.identify(made((1.0, 2.0)), pool="depth")
    assert isinstance(same.depth_tests["b_bank"], DepthTest)
    assert not same.depth_tests["b_bank"].changes
    assert other.depth_tests["b_bank"].changes
    assert other.depth_tests["b_bank"].values[0.4] == pytest.approx(1.0, rel=0.15)
    assert other.depth_tests["b_bank"].values[0.25] == pytest.approx(2.0, rel=0.15)
    assert any("b_bank by each depth alone" in note for note in other.notes)
    assert same.verdicts["b_bank"].status == "identified"
    low, high = other.intervals["b_bank"]
    assert low < 1.5 < high  # the value at the middle of the depths


@pytest.fixture
def twins(tmp_path) -> Path:
    tests = made((1.0, 1.0))
    some = tests.where([name.startswith(("yaw 0.9", "sway 0.6", "y 0.9", "y -1.4")) for name in tests.names])
    return written(frame_of(some), tmp_path / "twins.csv")


def test_pooling_on_the_command_line(cli, ship_file, twins: Path) -> None:
    code, out, err = cli("identify", twins, "--ship", ship_file, "--pool", "depth", "--json")
    assert code in (0, 1), err
    assert "b_v@0.25" in json.loads(out)["coefficients"]


def test_pooling_by_anything_else_is_refused_on_the_command_line(cli, ship_file, twins: Path) -> None:
    code, _, err = cli("identify", twins, "--ship", ship_file, "--pool", "speed")
    assert code == 2
    assert "depth" in err


@pytest.mark.parametrize("name", ["paper@", "paper@0.3", "paper@deep,0.3", "paper@-1,0.3"])
def test_names_that_are_no_depths(name: str) -> None:
    with pytest.raises(nw.InputError, match="depths"):
        table_named(name)
