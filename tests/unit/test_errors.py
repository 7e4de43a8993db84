"""Bad input: one sentence with the file, the row, the column and the remedy, exit code 2, nothing half written."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from tables import DTC_SHIP, written

Spoil = Callable[[pd.DataFrame], pd.DataFrame]


def put(column: str, row: int, value: object) -> Spoil:
    def spoil(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.astype({column: object})
        frame.loc[row, column] = value
        return frame

    return spoil


TABLES: dict[str, tuple[Spoil, list[str]]] = {
    "missing column": (lambda f: f.drop(columns="v"), ["'v' is missing", "sway velocity", "add it"]),
    "misspelt column": (lambda f: f.rename(columns={"X": "XX"}), ["'X' is missing", "did you mean 'XX'"]),
    "a NaN": (put("Y", 7, np.nan), ["row 9", "'Y'", "is empty or NaN", "mend"]),
    "text": (put("u", 3, "fast"), ["row 5", "'u'", "fast"]),
    "degrees as radians": (lambda f: f.assign(psi=np.degrees(f.psi)), ["'psi'", "looks like degrees", "psi [deg]"]),
    "rate in degrees": (lambda f: f.assign(r=np.degrees(f.r)), ["dr/dt is 57 times rdot", "r [deg/s]"]),
    "across the canal": (lambda f: f.assign(**{"psi [deg]": 95.0}).drop(columns="psi"), ["row 2", "95.0 deg", "leave"]),
    "hull on the bank": (put("y", 4, 3.4), ["row 6", "'y' = 3.4 m", "bank"]),
    "unsorted time": (lambda f: f.iloc[::-1].reset_index(drop=True), ["row 3", "goes back in time", "sort"]),
    "duplicate time": (lambda f: pd.concat([f.iloc[:3], f.iloc[2:]], ignore_index=True), ["row 5", "repeats the time"]),
    "no rows": (lambda f: f.iloc[:0], ["no rows"]),
    "unknown unit": (lambda f: f.rename(columns={"y": "y [furlongz]"}), ["'y [furlongz]'", "unknown unit", "[m]"]),
    "unit of another kind": (lambda f: f.rename(columns={"y": "y [kg]"}), ["'y [kg]'", "give it in m"]),
    "two columns": (lambda f: f.assign(**{"psi [deg]": 0.0}), ["'psi' and 'psi [deg]'", "keep one"]),
}


@pytest.mark.parametrize("case", TABLES)
def test_table(case: str, table: pd.DataFrame, ship_file: Path, tmp_path: Path, cli) -> None:
    spoil, words = TABLES[case]
    path, model = written(spoil(table), tmp_path / "bad.csv"), tmp_path / "model.toml"
    code, out, err = cli("identify", path, "--ship", ship_file, "-o", model, "--json")
    assert code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert "bad.csv" in err
    for word in words:
        assert word in err
    assert not model.exists()


def test_a_small_heading_in_degrees_is_no_motion_along_the_canal() -> None:
    tests = nw.twin(runs=(nw.HarmonicRun("A", "yaw", 0.05, 16.0, 1.0, 2),))
    frame = tests.to_dataframe()
    with pytest.raises(nw.InputError, match="'psi' looks like deg"):
        nw.read_captive(frame.assign(psi=np.degrees(frame["psi"])), tests.configuration)
    with pytest.raises(nw.InputError, match="u and v are along and across the canal"):
        nw.read_captive(frame.assign(v=np.gradient(frame["y"], frame["t"])), tests.configuration)


def test_what_terms_of_a_propeller_lack_is_named_as_in_the_ship_file() -> None:
    """Without numbers that have a default, such as wake_rate."""
    words = (
        r"add mass .* missing too: \[ship\] x_g, inertia; \[propeller\] diameter, revolutions, wake, thrust_0, thrust_1"
    )
    with pytest.raises(nw.InputError, match=words) as error:
        nw.identify(nw.twin(runs=(nw.HarmonicRun("A", "yaw", 0.3, 16.0, 1.0, 1),)), "mmg")
    assert "wake_rate" not in str(error.value)


SHIPS = {
    "wider than the canal": (DTC_SHIP.replace("0.572", "8.0"), ["beam = 8.0 m", "width = 7.0 m"]),
    "misspelt key": (DTC_SHIP.replace("draft", "drafft"), ["'drafft'", "did you mean 'draft'"]),
    "missing key": (DTC_SHIP.replace("beam = 0.572\n", ""), ["[ship] lacks beam"]),
    "misspelt section": (DTC_SHIP.replace("[canal]", "[cannal]"), ["[cannal]", "canal"]),
    "not TOML": ("a = = 1", ["not valid TOML"]),
    "negative": (DTC_SHIP.replace("3.984", "-1.0"), ["length = -1.0", "positive"]),
    "text": (DTC_SHIP.replace("3.984", '"long"'), ["length = 'long'", "number", "SI units"]),
}


@pytest.mark.parametrize("case", SHIPS)
def test_ship(case: str, tmp_path: Path) -> None:
    text, words = SHIPS[case]
    path = tmp_path / "ship.toml"
    path.write_text(text)
    with pytest.raises(nw.InputError) as error:
        nw.read_ship(path)
    assert "\n" not in str(error.value)
    for word in ["ship.toml", *words]:
        assert word in str(error.value)


MODELS = {
    "misspelt coefficient": (("b_bank = 1.07", "b_bnak = 1.07"), ["'b_bnak'", "did you mean 'b_bank'"]),
    "missing coefficient": (("b_v = 100.0\n", ""), ["b_v is missing"]),
    "not finite": (("b_v = 100.0", "b_v = nan"), ["b_v = nan"]),
    "unknown table": (('table = "paper"', 'table = "papr"'), ["'papr'", "paper"]),
    "unknown section": (("[source]", "[sauce]"), ["[sauce]", "source"]),
    "missing section": (("[coefficients]", "[envelop]"), ["[envelop]"]),
}


@pytest.mark.parametrize("case", MODELS)
def test_model(case: str, dtc: nw.Model, tmp_path: Path) -> None:
    (old, new), words = MODELS[case]
    path = tmp_path / "model.toml"
    nw.save_model(dtc, path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(nw.InputError) as error:
        nw.load_model(path)
    assert "\n" not in str(error.value)
    for word in ["model.toml", *words]:
        assert word in str(error.value)


@pytest.mark.parametrize("name", ["a.csv", "a.parquet", "a.dat", "a.xlsx", "a"])
@pytest.mark.parametrize("content", [b"", bytes(range(256)) * 4])
def test_damaged_files(name: str, content: bytes, ship_file: Path, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(nw.InputError) as error:
        nw.read_captive(tmp_path / name, ship_file)
    assert name in str(error.value)
    assert "\n" not in str(error.value)


def test_absent_files_and_folders(ship_file: Path, tmp_path: Path, table: pd.DataFrame, cli) -> None:
    path = written(table, tmp_path / "good.csv")
    for words in (
        ("identify", tmp_path / "no.csv", "--ship", ship_file),
        ("identify", path, "--ship", tmp_path / "no.toml"),
        ("identify", path, "--ship", ship_file, "-o", tmp_path / "no" / "m.toml"),
        ("identify", path, "--ship", ship_file, "--balance", "tset"),
        ("identify", path, "--ship", ship_file, "--condition", "deep"),
        ("identify", path, "--ship", ship_file, "--terms", "papr"),
        ("identify", path, "--ship", ship_file, "--where", "speed > 1"),
        ("identify", path),
        ("identfy", path),
        ("simulate", "nope"),
        ("simulate", "mikkelsen2025_dtc", "--y", "3.4"),
        ("simulate", "mikkelsen2025_dtc", "--y", "nan"),
        ("simulate", "mikkelsen2025_dtc", "--surge", "free"),
        ("simulate", "mikkelsen2025_dtc", "--plot", tmp_path / "v.doc"),
        ("map", "mikkelsen2025_dtc", "--y", "a:b:c"),
        ("map", "mikkelsen2025_dtc", "--samples", "5"),
    ):
        code, out, err = cli(*words)
        assert (code, out, err.count("\n")) == (2, "", 1), (words, out, err)
        assert "Traceback" not in err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["good.csv", "ship.toml"]


def test_several_conditions_are_not_one_fit(kcs_tests: dict[int, nw.CaptiveTests]) -> None:
    with pytest.raises(nw.InputError, match="several conditions"):
        nw.identify(nw.measured_tests("kcs"))


def test_a_regressor_with_an_unknown_word_is_refused() -> None:
    with pytest.raises(nw.InputError, match="unknown 'speed'"):
        nw.Term("b_x", "b_x", lambda speed: speed, nw.Dimension())
    with pytest.raises(nw.InputError, match="did you mean 'heave'"):
        nw.Term("b_x", "b_x", lambda heav: heav, nw.Dimension())
