"""Readers: the same rows whatever the file, the unit or the layout."""

import math
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat, savemat

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.quantities import names as dimensions
from narrows.quantities.names import MOTION
from narrows.readers.cells import parse_header
from tables import frame_of, written


def same(found: nw.CaptiveTests, expected: nw.CaptiveTests) -> None:
    assert found.names == expected.names
    for name in ("y", "psi", "u", "r", "Y", "N", "cos_psi"):
        np.testing.assert_allclose(found.columns[name], expected.columns[name], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_csv_and_parquet(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path, suffix: str) -> None:
    found = nw.read_captive(written(frame_of(short), tmp_path / f"t{suffix}"), ship_file)
    same(found, short)
    assert len(found.source.sha256) == 64


@pytest.mark.parametrize("read", [nw.read_captive, lambda *paths: nw.stream_captive(*paths).names])
def test_without_the_extra_it_says_which(
    short: nw.CaptiveTests, ship_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, read
) -> None:
    path = written(frame_of(short), tmp_path / "t.parquet")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(nw.InputError, match=r"t.parquet: Parquet needs pyarrow: .*python\S* -m pip install 'pyarrow"):
        read(path, ship_file)


def test_a_structure_of_matlab_is_a_table(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path) -> None:
    frame = frame_of(short)
    columns = {name: frame[name].to_numpy() for name in frame if name not in ("test", "psi")}
    columns |= {"psi_deg": np.degrees(frame["psi"]), "test": np.array(frame["test"].tolist(), dtype=object)}
    savemat(tmp_path / "t.mat", {"tests": columns})
    same(nw.read_captive(loadmat(tmp_path / "t.mat", simplify_cells=True)["tests"], ship_file), short)


def test_units_in_headers(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path) -> None:
    frame = frame_of(short)
    frame["psi [deg]"] = np.degrees(frame.pop("psi"))
    frame["r_degps"] = np.degrees(frame.pop("r"))
    frame["y [mm]"] = frame.pop("y") * 1e3
    frame["Y [kN]"] = frame.pop("Y") / 1e3
    frame["N [kNm]"] = frame.pop("N") / 1e3
    same(nw.read_captive(written(frame, tmp_path / "t.csv"), ship_file), short)


def test_other_columns_are_passed_over_and_heave_is_assumed(
    short: nw.CaptiveTests, ship_file: Path, tmp_path: Path
) -> None:
    frame = frame_of(short).drop(columns="heave").assign(remark="fine", roll=np.nan)
    found = nw.read_captive(written(frame, tmp_path / "t.csv"), ship_file)
    same(found, short)
    assert found.notes == ("column 'heave' is absent: taken as 0",)


def test_interleaved_tests_are_put_together(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path) -> None:
    frame = frame_of(short)
    mixed = frame.iloc[np.argsort(frame["t"].to_numpy(), kind="stable")]
    found = nw.read_captive(written(mixed, tmp_path / "t.csv"), ship_file)
    assert set(found.names) == set(short.names)
    for name in short.names:
        np.testing.assert_array_equal(found.test(name)["Y"], short.test(name)["Y"])


def test_depths_make_conditions(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path) -> None:
    frame = frame_of(short)
    frame["depth"] = np.where(frame["test"].isin(short.names[:2]), 0.3, 0.2)
    found = nw.read_captive(written(frame, tmp_path / "t.csv"), ship_file).by_condition()
    assert {label: part.configuration.canal.depth for label, part in found.items()} == {"h0.3": 0.3, "h0.2": 0.2}
    assert nw.identify(found["h0.3"]).data_range.depth_to_draft == pytest.approx((0.3 / 0.163, 0.3 / 0.163))


def test_where_selects_rows(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path) -> None:
    found = nw.read_captive(written(frame_of(short), tmp_path / "t.csv"), ship_file, where="test == 'sway'")
    assert found.names == ("sway",)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_streamed_is_the_same_fit(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path, suffix: str) -> None:
    path = written(frame_of(short), tmp_path / f"t{suffix}")
    streamed, whole = nw.identify(nw.stream_captive(path, ship_file)), nw.identify(nw.read_captive(path, ship_file))
    for name in nw.PAPER.names:
        assert streamed.coefficients[name] == pytest.approx(whole.coefficients[name], rel=1e-9, abs=1e-12)


def fhr(frame: pd.DataFrame) -> pd.DataFrame:
    """Another ship's table in the layout of the SIMMAN planar-motion tests."""
    units = {"x": ("x_m", 1), "y": ("y_m", 1), "psi": ("psi_deg", 57.29577951308232), "u": ("u_mps", 1),
             "v": ("v_mps", 1), "r": ("r_degps", 57.29577951308232), "udot": ("udot_mps2", 1),
             "vdot": ("vdot_mps2", 1), "rdot": ("rdot_degps2", 57.29577951308232), "heave": ("sinkage_mm", 1e3),
             "X": ("X_N", 1), "Y": ("Y_N", 1), "N": ("N_Nm", 1)}  # fmt: skip
    table = pd.DataFrame({new: frame[old] * scale for old, (new, scale) in units.items()})
    kind = np.where(frame["test"].str.contains("sway"), "PMMY2", "PMMPSI2")
    return table.assign(env="D1", test=frame["test"], type=kind, rud_given_deg=0.0)


def test_another_ships_table_in_the_fhr_layout(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path, cli) -> None:
    frame = fhr(frame_of(short))
    swept = frame.iloc[:5].assign(rud_given_deg=20.0, Y_N=1e3)
    path = written(pd.concat([frame, swept]), tmp_path / "t.csv")
    found = nw.read_captive(path, ship_file)
    same(found, short)
    assert found.conditions == ("D1",) * len(short.names)
    code, shown, _ = cli("identify", path, "--ship", ship_file, "--json")
    assert code == 0
    assert '"b_bank"' in shown


PINT = {
    "rpm": "1/minute", "rps": "1/s", "Nm": "N*m", "kNm": "kN*m", "Nmm": "N*mm", "mps2": "m/s^2", "degps": "deg/s",
    "degps2": "deg/s^2", "radps": "rad/s", "radps2": "rad/s^2", "°": "deg",
}  # fmt: skip
"""What pint calls units that headers abbreviate; a revolution per minute is one turn, not 2 pi, a minute."""
DIMENSIONS = ("[length]", "[mass]", "[time]", "[current]", "[temperature]")


def test_units_are_those_of_pint() -> None:
    import pint

    registry = pint.UnitRegistry()
    prefixed = [prefix + names.split()[0] for prefix in dimensions.PREFIXES for names in dimensions.PREFIXED]
    words = ["kilometre", "centimeter", "millimetre", "millisecond", "kilogram", "kilonewton", "kilowatt"]
    plurals = [
        f"{word}s"
        for word in [*words, *dimensions.UNITS]
        if len(word) > 3 and word not in ("feet", "inches", "dimensionless", *PINT)
    ]
    for word in [*dimensions.BASES, *dimensions.UNITS, *prefixed, *words, *plurals]:
        one = (1 * registry(PINT.get(word, word))).to_base_units()
        scale, powers = dimensions.unit_named(word)
        assert scale == pytest.approx(one.magnitude, rel=1e-12), word
        assert powers == tuple(one.dimensionality.get(name, 0) for name in DIMENSIONS), word


DEFINED = {
    "mi": 1609.344, "miles": 1609.344, "mph": 0.44704, "nmi": 1852.0, "nautical_mile": 1852.0, "kn": 1852 / 3600,
    "ft": 0.3048, "in": 0.0254, "yd": 0.9144, "lb": 0.45359237, "kgf": 9.80665, "lbf": 4.4482216152605,
    "psi": 6894.757293168, "hp": 745.6998715822702, "°": 0.017453292519943295, "bar": 1e5, "t": 1000.0,
}  # fmt: skip
"""SI units of one: NIST Special Publication 811, appendix B.8, and the statute mile of 5280 feet of 1959."""


@pytest.mark.parametrize("word", DEFINED)
def test_units_are_as_they_are_defined(word: str) -> None:
    assert dimensions.unit_named(word).scale == pytest.approx(DEFINED[word], rel=1e-12)


COMPOUNDS = {
    "m/s2": (1.0, (1, 0, -2, 0, 0)), "kg m2": (1.0, (2, 1, 0, 0, 0)), "kN·m": (1e3, (2, 1, -2, 0, 0)),
    "m s^-1": (1.0, (1, 0, -1, 0, 0)), "m*s**-1": (1.0, (1, 0, -1, 0, 0)), "mm/s/s": (1e-3, (1, 0, -2, 0, 0)),
    "°/min": (math.pi / 10800, (0, 0, -1, 0, 0)), "kg/m³": (1.0, (-3, 1, 0, 0, 0)), "1/min": (1 / 60, (0, 0, -1, 0, 0)),
    "10 mm": (0.01, (1, 0, 0, 0, 0)), "ft/s^2": (0.3048, (1, 0, -2, 0, 0)),
}  # fmt: skip


@pytest.mark.parametrize("text", COMPOUNDS)
def test_products_and_powers_of_units(text: str) -> None:
    scale, powers = dimensions.unit_named(text)
    assert (scale, powers) == (pytest.approx(COMPOUNDS[text][0], rel=1e-14), COMPOUNDS[text][1])


@pytest.mark.parametrize("text", ["", "-", "m//s", "1e999", "0", "m^", "^2", "*m", "n/a", "furlong/fortnight"])
def test_what_is_no_unit_or_a_rare_one(text: str) -> None:
    assert dimensions.unit_named(text) is None


def test_a_rare_unit_is_refused() -> None:
    with pytest.raises(nw.InputError, match=r"unknown unit \[furlong/hour\]; give it in \[m/s\]"):
        parse_header("u [furlong/hour]", MOTION)


def test_a_table_with_the_particulars_as_columns_needs_no_ship(
    kcs_tests: dict[int, nw.CaptiveTests], tmp_path: Path
) -> None:
    tests = kcs_tests[100]
    tests.to_csv(tmp_path / "t.csv")
    again = nw.read_captive(tmp_path / "t.csv")
    assert again.configuration == tests.configuration
    assert again.headers.unread == ()
    same(again, tests)
    with pytest.raises(nw.InputError, match="or columns with length, beam, draft"):
        nw.read_captive(pd.read_csv(tmp_path / "t.csv").drop(columns="beam"))
    pd.read_csv(tmp_path / "t.csv").assign(length=-1.0).to_csv(tmp_path / "t.csv", index=False)
    with pytest.raises(nw.InputError, match=r"t.csv: .*length"):
        nw.read_captive(tmp_path / "t.csv")


SAILING = "type in ('PMMY2', 'PMMPSI2', 'STATX0') and u_mps > 0.2"


def test_kinds_of_motion_are_those_that_the_laboratory_gave_its_tests() -> None:
    table, ship = measured_files("kcs")
    raw = pd.read_csv(table).query(SAILING).groupby("test").agg({"type": "first", "drift_deg": "mean"})
    drifts, words = raw["drift_deg"].abs() > 0.9, {"PMMY2": "pure sway", "PMMPSI2": "pure yaw", "STATX0": "straight"}
    with_drift = {"PMMY2": "sway with drift", "PMMPSI2": "yaw with drift", "STATX0": "drift"}
    expected = raw["type"].map(words).where(~drifts, raw["type"].map(with_drift)).dropna()
    tests = nw.read_captive(table, ship, where=SAILING)
    found = pd.Series(tests.kinds, tests.names)[expected.index]
    assert set(found) >= {"pure sway", "pure yaw", "yaw with drift", "straight", "drift"}
    assert found[found != expected].to_dict() == {}
    assert tests.query(kind="pure yaw").rows < tests.query(kind="yaw").rows
    assert set(tests.query("u < 0.55", kind="yaw").kinds) == {"pure yaw", "yaw with drift"}


def test_a_low_pass_leaves_slow_forces_and_takes_fast_ones_away() -> None:
    """A force that swings in 25 s stays within two thousandths, with its kinks; one of 4 Hz goes."""
    tests = nw.twin(noise={}, rate=20.0, runs=[nw.HarmonicRun("A", "sway", 0.9, 25.0)])
    fast = 20.0 * np.sin(2 * np.pi * 4.0 * tests["t"])
    filtered = replace(tests, columns={**tests.columns, "Y": tests["Y"] + fast}).lowpass(1.0)
    inner = (tests["t"] > 5.0) & (tests["t"] < tests["t"].max() - 5.0)
    np.testing.assert_allclose(filtered["Y"][inner], tests["Y"][inner], atol=2e-3 * np.abs(tests["Y"]).max())
    assert "nothing faster than 1 Hz" in filtered.notes[-1]
    same(tests.query(cutoff=11.0), tests)  # half the sampling rate is less
    with pytest.raises(nw.InputError, match="cutoff = 0 is no frequency"):
        tests.lowpass(0)
    with pytest.raises(nw.InputError, match="these tests have no times"):
        replace(tests, columns={name: column for name, column in tests.columns.items() if name not in "tx"}).lowpass(1)


def test_the_noise_of_a_twin_may_be_a_share_of_its_forces() -> None:
    quiet, noisy = (nw.twin(noise=noise, rate=20.0, seed=3) for noise in (0.0, 0.05))
    for rows in (slice(*ends) for ends in pairwise(quiet.starts)):
        for force in ("X", "Y", "N"):
            size = float(np.sqrt(np.mean(quiet[force][rows] ** 2)))
            assert (noisy[force] - quiet[force])[rows].std() == pytest.approx(0.05 * size, rel=0.15)


def test_a_table_of_one_ship_is_not_read_for_another(kcs_tests: dict[int, nw.CaptiveTests], tmp_path: Path) -> None:
    kcs_tests[100].to_csv(tmp_path / "t.csv")
    assert nw.read_captive(tmp_path / "t.csv", kcs_tests[100].configuration).rows == kcs_tests[100].rows
    with pytest.raises(nw.InputError, match=r"the ship in its columns is 4.367 m long, the ship that is given 230 m"):
        nw.read_captive(tmp_path / "t.csv", nw.published("estimated_kcs"))
