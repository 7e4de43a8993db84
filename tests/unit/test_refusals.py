"""More bad input: files that read but mislead, tables on disk, TOML of the wrong shape, folders, and no leftovers."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from tables import DTC_SHIP, frame_of, short_twin, written

Spoil = Callable[[pd.DataFrame], pd.DataFrame]
TURN = 180 / np.pi

TABLES: dict[str, tuple[Spoil, str]] = {
    "a near name": (lambda f: f.rename(columns={"psi": "psii"}), "'psi' is missing .* did you mean 'psii'"),
    "a line break": (
        lambda f: f.astype({"Y": object}).assign(Y=f.Y.astype(object).where(f.index != 2, "a\nb")), "'Y' holds a b,",
    ),
    "a nameless row": (lambda f: f.assign(test=f.test.where(f.index != 8)), "row 10, column 'test' is empty"),
    "a blank cell": (lambda f: f.astype({"r": object}).assign(r=f.r.astype(object).where(f.index != 1, " ")), "row 3"),
    "just touching": (lambda f: f.assign(y=3.5 - 0.572 / 2, psi=0.0, r=0.0), "row 2, column 'y' = 3.214 m .* 7 m wide"),
    "a corner over the edge": (
        lambda f: f.assign(**{"y": 2.5, "psi [deg]": 30.0, "r": 0.0}).drop(columns="psi"), "row 2, column 'y' = 2.5 m",
    ),
    "a canal narrower in one row": (
        lambda f: f.assign(y=0.0, psi=0.0, r=0.0, width=np.where(f.index == 3, 0.5, 7.0)), "row 5, .* 0.5 m wide",
    ),
    "exactly across": (lambda f: f.assign(**{"psi [deg]": 90.0}).drop(columns="psi"), "heading of 90.0 deg"),
    "one header twice": (lambda f: f.assign(**{"y.1": f.y}), "columns 'y' and 'y.1' are both y"),
    "one quantity in two units": (lambda f: f.assign(heave_mm=0.0), "'heave' and 'heave_mm' are both heave"),
    "no unit at all": (lambda f: f.rename(columns={"u": "u [(m]"}), r"column 'u \[\(m\]': unknown unit"),
    "a rate for a speed": (lambda f: f.rename(columns={"u": "u [m/s2]"}), "m/s2 is not a unit of this .* in m/s"),
    "force for moment": (lambda f: f.rename(columns={"N": "N [N]"}), r"column 'N \[N\]': N is not a unit .* N m"),
}  # fmt: skip


@pytest.mark.parametrize("stream", [False, True], ids=["in memory", "streamed"])
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("case", TABLES)
def test_table(case: str, suffix: str, stream: bool, table: pd.DataFrame, ship_file: Path, tmp_path: Path) -> None:
    spoil, sentence = TABLES[case]
    frame = spoil(table)
    if suffix == ".parquet":  # whose columns hold one type each
        frame = frame.astype({name: str for name in frame if name != "test" and frame[name].dtype == object})
    path = written(frame, tmp_path / f"bad{suffix}")
    with pytest.raises(nw.InputError, match=sentence) as error:
        nw.identify((nw.stream_captive if stream else nw.read_captive)(path, ship_file))
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_honest_radians_are_not_taken_for_degrees(ship_file: Path, tmp_path: Path) -> None:
    """Headings up to 80 degrees, slow turns and a rate said in degrees all pass."""
    frame = frame_of(short_twin())
    steep = frame.assign(psi=1.39, y=0.0, r=0.0).drop(columns="x")
    said = frame.assign(**{"r [deg/s]": frame.r * TURN}).drop(columns="r")
    for i, good in enumerate((steep, said, frame.assign(r=0.0))):
        assert nw.read_captive(written(good, tmp_path / f"{i}.csv"), ship_file).rows == len(frame)


@pytest.mark.parametrize("where", ["speed > 1", "u >", "u", "u + 1", "1", "u > 0.3 and", "@pd"])
def test_selection_that_cannot_be_understood(where: str, table: pd.DataFrame, ship_file: Path, tmp_path: Path) -> None:
    path = written(table, tmp_path / "t.csv")
    with pytest.raises(nw.InputError, match="cannot select rows where") as error:
        nw.read_captive(path, ship_file, where=where)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("read", [nw.read_captive, nw.stream_captive])
@pytest.mark.parametrize("where", [None, "u > 9"])
def test_nothing_left_to_read(read, where: str | None, table: pd.DataFrame, ship_file: Path, tmp_path: Path) -> None:
    path = written(table if where else table.iloc[:0], tmp_path / "t.csv")
    with pytest.raises(nw.InputError, match=r"t.csv: no rows are left to read"):
        nw.identify(read(path, ship_file, where=where))


@pytest.mark.parametrize("content", [b"a,b\n1,2\n3,4,5\n", bytes(range(256)) * 99, b"", b"\0" * 99, b"\n\n"])
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_damaged_files_on_the_stream(content: bytes, suffix: str, ship_file: Path, tmp_path: Path) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(content)
    with pytest.raises(nw.InputError) as error:
        nw.identify(nw.stream_captive(path, ship_file))
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_damage_far_down_the_file(table: pd.DataFrame, ship_file: Path, tmp_path: Path, monkeypatch) -> None:
    path = written(table, tmp_path / "t.csv")
    path.write_text(path.read_text() + "1,2,3\n" * 3 + "1" + ",2" * 40 + "\n")
    monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", 50)
    with pytest.raises(nw.InputError, match=r"t.csv: row 450 has more cells than the header"):
        nw.identify(nw.stream_captive(path, ship_file))


def test_stream_wants_tests_together_and_one_condition(ship_file: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", 50)
    frame = frame_of(short_twin())
    mixed = written(frame.sort_values("t", kind="stable"), tmp_path / "mixed.csv")
    with pytest.raises(nw.InputError, match=r"mixed.csv: the rows of test .* do not stand together; sort it by test"):
        nw.identify(nw.stream_captive(mixed, ship_file))
    deep = written(frame.assign(condition=np.where(frame.test == "yaw", "deep", "shallow")), tmp_path / "deep.csv")
    with pytest.raises(nw.InputError, match=r"holds several conditions \(deep, shallow"):
        nw.identify(nw.stream_captive(deep, ship_file))
    back = frame.assign(t=np.where(frame.index == 60, 0.0, frame.t))
    with pytest.raises(nw.InputError, match="goes back in time"):
        nw.identify(nw.stream_captive(written(back, tmp_path / "back.csv"), ship_file))


def test_time_that_goes_back_from_one_block_to_the_next(ship_file: Path, tmp_path: Path, monkeypatch) -> None:
    frame = frame_of(short_twin())
    monkeypatch.setattr("narrows.captive.tests.BLOCK_ROWS", 40)
    frame.loc[40:, "t"] -= 3.0
    one = frame[frame.test == frame.test[0]]
    with pytest.raises(nw.InputError, match="goes back in time at t ="):
        nw.identify(nw.stream_captive(written(one, tmp_path / "t.csv"), ship_file))


@pytest.mark.parametrize("read", [nw.read_captive, nw.stream_captive])
def test_a_folder_is_no_table(read, ship_file: Path, tmp_path: Path) -> None:
    (tmp_path / "t.csv").mkdir()
    with pytest.raises(nw.InputError, match=r"t\.csv"):
        read(tmp_path / "t.csv", ship_file)


SHIPS = {
    "bare value for a section": ("ship = 5\n[canal]\nwidth = 7.0\n", "ship = 5 must be a section"),
    "list for a section": (DTC_SHIP.replace("[canal]\nwidth = 7.0", "[[canal]]\nwidth = 7.0"), "must be a section"),
    "text for a depth": (DTC_SHIP + '[depths]\nA = "deep"\n', r"\[depths\] A = 'deep' is not a finite number"),
    "no water under the keel": (DTC_SHIP + "[depths]\nA = 0.1\n", r"\[depths\] A = 0.1 m leaves no water"),
    "draft in centimetres": (
        DTC_SHIP.replace("draft = 0.163", "draft = 16.3"),
        r"draft = 16.3 m is more than \[ship\] beam",
    ),
    "depth of nan": (DTC_SHIP + "[depths]\nA = nan\n", "A = nan is not a finite number"),
    "canal too shallow": (DTC_SHIP + "depth = 0.163\n", r"\[canal\] depth = 0.163 m leaves no water"),
    "true for a width": (DTC_SHIP.replace("7.0", "true"), "width = True is not a finite number"),
    "endless": (DTC_SHIP.replace("7.0", "inf"), "width = inf is not a finite number"),
    "zero": (DTC_SHIP.replace("3.984", "0"), "length = 0 must be positive"),
    "text for a centre of gravity": (DTC_SHIP.replace("[water]", 'x_g = "aft"\n[water]'), "x_g = 'aft'"),
    "block coefficient in per cent": (DTC_SHIP.replace("0.661", "66.1"), "block_coefficient = 66.1 is over 1"),
    "unknown section": (DTC_SHIP + "[bank]\nslope = 1\n", r"unknown section \[bank\]; known: canal"),
    "no canal": (DTC_SHIP.partition("[canal]")[0], r"\[canal\] lacks width"),
    "as wide as the canal": (DTC_SHIP.replace("7.0", "0.572"), "does not fit"),
}


@pytest.mark.parametrize("case", SHIPS)
def test_ship_file(case: str, tmp_path: Path) -> None:
    text, sentence = SHIPS[case]
    path = tmp_path / "ship.toml"
    path.write_text(text)
    with pytest.raises(nw.InputError, match=sentence) as error:
        nw.read_ship(path)
    assert str(error.value).startswith(f"{path}: ")


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"[ship", b"a = 1\na = 2\n"])
def test_not_toml(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "ship.toml").write_bytes(content)
    with pytest.raises(nw.InputError, match=r"ship.toml: is not valid TOML"):
        nw.read_ship(tmp_path / "ship.toml")


MODELS = {
    "text for a coefficient": ("b_v = 100.0", 'b_v = "a"', "coefficient b_v = 'a' is not a finite number"),
    "true for a coefficient": ("b_v = 100.0", "b_v = true", "coefficient b_v = True"),
    "list for a coefficient": ("b_v = 100.0", "b_v = [1.0]", "coefficient b_v"),
    "bare coefficients": ("[coefficients]", "[source]\nx = 1\n[coeff]", r"unknown|defined|valid TOML"),
    "half a range": ("[data_range]", "[data_range]\nspeed = [1.0]", r"\[data_range\] speed = \[1.0\] is not a pair"),
    "bare range": ("[data_range]", "[data_range]\nspeed = 1.0", r"\[data_range\] speed = 1.0 is not a pair"),
    "misspelt range": ("[data_range]", "[data_range]\nsped = [1.0, 2.0]", "unknown key 'sped'; did you mean 'speed'"),
    "ragged covariance": (
        "[data_range]",
        "[covariance]\nnames = ['a']\nmatrix = [[1.0], [1.0, 2.0]]\n[data_range]",
        "row",
    ),
    "text covariance": ("[data_range]", "[covariance]\nnames = ['a']\nmatrix = [['x']]\n[data_range]", "covariance"),
    "small covariance": ("[data_range]", "[covariance]\nnames = ['b_v']\nmatrix = [[1.0]]\n[data_range]", "covariance"),
    "half a covariance": ("[data_range]", "[covariance]\nnames = ['b_v']\n[data_range]", "covariance"),
    "number for a table": ('table = "paper"', "table = 3", "unknown table of terms '3'"),
    "bare section": ("[data_range]\n", "", "abs_y"),
}


@pytest.mark.parametrize("case", MODELS)
def test_model_file(case: str, dtc: nw.Model, tmp_path: Path) -> None:
    old, new, sentence = MODELS[case]
    path = tmp_path / "model.toml"
    nw.save_model(dtc, path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(nw.InputError, match=sentence) as error:
        nw.load_model(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_nothing_is_half_written(dtc: nw.Model, tmp_path: Path) -> None:
    """A folder that is absent, a folder where the file should be, a disk that fills up: the old file stays."""
    (tmp_path / "folder.toml").mkdir()
    for path in (tmp_path / "absent" / "m.toml", tmp_path / "folder.toml"):
        with pytest.raises(nw.InputError, match="cannot be written"):
            nw.save_model(dtc, path)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.toml"]


def test_a_write_that_fails_leaves_the_old_file(dtc: nw.Model, tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "m.toml"
    nw.save_model(dtc, path)
    before = path.read_bytes()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(nw.InputError, match=r"m.toml: cannot be written \(No space left on device\)"):
        nw.save_model(dtc.with_coefficients(b_v=1.0), path)
    assert path.read_bytes() == before
    assert [own.name for own in tmp_path.iterdir()] == ["m.toml"]


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: nw.HarmonicRun("A", "roll", 0.5, 20.0), "run A: kind 'roll' is unknown; choose yaw or sway"),
        (lambda: nw.HarmonicRun("A", "yaw", 5.0, 20.0), "run A: too steep for 1.0 m/s"),
        (lambda: nw.HarmonicRun("A", "sway", 0.5, 0.0), "run A: period = 0.0 must be positive"),
        (lambda: nw.twin(runs=()), "fewer than two rows"),
        (lambda: nw.twin(rate=0.0), "fewer than two rows"),
        (lambda: nw.published("mikkelsen2025"), "did you mean 'mikkelsen2025_dtc'"),
        (lambda: nw.measured_tests("kvlcc"), "known: kcs, lataire2009"),
        (lambda: nw.identify(short_twin(), balance="huber"), "balance = 'huber' is unknown; choose tests or rows"),
        (lambda: short_twin().test("swai"), "no test is called 'swai'; did you mean 'sway'"),
        (lambda: short_twin().where([False] * 4), "no test is left"),
        (lambda: nw.identify_conditions(nw.measured_tests("kcs"), "C0101A04"), "no condition 'C0101A04'; did you mean"),
        (lambda: nw.identify_conditions(short_twin(), "deep"), "no condition 'deep'; it names none"),
    ],
)
def test_calls_that_make_no_sense(make, sentence: str) -> None:
    with pytest.raises(nw.InputError, match=sentence):
        make()
