"""Known layouts, each by its own headers, and what the readers make of odd files."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.captive.measured import measured_files
from tables import frame_of, short_twin, written

KCS_TABLE, KCS_SHIP = measured_files("kcs")


@pytest.fixture(scope="module")
def raw() -> pd.DataFrame:
    """The KCS table as pandas reads it, without our reader."""
    return pd.read_csv(KCS_TABLE)


def test_fhr_keeps_harmonic_rows_with_the_rudder_amidships(raw: pd.DataFrame) -> None:
    kept = raw[raw.type.isin(["PMMY2", "PMMPSI2"]) & (raw.rud_given_deg.abs() < 1)]
    tests = nw.measured_tests("kcs")
    assert tests.rows == len(kept) == 1560
    assert tests.notes == ("1560 of 2711 rows read: harmonic sway and yaw with the rudder amidships",)
    order = np.argsort(pd.factorize(kept.test)[0], kind="stable")
    for name, header, scale in (
        ("y", "y_m", 1.0), ("psi", "psi_deg", np.pi / 180), ("r", "r_degps", np.pi / 180), ("u", "u_mps", 1.0),
        ("rdot", "rdot_degps2", np.pi / 180), ("heave", "sinkage_mm", 1e-3), ("Y", "Y_N", 1.0), ("N", "N_Nm", 1.0),
    ):  # fmt: skip
        np.testing.assert_allclose(tests.columns[name], kept[header].to_numpy()[order] * scale, rtol=1e-12, atol=1e-15)


def test_fhr_selection_that_speaks_of_the_type_is_the_users(raw: pd.DataFrame) -> None:
    where = "type == 'STATX0' and abs(psi_deg) < 80 and abs(y_m) < 1 and u_mps > 0.2"
    tests = nw.read_captive(KCS_TABLE, KCS_SHIP, where=where)
    assert tests.rows == len(raw.query(where)) > 0
    assert len(tests.notes) == 1
    assert "its sign turned" in tests.notes[0]


def test_fhr_selection_of_something_else_keeps_to_harmonic_rows(raw: pd.DataFrame) -> None:
    tests = nw.read_captive(KCS_TABLE, KCS_SHIP, where="u_mps > 0.5")
    harmonic = raw.type.isin(["PMMY2", "PMMPSI2"]) & (raw.rud_given_deg.abs() < 1)
    assert tests.rows == int((harmonic & (raw.u_mps > 0.5)).sum())


def test_fhr_depths_come_from_the_ship_file(kcs_tests: dict[int, nw.CaptiveTests]) -> None:
    depths = {clearance: tests.configuration.canal.depth for clearance, tests in kcs_tests.items()}
    assert depths == {100: 0.41, 50: 0.3075, 20: 0.246}
    for clearance, depth in depths.items():
        assert depth / 0.2051 - 1 == pytest.approx(clearance / 100, abs=0.003)


def test_fhr_text_in_the_rudder_is_named(raw: pd.DataFrame, tmp_path: Path) -> None:
    spoilt = raw.astype({"rud_given_deg": object})
    spoilt.loc[4, "rud_given_deg"] = "hard over"
    with pytest.raises(nw.InputError, match=r"t.csv: row 6, column 'rud_given_deg' holds hard over"):
        nw.read_captive(written(spoilt, tmp_path / "t.csv"), KCS_SHIP)


def test_lataire_tests_without_a_propeller_are_read(tmp_path: Path) -> None:
    raw = pd.read_csv(measured_files("lataire2009")[0])
    towed = written(raw.drop(columns="propeller rate"), tmp_path / "towed.csv")
    assert "revolutions" not in nw.read_captive(towed, KCS_SHIP).columns
    astern = written(raw.assign(**{"propeller rate": -300.0}), tmp_path / "astern.csv")
    np.testing.assert_allclose(nw.read_captive(astern, KCS_SHIP).columns["revolutions"], -5.0)


def test_lataire_columns_are_those_of_the_table() -> None:
    raw = pd.read_csv(measured_files("lataire2009")[0])
    assert list(raw.psi[raw.psi.abs() >= 90]) == [180.0]
    ahead = raw[raw.psi.abs() < 90]
    tests = nw.measured_tests("lataire2009")
    for name, header in (
        ("u", "forward component of speed vector"), ("X", "longitudinal force"),
        ("v", "transversal component of speed vector"), ("Y", "transversal force"), ("N", "yaw moment"),
        ("draft", "draught"), ("depth", "water depth"),
    ):  # fmt: skip
        np.testing.assert_allclose(tests.columns[name], ahead[header], rtol=1e-12)
    expected = np.array([0, 538, 0, 540, 0, 719, 0, 359, 539]) / 60  # -1 stands for stopped
    np.testing.assert_allclose(tests.columns["revolutions"], expected)
    y = ahead["lateral position"].to_numpy()
    to_port, to_starboard = (
        tests.columns["width"] / 2 + tests.columns["y"],
        tests.columns["width"] / 2 - tests.columns["y"],
    )
    np.testing.assert_allclose(to_port, 3.5 + y, rtol=1e-12, err_msg="the port wall is the tank's")
    toe = np.where(ahead["bank name"] == "I", 2.83, np.where(ahead["bank name"] == "VII", 2.23, 0.53))
    assert (to_starboard >= toe - y - 1e-12).all(), "an equivalent wall is not nearer than the toe"
    vertical = (ahead["bank name"] == "I").to_numpy()
    np.testing.assert_allclose(to_starboard[vertical], 2.83 - y[vertical], rtol=1e-12)
    assert tests.notes[0] == "1 of 10 tests left out: sailed backwards"
    for name in ("r", "udot", "vdot", "rdot"):
        assert not tests.columns[name].any()


def record(rows: int = 400, rate: float = 20.0) -> pd.DataFrame:
    """A raw record in the DTC layout: a ramp in speed on a slant, nothing else given."""
    t = np.arange(1, rows + 1) / rate
    way = 0.05 * t**2
    return pd.DataFrame(
        {"time": t, "x0": way * np.cos(0.1), "y0": way * np.sin(0.1), "psi": np.full(rows, np.degrees(0.1)),
         "u": 0.1 * t, "heave": 2.0 + 0 * t, "trim": 0 * t, "X": -300 * 0.1 - 7 * t, "Y": 0 * t, "N": 0 * t}
    )  # fmt: skip


def dat(frame: pd.DataFrame, path: Path) -> Path:
    units = {"time": "s", "x0": "m", "y0": "m", "psi": "°", "u": "m/s", "heave": "mm", "trim": "mm/m", "X": "N",
             "Y": "N", "N": "Nm"}  # fmt: skip
    head = "\t".join(f"{name} " for name in frame) + "\n" + "\t".join(f"{units[name]} " for name in frame) + "\n"
    path.write_text(head + frame.to_csv(sep="\t", header=False, index=False), encoding="latin-1")
    return path


def test_dtc_rates_come_from_positions(ship_file: Path, tmp_path: Path) -> None:
    tests = nw.read_captive(dat(record(), tmp_path / "c.dat"), ship_file)
    t, inside = tests.columns["t"], slice(60, -60)
    np.testing.assert_allclose(tests.columns["u"][inside], 0.1 * t[inside], atol=1e-3)
    np.testing.assert_allclose(tests.columns["udot"][inside], 0.1, atol=2e-3)
    # Where the record breaks off at speed a short run-out of the filter would make 2 m/s2 of nothing.
    np.testing.assert_allclose(tests.columns["u"], 0.1 * t, atol=0.03)
    np.testing.assert_allclose(tests.columns["udot"], 0.1, atol=0.1)
    for name in ("v", "vdot", "r", "rdot"):
        np.testing.assert_allclose(tests.columns[name], 0.0, atol=1e-9)
    np.testing.assert_allclose(tests.columns["heave"], 2e-3)
    assert tests.notes[0] == "velocities and accelerations from positions low-passed at 0.5 Hz"


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (lambda f: f.iloc[:10], "10 rows are too few to low-pass"),
        (lambda f: f.drop(index=50), "time steps vary from"),
        (lambda f: f.assign(time=f.time.where(f.index != 7, f.time[6])), "time steps vary from"),
        (lambda f: f.assign(x0=f.x0.where(f.index != 7)), "row 10, column 'x0 [m]' is empty"),
        (lambda f: f.assign(y0=f.y0.astype(object).where(f.index != 2, "lost")), "row 5, column 'y0 [m]' holds lost"),
    ],
)
def test_dtc_records_that_cannot_be_differentiated(spoil, sentence: str, ship_file: Path, tmp_path: Path) -> None:
    with pytest.raises(nw.InputError) as error:
        nw.read_captive(dat(spoil(record()), tmp_path / "c.dat"), ship_file)
    assert str(error.value).startswith(str(tmp_path / "c.dat"))
    assert sentence in str(error.value)


def test_a_column_that_pandas_keeps_as_index_is_a_column(
    short: nw.CaptiveTests, ship_file: Path, tmp_path: Path
) -> None:
    frame_of(short).set_index("test").to_parquet(tmp_path / "t.parquet")
    assert nw.read_captive(tmp_path / "t.parquet", ship_file).names == short.names
    assert nw.stream_captive(tmp_path / "t.parquet", ship_file).names == short.names


def test_without_names_all_rows_are_one_test_and_that_is_said(ship_file: Path, tmp_path: Path) -> None:
    one = short_twin().where([True, False, False, False])
    tests = nw.read_captive(written(frame_of(one).drop(columns="test"), tmp_path / "t.csv"), ship_file)
    assert tests.names == ("all",)
    assert tests.notes == ("column 'test' is absent: all rows are taken as one test",)


def test_columns_that_change_from_row_to_row_override_the_ship_file(
    short: nw.CaptiveTests, ship_file: Path, tmp_path: Path
) -> None:
    """Twice the draft doubles the bank's regressor, so that the coefficient halves."""
    bank = nw.TermTable("bank", (), (nw.PAPER["b_bank"],), ())
    frame = frame_of(short)
    plain = nw.identify(nw.read_captive(written(frame, tmp_path / "a.csv"), ship_file), bank)
    deep = written(frame.assign(**{"draft [mm]": 326.0}), tmp_path / "b.csv")
    other = nw.identify(nw.read_captive(deep, ship_file), bank)
    assert other.least_squares["b_bank"] == pytest.approx(plain.least_squares["b_bank"] / 2, rel=1e-9)


def test_names_of_tests_may_be_numbers(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path) -> None:
    frame = frame_of(short)
    frame["test"] = pd.factorize(frame.test)[0]
    assert nw.read_captive(written(frame, tmp_path / "t.csv"), ship_file).names == ("0", "1", "2", "3")
