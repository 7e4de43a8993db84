"""What files, names and callers bring in, found by reading and by fuzzing: each is refused in one sentence."""

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.base.errors import InputError, reason, shown
from tables import DTC_SHIP, frame_of, short_twin

DTC = nw.published("mikkelsen2025_dtc")
DIGITS = {
    "400 digits": "9" * 400,
    "4300 digits": "9" * 4300,
    "5000 digits": "9" * 5000,
    "hexadecimal": "0x" + "f" * 5000,
}


def sentence(act: Callable[[], object]) -> str:
    with pytest.raises(nw.InputError) as error:
        act()
    said = str(error.value)
    assert len(said.splitlines()) == 1
    assert len(said) < 600
    return said


@pytest.mark.parametrize("number", DIGITS.values(), ids=DIGITS)
@pytest.mark.parametrize("key", ["length = 3.984", "beam = 0.572", "width = 7.0"])
def test_integers_without_end_in_ship_files(number: str, key: str, tmp_path: Path) -> None:
    path = tmp_path / "ship.toml"
    path.write_text(DTC_SHIP.replace(key, f"{key.partition('=')[0]}= {number}"))
    assert str(path) in sentence(lambda: nw.read_ship(path))


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The text of a model's file."""
    path = tmp_path_factory.mktemp("good") / "model.toml"
    nw.save_model(nw.identify(short_twin()).model, path)
    return path.read_text()


def spoilt(good: str, tmp_path: Path, old: str, new: str) -> Path:
    path = tmp_path / "model.toml"
    assert old in good
    path.write_text(good.replace(old, new, 1))
    return path


@pytest.mark.parametrize("number", DIGITS.values(), ids=DIGITS)
@pytest.mark.parametrize("key", ["b_v = ", "speed = [", "matrix = [", "width = "])
def test_integers_without_end_in_model_files(number: str, key: str, good: str, tmp_path: Path) -> None:
    path = spoilt(good, tmp_path, key, f"{key}{number}{',' if key.endswith('[') else ' #'}")
    assert str(path) in sentence(lambda: nw.load_model(path))


@pytest.mark.parametrize("names", ["[1, ", "[1.5, 'a', ", "[[], ", "[{}, ", "[true, "])
def test_mixed_names_of_a_covariance(names: str, good: str, tmp_path: Path) -> None:
    path = spoilt(good, tmp_path, "names = [", f"names = {names}")
    assert "does not have one row and one column for each" in sentence(lambda: nw.load_model(path))


@pytest.mark.parametrize("read", [nw.load_model, nw.read_ship])
@pytest.mark.parametrize(
    "text", ["x = " + "[" * 100_000, "x = " + "[" * 500 + "]" * 500, "a." * 5_000 + "b = 1", "\0", "x = {" * 9000]
)
def test_what_is_nested_without_end(read: Callable[[Path], object], text: str, tmp_path: Path) -> None:
    path = tmp_path / "deep.toml"
    path.write_text(text)
    assert str(path) in sentence(lambda: read(path))


HEADER, ROW = frame_of(short_twin()).iloc[:1].to_csv(index=False).splitlines()


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ((f"{ROW},7", f"{ROW},7"), "row 2 has more cells than the header"),
        ((f"{ROW},", f"{ROW},"), "row 2 has more cells than the header"),
        ((ROW, f"{ROW},7"), "row 3 has more cells than the header"),
        ((ROW.replace(",", f",{'9' * 400},", 1).rpartition(",")[0],), "not a finite number"),
        ((ROW.replace(",", f",{'9' * 5000},", 1).rpartition(",")[0],), "not a finite number"),
        ((ROW.replace(",", ",1e308,", 1).rpartition(",")[0],), "which nothing measures"),
    ],
    ids=["every row longer", "commas at the ends", "one row longer", "400 digits", "5000 digits", "1e308"],
)
@pytest.mark.parametrize("read", [nw.read_captive, nw.stream_captive])
def test_tables(read, lines: tuple[str, ...], said: str, ship_file: Path, tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("\n".join([HEADER, *lines, ""]))
    assert said in sentence(lambda: nw.identify(read(path, ship_file)))


@pytest.mark.parametrize("kind", ["dates", "lists", "integers", "words"])
def test_columns_of_a_kind_that_holds_no_numbers(
    kind: str, table: pd.DataFrame, ship_file: Path, tmp_path: Path
) -> None:
    cells = {"dates": pd.Timestamp("2020"), "lists": [1.0], "integers": "9" * 99, "words": "x"}
    path = tmp_path / "t.parquet"
    table.assign(u=[cells[kind]] * len(table)).to_parquet(path)
    assert "column 'u' holds" in sentence(lambda: nw.read_captive(path, ship_file))


def test_two_columns_of_one_name(table: pd.DataFrame, ship_file: Path, tmp_path: Path) -> None:
    path = tmp_path / "t.dat"
    names = [*table, "u"]
    path.write_text("\t".join(names) + "\n" + "\t" * (len(names) - 1) + "\n" + "\t".join("1" * len(names)) + "\n")
    assert "'u' and 'u.1' are both u; keep one" in sentence(lambda: nw.read_captive(path, ship_file))


@pytest.mark.parametrize("name", ["__debug__", "__class__", "lambda", "None", "", "a b", "a\n", "width", "u"])
def test_names_of_coefficients(name: str) -> None:
    assert "cannot be called" in sentence(lambda: replace(nw.PAPER.sway[0], name=name))


@pytest.mark.parametrize("name", ["abs", "sqrt", "lane", "np", "rhs", "I", "E", "exp", "é", "1a", "a-b"])
def test_names_that_programs_use_too(name: str) -> None:
    table = replace(nw.PAPER, name="mine", sway=(replace(nw.PAPER.sway[0], name=name), *nw.PAPER.sway[1:]))
    coefficients = {name if own == "b_vdot" else own: value for own, value in DTC.coefficients.items()}
    model = nw.Model(DTC.configuration, table, coefficients)
    assert nw.simulate(model, 0.5, duration=2.0).y[-1] == nw.simulate(DTC, 0.5, duration=2.0).y[-1]


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda: nw.Ship(1e308, 1.0, 1.0, 0.5), "beyond all measure"),
        (lambda: nw.Ship(10**400, 1.0, 1.0, 0.5), "not a finite number"),
        (lambda: nw.Ship(10**5000, 1.0, 1.0, 0.5), "too long to show"),
        (lambda: nw.Ship(1.0, 1.0, 1.0, 0.5, name=3), "must be a word"),
        (lambda: nw.scale_model(DTC, 10**400), "must be over 0 and under"),
        (lambda: nw.scale_model(DTC, "355"), "must be over 0 and under"),
        (lambda: nw.scale_model(DTC, 355.0, width=1j), "not a finite number"),
        (lambda: nw.identify(short_twin(), balance=["rows"]), "choose tests or rows"),
        (lambda: nw.identify(short_twin(), terms=3), "no table of terms"),
        (lambda: DTC.with_coefficients(b_v=10**400), "not a finite number"),
        (lambda: nw.load_model("a\0b"), "null"),
        (lambda: nw.read_captive("a\0b.csv", DTC.configuration), "null"),
        (lambda: nw.read_captive(3, DTC.configuration), "neither a path nor a table"),
        (lambda: nw.read_ship(os.devnull), "lacks"),
    ],
)  # fmt: skip
def test_arguments(act: Callable[[], object], said: str) -> None:
    assert said in sentence(act)


def test_sentences_hold_nothing_that_a_terminal_obeys() -> None:
    said = str(InputError("a\x1b[31mred\x07 \ud800 \n\u2028 b" + "c" * 5000))
    assert said.isprintable()
    assert len(said) < 2000
    assert r"a\x1b[31mred\x07 \ud800" in said


@pytest.mark.parametrize(
    "error", [MemoryError(), RecursionError(), KeyError(), OSError(28, "No space"), ValueError("a\nb" * 999)]
)
def test_there_is_always_a_reason(error: BaseException) -> None:
    assert 0 < len(reason(error)) <= 200
    assert reason(error).isprintable()


def test_values_are_shown_short() -> None:
    assert shown(10**5000) == "a int too long to show"
    assert shown(np.float64(0.5)) == "0.5"
    assert len(shown("a" * 9999)) < 100
    assert len(shown([["b"] * 99] * 99)) < 1000


NARROWS = [sys.executable, "-c", "from narrows.cli import main; main()"]


def test_a_reader_that_leaves_is_no_error() -> None:
    with subprocess.Popen([*NARROWS, "simulate", "--help"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
        run.stdout.close()
        assert run.stderr.read() == b""
        assert run.wait(60) == 1


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
@pytest.mark.parametrize("words", [["--help"], ["scale", "mikkelsen2025_dtc", "--length", "355", "--json"]])
def test_an_output_that_is_full_is_said(words: list[str]) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run([*NARROWS, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "narrows: the output cannot be written (No space left on device); send it elsewhere\n"


@pytest.mark.parametrize(
    "words",
    [
        ("map", "mikkelsen2025_dtc", "--y", "0:1:1000000000000"), ("map", "mikkelsen2025_dtc", "--y", "0:1:1e3"),
        ("map", "mikkelsen2025_dtc", "--y", "0:1:" + "9" * 400), ("simulate", "mikkelsen2025_dtc", "--dt", "1e-300"),
        ("simulate", "a\0b"), ("simulate", "x" * 5000), ("simulate", "/dev/null"),
        ("scale", "mikkelsen2025_dtc", "--length", "nan"),
    ],
)  # fmt: skip
def test_the_command_line(words: tuple[str, ...], cli) -> None:
    code, _, err = cli(*words)
    assert (code, err.count("\n")) == (2, 1)
