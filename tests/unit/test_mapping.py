"""A laboratory's own names, units and signs: read as the documented columns, said, refused where they do not fit."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.captive.measured import measured_files
from tables import frame_of, short_twin

ROWS = frame_of(short_twin())
MAPPING = """
[columns]             # a documented name = the table's header
test = "Run no"
t = "Time (s)"
y = "Ycarriage"
psi = "Heading"
rudder = "delta"
heave = "z"
X = "Fx"
N = "Mz"

[units]               # where the header does not say
y = "mm"
psi = "deg"
rudder = "deg"

[positive]            # where the table counts the other way
y = "port"
v = "port"
vdot = "port"
Y = "port"
psi = "counter-clockwise"
r = "port"
rdot = "port"
N = "port"
rudder = "port"
heave = "up"
"""


def foreign() -> pd.DataFrame:
    """The tests as a laboratory with y to port and z up would write them; its X is a place, and its N revolutions."""
    mirrored = ROWS.assign(**{name: -ROWS[name] for name in ("y", "v", "vdot", "Y", "psi", "r", "rdot", "N", "heave")})
    table = mirrored.assign(y=mirrored.y * 1e3, psi=np.degrees(mirrored.psi), delta=-2.0, Xc=ROWS["x"], rev=90.0)
    names = {"test": "Run no", "t": "Time (s)", "y": "Ycarriage", "psi": "Heading", "heave": "z", "X": "Fx", "N": "Mz"}
    return table.rename(columns=names).drop(columns="x").rename(columns={"Xc": "X", "rev": "N"})


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    foreign().to_csv(tmp_path / "lab.csv", sep=";", decimal=",", index=False)
    (tmp_path / "columns.toml").write_text(MAPPING)
    return tmp_path / "lab.csv", tmp_path / "columns.toml"


def test_own_names_units_and_signs(files: tuple[Path, Path], ship_file: Path) -> None:
    found = nw.read_captive(files[0], ship_file, mapping=files[1])
    assert found.names == tuple(dict.fromkeys(ROWS.test))
    for name in ("t", "y", "v", "psi", "r", "rdot", "heave", "X", "Y", "N"):
        np.testing.assert_allclose(found.columns[name], ROWS[name], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.columns["rudder"], np.radians(2.0))
    assert found.notes[0].startswith("by columns.toml: test is 'Run no'; t is 'Time (s)'; ")
    assert "rudder is 'delta', its sign turned as it counts to port" in found.notes[0]
    assert "heave is 'z', its sign turned as it counts up" in found.notes[0]


def test_mapped_tables_stream_and_give_the_same_fit(files: tuple[Path, Path], ship_file: Path) -> None:
    streamed = nw.identify(nw.stream_captive(files[0], ship_file, mapping=files[1]), pass_over="rudder")
    plain = nw.identify(short_twin())
    for name in nw.PAPER.names:
        assert streamed.coefficients[name] == pytest.approx(plain.coefficients[name], rel=1e-7, abs=1e-9)
    assert "columns by columns.toml" in streamed.notes


@pytest.mark.parametrize("report", [False, True], ids=["printed", "and reported"])
def test_on_the_command_line_and_in_the_report(
    report: bool, files: tuple[Path, Path], ship_file: Path, tmp_path: Path, cli
) -> None:
    words = ("--report", tmp_path / "r.html") if report else ()
    where = "abs(psi_deg) < 60 and rudder_deg > 1"
    code, out, err = cli(
        "identify",
        files[0],
        "--ship",
        ship_file,
        "--mapping",
        files[1],
        "--where",
        where,
        "--pass-over",
        "rudder",
        *words,
    )
    assert (code, err) == (0, "")
    assert "its sign turned" in " ".join(out.split())
    assert "[/" not in out
    assert not report or "its sign turned" in (tmp_path / "r.html").read_text()


WRONG = {
    "an unknown name": ("[columns]\nrud = 'delta'", r"'rud' is no documented column"),
    "an unknown header": ("[columns]\nrudder = 'dleta'", r"no column is headed 'dleta', .* did you mean 'delta'"),
    "an unknown section": ("[signs]\ny = 'port'", r"unknown section \[signs\]"),
    "an unknown way": ("[positive]\ny = 'above'", r"\[positive\] y = 'above' is no direction of it.*port, starboard"),
    "a way of what has none": ("[positive]\nt = 'up'", r"\[positive\] t = 'up' is no direction"),
    "no word": ("[columns]\ny = 3", r"\[columns\] y = 3 is no word"),
    "one column twice": ("[columns]\ny = 'delta'\nrudder = 'delta'", "'delta' is read as y and rudder"),
    "a bare value": ("columns = 3", "must be a section"),
    "no TOML": ("a = = 1", "not valid TOML"),
    "an unknown unit": (MAPPING.replace('"mm"', '"furlongz"'), r"unknown unit \[furlongz\]"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_does_not_fit(case: str, files: tuple[Path, Path], ship_file: Path) -> None:
    mapping, said = WRONG[case]
    files[1].write_text(mapping)
    with pytest.raises(nw.InputError, match=said) as error:
        nw.read_captive(files[0], ship_file, mapping=files[1])
    assert "columns.toml" in str(error.value) or "lab.csv" in str(error.value)


def test_an_empty_header_passes_a_column_over(ship_file: Path) -> None:
    table = ROWS.assign(rudder=0.1)
    assert "rudder" not in nw.read_captive(table, ship_file, mapping={"columns": {"rudder": ""}}).columns


def test_a_sign_that_a_layout_turns_is_said() -> None:
    for where in (
        "type == 'STATX0' and abs(psi_deg) < 80 and abs(y_m) < 1 and u_mps > 0.2",
        "rudder_deg > 5 and u > 0",
    ):
        tests = nw.read_captive(*measured_files("kcs"), where=where)
        assert any("rudder is rud_given_deg with its sign turned" in note for note in tests.notes)
    raw = pd.read_csv(measured_files("kcs")[0])
    assert tests.rows == int(((raw.rud_given_deg < -5) & (raw.u_mps > 0)).sum()) > 0
    assert (tests.columns["rudder"] > 0).all()


def test_plan_takes_one_condition(cli) -> None:
    table, ship = measured_files("kcs")
    code, _, err = cli("plan", ship, "--after", table, "--json", "--runs", "2")
    assert code == 2
    assert "choose one with --condition C0101A01" in err
    code, _, err = cli("plan", ship, "--condition", "C0101A02", "--runs", "2")
    assert code == 2
    assert "--condition goes with --after" in err


def test_plan_stays_within_the_speeds_of_its_condition(cli) -> None:
    table, ship = measured_files("kcs")
    code, out, _ = cli("plan", ship, "--after", table, "--condition", "C0101A02", "--runs", "2", "--json")
    assert code == 0
    assert "Speeds are within those tested, " in out


def test_what_stands_in_brackets_is_printed_as_it_is(ship_file: Path, tmp_path: Path, cli) -> None:
    """Brackets are no markup of the terminal's."""
    ROWS.rename(columns={"Y": "Fy [N]"}).to_csv(tmp_path / "t.csv", index=False)
    (tmp_path / "m.toml").write_text("[columns]\nY = 'Fy [N]'")
    out = cli("identify", tmp_path / "t.csv", "--ship", ship_file, "--mapping", tmp_path / "m.toml")[1]
    assert "by m.toml: Y is 'Fy [N]'" in " ".join(out.split())
