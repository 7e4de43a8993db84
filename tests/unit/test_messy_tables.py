"""Tables as laboratories write them: each is read as the clean one, or refused with a remedy that works."""

import io
import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.captive.columns import draft_columns
from tables import frame_of, short_twin

TESTS = short_twin()
CLEAN = frame_of(TESTS)
DEG, KNOT = 180 / np.pi, 1852 / 3600
IN_DEGREES = {"psi": DEG, "r": DEG, "rdot": DEG}
NORTH = CLEAN.u * np.cos(CLEAN.psi) - CLEAN.v * np.sin(CLEAN.psi)
EAST = CLEAN.u * np.sin(CLEAN.psi) + CLEAN.v * np.cos(CLEAN.psi)
RATES = ["udot", "vdot", "rdot"]


def headed(words: dict[str, str], frame: pd.DataFrame = CLEAN, **factors: float) -> pd.DataFrame:
    """The table under other headers, its numbers in their units."""
    return frame.assign(**{name: frame[name] * factor for name, factor in factors.items()}).rename(columns=words)


def text(frame: pd.DataFrame = CLEAN, separator: str = ",", decimal: str = ".", **options: object) -> str:
    return frame.to_csv(index=False, sep=separator, decimal=decimal, **options)


def with_lines(*lines: str, at: int | None = None, frame: pd.DataFrame = CLEAN) -> str:
    rows = text(frame).splitlines()
    place = len(rows) if at is None else at
    return "\n".join([*rows[:place], *lines, *rows[place:], ""])


def summed(name: str) -> str:
    return ",".join([name, *(f"{value:.4g}" for value in CLEAN.drop(columns="test").mean())])


def workbook(**sheets: pd.DataFrame) -> bytes:
    memory = io.BytesIO()
    with pd.ExcelWriter(memory) as book:
        for name, frame in sheets.items():
            frame.to_excel(book, sheet_name=name, index=False)
    return memory.getvalue()


def clock(seconds: float) -> str:
    return f"{int(seconds // 3600):02d}:{int(seconds // 60) % 60:02d}:{seconds % 60:09.6f}"


CHINESE = headed(
    {"t": "时间（秒）", "test": "试验编号", "psi": "艏向角（度）", "u": "纵向速度（m/s）", "v": "横向速度（m/s）",
     "r": "艏摇角速度（度/s）", "X": "纵向力（N）", "Y": "横向力（N）", "N": "艏摇力矩（N·m）"},
    psi=DEG, r=DEG)  # fmt: skip
NAMES = {"test": "Run", "t": "Time", "psi": "Heading", "u": "Surge velocity", "v": "Sway velocity", "r": "Yaw rate",
         "heave": "Sinkage", "X": "Surge force", "Y": "Sway force", "N": "Yaw moment"}  # fmt: skip
UNITS = {"t": "s", "psi": "deg", "u": "m/s", "v": "m/s", "r": "deg/s", "heave": "mm", "X": "N", "Y": "N", "N": "Nm"}
TURNED = headed({}, CLEAN[[*NAMES, "x", "y"]], psi=DEG, r=DEG, heave=1e3)
SYMBOLS = {"test": "no", "heave": "z"}


def heads(*rows: dict[str, str]) -> str:
    lines = [";".join(row.get(name, name) for name in TURNED) for row in rows]
    return "\n".join([*lines, ";".join(UNITS.get(name, "m") for name in TURNED), text(TURNED, ";").split("\n", 1)[1]])


READ: dict[str, pd.DataFrame | str | bytes] = {
    "English, units in brackets": headed(
        {"psi": "Heading [deg]", "v": "Sway velocity [m/s]", "u": "Surge velocity [m/s]", "r": "Yaw rate [deg/s]",
         "rdot": "Yaw acceleration [deg/s²]", "N": "Yaw moment [Nm]", "t": "Time [s]"}, **IN_DEGREES),
    "English, units after a comma": headed(
        {"psi": "Yaw angle, deg", "r": "Rate of turn, deg/s", "rdot": "r dot [deg/s2]", "y": "Sway position, mm"},
        **IN_DEGREES, y=1e3),
    "English, upper case": headed({"test": "RUN NO", "t": "TIME (s)", "X": "FX (N)", "Y": "FY (N)", "N": "MZ (Nm)"}),
    "what is meant, after the unit": headed({"X": "Fx (N) - surge", "Y": "Fy (N) - sway", "N": "Mz (N-m), yaw"}),
    "German, Grad": headed(
        {"t": "Zeit / s", "test": "Versuch", "psi": "Kurswinkel / Grad", "r": "Gierrate / Grad/s",
         "u": "Längsgeschwindigkeit [m/s]", "v": "Quergeschwindigkeit [m/s]", "X": "Längskraft [N]",
         "Y": "Querkraft [kN]", "y": "Querversatz [m]", "N": "Giermoment [Nm]"}, psi=DEG, r=DEG, Y=1e-3),
    "German of a measuring computer": text(headed(
        {"psi": "Kurswinkel [°]", "vdot": "Querbeschleunigung [m/s²]"}, psi=DEG), ";", ",").encode("cp1252"),
    "German without umlauts": headed({"u": "Laengsgeschwindigkeit [kn]", "v": "Quergeschwindigkeit [kn]"},
                                     u=1 / KNOT, v=1 / KNOT),
    "Dutch": headed(
        {"t": "Tijd [s]", "test": "Proef", "psi": "Koershoek [graden]", "u": "Langssnelheid [m/s]",
         "v": "Dwarssnelheid [m/s]", "r": "Giersnelheid [graden/s]", "Y": "Dwarskracht [N]"}, psi=DEG, r=DEG),
    "Chinese": text(CHINESE),
    "Chinese of UTF-16": text(CHINESE, "\t").encode("utf-16"),
    "Chinese of Excel": text(CHINESE).encode("gb18030"),
    "French": headed(
        {"t": "Temps (s)", "test": "Essai", "psi": "Cap (deg)", "u": "Vitesse longitudinale (m/s)",
         "r": "Vitesse de lacet (deg/s)", "Y": "Force transversale (N)", "N": "Moment de lacet (N.m)"}, psi=DEG, r=DEG),
    "Japanese of a measuring computer": text(headed(
        {"t": "時間 [s]", "test": "試験番号", "psi": "方位角 [deg]", "v": "横速度 [m/s]", "Y": "横力 [N]",
         "N": "回頭モーメント [Nm]"}, psi=DEG)).encode("cp932"),
    "dots over symbols": headed({"psi": "ψ [°]", "r": "ψ̇ [°/s]", "rdot": "ψ̈ [°/s²]", "vdot": "v̇"}, **IN_DEGREES),
    "exponents of Fortran": CLEAN.assign(Y=CLEAN.Y.map(lambda force: f"{force:.9E}".replace("E", "D"))),
    "kilogram-force": headed({"X": "Fx [kgf]", "N": "Mz [kgf m]"}, X=1 / 9.80665, N=1 / 9.80665),
    "degrees a minute": headed({"r": "ROT [deg/min]"}, r=60 * DEG),
    "underscores": headed({"psi": "heading_deg", "r": "yaw_rate", "v": "sway_velocity"}, psi=DEG),
    "a compass": headed({"psi": "ψ [deg]"}, CLEAN.assign(psi=CLEAN.psi % (2 * np.pi)), psi=DEG),
    "milliseconds": headed({"t": "Time [ms]"}, t=1e3),
    "times of day": headed({"t": "Time"}, CLEAN.assign(t=CLEAN.t.map(clock))),
    "without rates": CLEAN.drop(columns=["r", *RATES]),
    "a depth in centimetres": CLEAN.assign(**{"Water depth [cm]": 600.0}),
    "a group row over the names": "Run;Motion" + ";" * (len(CLEAN.columns) - 2) + "\n" + text(CLEAN, ";", ","),
    "names over units": heads(NAMES),
    "names over symbols over units": heads(NAMES, SYMBOLS),
    "headers over several lines": text(headed({"psi": "Heading\n[deg]", "v": "Sway\nvelocity\n[m/s]"}, psi=DEG)),
    "a header again": with_lines("", text().splitlines()[0], at=200),
    "a row of means": with_lines(summed("Mean")),
    "a row of words": with_lines("Total" + "," * (len(CLEAN.columns) - 1)),
    "empty columns at the end": "\n".join(f"{line},,," for line in text().splitlines()),
    "an index without a name": CLEAN.to_csv(),
    "a cover sheet": workbook(Info=pd.DataFrame({"Project": ["bank tests"]}), Data=CLEAN),
}  # fmt: skip


def put(folder: Path, table: pd.DataFrame | str | bytes) -> Path:
    content = text(table) if isinstance(table, pd.DataFrame) else table
    path = folder / ("lab.xlsx" if isinstance(table, bytes) and table.startswith(b"PK") else "lab.csv")
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def same(found: nw.CaptiveTests, given: tuple[str, ...] = ("y", "psi", "u", "v", "X", "Y", "N")) -> None:
    assert found.names == TESTS.names
    for column in given:
        np.testing.assert_allclose(found[column], TESTS[column], rtol=1e-6, atol=1e-8, err_msg=column)
    inner = np.ones(found.rows, bool)
    inner[found.starts[:-1]] = inner[found.starts[1:] - 1] = False
    for rate in ("r", "vdot"):
        assert np.abs(found[rate] - TESTS[rate])[inner].max() < 0.05 * np.abs(TESTS[rate]).max(), rate


WITHOUT_NOTE = ("empty columns at the end", "an index without a name", "exponents of Fortran")


@pytest.mark.parametrize("name", READ)
def test_a_table_is_read_as_the_clean_one(name: str, tmp_path: Path) -> None:
    found = nw.read_captive(put(tmp_path, READ[name]), TESTS.configuration)
    same(found)
    assert len(found.notes) > len(TESTS.notes) or name in WITHOUT_NOTE


Mend = Callable[[pd.DataFrame], pd.DataFrame]
RUDDER = 0.4 * np.sin(CLEAN.t)
REFUSED: dict[str, tuple[pd.DataFrame, str, Mend]] = {
    "degrees without a unit": (
        headed({"psi": "Heading"}, psi=DEG), r"'psi \[deg\]'", lambda f: f.rename(columns={"Heading": "psi [deg]"})),
    "two headings": (
        CLEAN.assign(Kurswinkel=0.0).rename(columns={"psi": "Heading"}), "head the right one 'psi'",
        lambda f: f.rename(columns={"Heading": "psi"})),
    "a rudder in degrees": (
        CLEAN.assign(rudder=10.0), r"'rudder \[deg\]'", lambda f: f.rename(columns={"rudder": "rudder [deg]"})),
    "a rudder without a unit": (
        CLEAN.assign(Ruderwinkel=RUDDER), r"'rudder \[rad\]'",
        lambda f: f.rename(columns={"Ruderwinkel": "rudder [rad]"})),
    "a draft in millimetres": (
        CLEAN.assign(draft=163.0), r"'draft \[mm\]'", lambda f: f.rename(columns={"draft": "draft [mm]"})),
    "an offset from the port bank": (
        CLEAN.assign(y=CLEAN.y + 3.5), "subtract half the width, 3.5 m", lambda f: f.assign(y=f.y - 3.5)),
    "an offset in millimetres": (headed({}, y=1e3), r"'y \[mm\]'", lambda f: f.rename(columns={"y": "y [mm]"})),
    "a path in millimetres": (headed({}, x=1e3), r"head 'x \[mm\]'", lambda f: f.rename(columns={"x": "x [mm]"})),
    "speeds in knots": (
        headed({}, u=1 / KNOT, v=1 / KNOT), r"head 'u \[kn\]' and 'v \[kn\]'",
        lambda f: f.rename(columns={"u": "u [kn]", "v": "v [kn]"})),
    "milliseconds without a unit": (
        headed({}, t=1e3), r"head 't \[ms\]'", lambda f: f.rename(columns={"t": "t [ms]"})),
    "velocities along the canal": (
        CLEAN.assign(u=NORTH, v=EAST).drop(columns=RATES), r"u cos\(psi\) \+ v sin\(psi\)",
        lambda f: f.assign(u=f.u * np.cos(f.psi) + f.v * np.sin(f.psi), v=f.v * np.cos(f.psi) - f.u * np.sin(f.psi))),
    "sway to port": (
        CLEAN.assign(v=-CLEAN.v, vdot=-CLEAN.vdot), "sign of 'v' and 'vdot'",
        lambda f: f.assign(v=-f.v, vdot=-f.vdot)),
    "a wrong cell": (
        CLEAN.astype({"Y": object}).assign(Y=CLEAN.Y.astype(object).where(CLEAN.index != 7, f"{CLEAN.Y[7]} N")),
        "row 7, column 'Y' holds .* N, .*mend the cell",
        lambda f: f.assign(Y=f.Y.map(lambda cell: float(str(cell).removesuffix(" N"))))),
    "a row twice": (
        pd.concat([CLEAN[:50], CLEAN[49:]], ignore_index=True), "leave one out", lambda f: f.drop_duplicates()),
    "a test twice": (
        pd.concat([CLEAN, CLEAN[:50]], ignore_index=True), "leave the second ones out", lambda f: f.drop_duplicates()),
    "rows in disorder": (
        CLEAN.sample(frac=1.0, random_state=1), "sort it by time",
        lambda f: f.sort_index()),
    "runs without names": (
        CLEAN.drop(columns="test"), "name the tests in a column 'test'", lambda f: f.assign(test=CLEAN.test)),
    "a row for each channel": (
        CLEAN.melt(["test", "t"], var_name="channel"), "no column is headed as a quantity",
        lambda f: f.pivot(index=["test", "t"], columns="channel", values="value").reset_index()
        .sort_values("test", key=lambda names: names.map(TESTS.names.index), kind="stable")),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_the_remedy_of_a_refusal_works(name: str) -> None:
    frame, sentence, mend = REFUSED[name]
    with pytest.raises(nw.InputError, match=sentence):
        nw.read_captive(frame, TESTS.configuration)
    same(nw.read_captive(mend(frame), TESTS.configuration))


DTC = nw.published("mikkelsen2025_dtc")


def straight_runs() -> pd.DataFrame:
    """Straight runs of a row each: no motion that would show a mistake in another column."""
    places = [(y, psi, u) for y in (-2.5, -1.0, 1.0, 2.5) for psi in (-0.07, 0.0, 0.07) for u in (0.6, 0.9)]
    y, psi, speed = np.array(places).T
    motion = {"y": y, "psi": psi, "u": speed * np.cos(psi), "v": -speed * np.sin(psi)}
    forces = {name: force + np.sin(7 * np.arange(len(y))) for name, force in DTC.forces(**motion).items()}
    still = dict.fromkeys(("r", "udot", "vdot", "rdot", "heave"), 0.0)
    return pd.DataFrame({"test": [f"t{row}" for row in range(len(y))], **motion, **still, **forces})


def test_what_straight_runs_contradict_is_told() -> None:
    runs = straight_runs()
    in_knots = runs.assign(u=runs.u / KNOT, v=runs.v / KNOT)
    told = {
        "exchanged in y": runs.assign(y=-runs.y), "is u in knots": in_knots, "": runs,
    }  # fmt: skip
    for words, table in told.items():
        fit = nw.identify(nw.read_captive(table, DTC.configuration))
        assert any(words in one for one in fit.implausible) if words else not fit.implausible, words
    shallow = replace(DTC.configuration, canal=nw.Canal(7.0, 0.25))
    with pytest.raises(nw.InputError, match=r"chokes the canal.*'u \[kn\]'"):
        nw.read_captive(in_knots, shallow)
    assert nw.read_captive(in_knots.rename(columns={"u": "u [kn]", "v": "v [kn]"}), shallow).rows == len(runs)


def test_what_follows_from_the_other_columns_may_be_absent() -> None:
    found, runs = nw.read_captive(CLEAN.drop(columns=["psi", *RATES]), TESTS.configuration), straight_runs()
    inner = np.ones(found.rows, bool)
    inner[found.starts[:-1]] = inner[found.starts[1:] - 1] = False
    assert np.abs(found["psi"] - TESTS["psi"])[inner].max() < 0.02 * np.abs(TESTS["psi"]).max()
    steady = nw.read_captive(runs.drop(columns=["psi", "r", *RATES]), DTC.configuration)
    np.testing.assert_allclose(steady["psi"], runs.psi, atol=1e-12)
    assert not any(steady[name].any() for name in ("r", *RATES))
    assert nw.identify(steady).coefficients == nw.identify(nw.read_captive(runs, DTC.configuration)).coefficients
    turning = nw.read_captive(runs.assign(r=0.1).drop(columns="psi"), DTC.configuration)
    assert "psi" not in turning.columns
    drift = runs.assign(**{"Drift [deg]": DEG * runs.psi}).drop(columns=["u", "v"])
    with pytest.raises(nw.InputError, match=r"u = U cos\(beta\) and v = -U sin\(beta\), if 'Drift \[deg\]'"):
        nw.identify(drift, ship=DTC.configuration)


DRAFTED: dict[str, tuple[pd.DataFrame, str]] = {
    "headers of nobody": (headed({"v": "Geschw. quer"}), 'v = "Geschw. quer"  # GUESSED'),
    "headers of any axes": (headed({"u": "Vx [m/s]", "v": "Vy [m/s]", "r": "wz [rad/s]"}), 'v = "Vy [m/s]"  # GUESSED'),
    "shortened headers": (
        headed({"y": "Offset [mm]", "psi": "Hdg", "Y": "Sway F [N]"}, y=1e3, psi=DEG),
        'psi = "deg"  # GUESSED',
    ),
    "a rudder of many degrees": (headed({"rudder": "Ruder"}, CLEAN.assign(rudder=30.0)), 'rudder = "deg"  # sure'),
    "German, shortened": (
        headed({"t": "Zeit [s]", "test": "Lauf", "psi": "Hdg", "u": "Geschw. längs", "v": "Geschw. quer",
                "r": "Drehrate [deg/s]", "y": "Ablage [m]", "X": "Fx [N]", "Y": "Querkr. [N]", "N": "Giermom. [Nm]"},
               CLEAN.drop(columns=[*RATES, "x"]), psi=DEG, r=DEG),
        'Y = "Querkr. [N]"  # GUESSED',
    ),
    "upper case": (
        headed({"psi": "PSI", "u": "U", "v": "V", "r": "R", "t": "T", "test": "TEST"}), 'psi = "rad"  # GUESSED',
    ),
    "a propeller": (
        headed({"v": "Geschw. quer"}, CLEAN.assign(**{"Prop. [rpm]": 60.0})), 'revolutions = "Prop. [rpm]"  # GUESSED',
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", DRAFTED)
def test_a_draft_of_columns_is_read_once_it_is_confirmed(name: str, tmp_path: Path, ship_file: Path, cli) -> None:
    frame, line = DRAFTED[name]
    table, draft = put(tmp_path, frame), tmp_path / "columns.toml"
    code, _, told = cli("identify", table, "--ship", ship_file, "--pass-over", "rudder")
    assert code == 2
    assert f"type narrows identify {table} --ship {ship_file} --mapping {draft}" in told
    assert line in draft.read_text()
    same(nw.read_captive(table, ship_file, mapping=draft))


def test_a_confirmed_draft_is_used_without_being_named(tmp_path: Path, ship_file: Path, cli) -> None:
    table, draft = put(tmp_path, DRAFTED["headers of nobody"][0]), tmp_path / "columns.toml"
    assert cli("identify", table, "--ship", ship_file)[0] == 2
    draft.write_text(draft.read_text().replace("confirmed = false", "confirmed = true"))
    model = tmp_path / "m.toml"
    assert cli("identify", table, "--ship", ship_file, "-o", model)[0] == 0
    assert cli("explain", model, table, "--compare", "paper")[0] == 0
    small = ("--runs", 2, "--speed", "0.6", "--run-length", 20)
    assert cli("plan", ship_file, *small, "--after", table)[0] in (0, 1)  # 1: not determined


def test_a_column_that_may_be_a_quantity_is_told() -> None:
    """A rudder that moves unread would be taken for the hull's force."""
    notes = nw.read_captive(CLEAN.assign(**{"Rudd. ang": 30.0}), TESTS.configuration).notes
    assert "column 'Rudd. ang' is not read: is it rudder?" in notes


def test_rows_across_the_canal_go_by_the_selection_that_is_named(tmp_path: Path, ship_file: Path, cli) -> None:
    frame = CLEAN.assign(psi=np.degrees(CLEAN.psi)).rename(columns={"psi": "psi [deg]"})
    table = put(tmp_path, pd.concat([frame.head(1).assign(**{"psi [deg]": 90.0, "test": "across"}), frame]))
    code, _, told = cli("identify", table, "--ship", ship_file, "--pass-over", "rudder")
    where = re.search(r"--where '(.*)'", told)
    assert code == 2
    assert where is not None
    for words in (where[1], "abs(`psi [deg]`) < 90"):
        assert nw.read_captive(table, ship_file, where=words).rows == len(CLEAN)


def test_an_absent_ship_file_is_described_so_that_it_can_be_written(tmp_path: Path, cli) -> None:
    table = put(tmp_path, CLEAN)
    code, _, told = cli("identify", table, "--ship", tmp_path / "ship.toml")
    assert code == 2
    values = {"length": 4.4, "beam": 0.6, "draft": 0.2, "block_coefficient": 0.65, "width": 7.0, "depth": 0.4}
    parts = re.findall(rf"\[(?:ship|canal)\]|\b(?:{'|'.join(values)})\b", told.partition("write one")[2])
    lines = [part if part.startswith("[") else f"{part} = {values[part]}" for part in parts]
    (tmp_path / "ship.toml").write_text("\n".join(lines))
    found = nw.read_ship(tmp_path / "ship.toml")
    assert (found.ship.block_coefficient, found.canal.depth) == (0.65, 0.4)


def test_a_propeller_that_the_table_names_explains_a_small_resistance(kcs_tests: dict[int, nw.CaptiveTests]) -> None:
    """Self-propelled tests of a laboratory: no question whether a propeller pushes."""
    measured = kcs_tests[20]
    frame = measured.to_dataframe().assign(X=lambda rows: 0.1 * rows["X"])
    bare = frame.drop(columns="revolutions")
    for table, asked in ((bare, True), (bare.assign(**{"Propeller rate [1/s]": frame["revolutions"]}), False)):
        fit = nw.identify(nw.read_captive(table, measured.configuration))
        assert any("does a propeller push" in sentence for sentence in fit.implausible) is asked


def test_a_draft_is_not_written_over(tmp_path: Path, ship_file: Path, cli) -> None:
    table = put(tmp_path, DRAFTED["headers of nobody"][0])
    (tmp_path / "columns.toml").write_text("[columns]\n")
    code, _, told = cli("identify", table, "--ship", ship_file)
    assert code == 2
    assert re.search("columns.toml is there: check it", told)
    assert (tmp_path / "columns.toml").read_text() == "[columns]\n"
    (tmp_path / "columns.toml").write_text('[columns]\nu = "Speed of another table"\n')
    assert f"--mapping {tmp_path / 'lab.columns.toml'}" in cli("identify", table, "--ship", ship_file)[2]


@pytest.mark.parametrize("rows", [0, 1, 2, 9])
@pytest.mark.parametrize("value", [0.0, np.nan, np.inf, 1e300])
def test_a_table_of_few_or_no_numbers_is_drafted_without_a_fault(rows: int, value: float) -> None:
    frame = (
        CLEAN[:rows].assign(**{'a"b\\': value, "Run [x]": 1.0}).rename(columns={"psi": "Heading", "r": "R", "u": "Ü"})
    )
    read = tomllib.loads(draft_columns(frame, "lab.csv", "narrows identify"))
    assert read["columns"]["psi"] == "Heading"


def test_a_surge_force_counted_astern_is_told(kcs_fits: dict[int, nw.Fit]) -> None:
    """On measured tests, where noise hides which sign fits better."""
    measured = kcs_fits[20].tests
    frame = measured.to_dataframe()
    assert not any("counted astern" in sentence for sentence in kcs_fits[20].implausible)
    turned = nw.read_captive(frame.assign(X=-frame["X"]), measured.configuration)
    assert any("X" in sentence and "counted astern" in sentence for sentence in nw.identify(turned).implausible)
