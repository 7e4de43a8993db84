"""Tables in the words of laboratories: each is read as the documented one, or its refusal leads to one that is."""

import re

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from tables import frame_of, short_twin

TESTS = short_twin()
DEG = 180 / np.pi
KNOT = 1852 / 3600


def plain() -> pd.DataFrame:
    return frame_of(TESTS)


def headed(words: dict[str, str], **factors: float) -> pd.DataFrame:
    """The table under other headers, its numbers in their units."""
    frame = plain()
    for name, factor in factors.items():
        frame[name] = frame[name] * factor
    return frame.rename(columns=words)


IN_DEGREES = {"psi": DEG, "r": DEG, "rdot": DEG}
READ = {
    "English, units in brackets": headed(
        {"psi": "Heading [deg]", "v": "Sway velocity [m/s]", "u": "Surge velocity [m/s]", "r": "Yaw rate [deg/s]",
         "rdot": "Yaw acceleration [deg/s²]", "N": "Yaw moment [Nm]", "t": "Time [s]"}, **IN_DEGREES),
    "English, units after a comma": headed(
        {"psi": "Yaw angle, deg", "r": "Rate of turn, deg/s", "rdot": "r dot [deg/s2]", "y": "Sway position, mm"},
        **IN_DEGREES, y=1e3),
    "English, upper case": headed({"test": "RUN NO", "t": "TIME (s)", "X": "FX (N)", "Y": "FY (N)", "N": "MZ (Nm)"}),
    "German, Grad": headed(
        {"t": "Zeit / s", "test": "Versuch", "psi": "Kurswinkel / Grad", "r": "Gierrate / Grad/s",
         "u": "Längsgeschwindigkeit [m/s]", "v": "Quergeschwindigkeit [m/s]", "X": "Längskraft [N]",
         "Y": "Querkraft [kN]", "N": "Giermoment [Nm]"}, psi=DEG, r=DEG, Y=1e-3),
    "German without umlauts": headed({"u": "Laengsgeschwindigkeit [kn]", "v": "Quergeschwindigkeit [kn]"},
                                     u=1 / KNOT, v=1 / KNOT),
    "Dutch": headed(
        {"t": "Tijd [s]", "test": "Proef", "psi": "Koershoek [graden]", "u": "Langssnelheid [m/s]",
         "v": "Dwarssnelheid [m/s]", "r": "Giersnelheid [graden/s]", "Y": "Dwarskracht [N]"}, psi=DEG, r=DEG),
    "Chinese": headed(
        {"t": "时间 [秒]", "test": "试验编号", "psi": "艏向角 [度]", "u": "纵向速度 [m/s]", "v": "横向速度 [m/s]",
         "r": "艏摇角速度 [度/s]", "X": "纵向力 [N]", "Y": "横向力 [N]", "N": "艏摇力矩 [Nm]"}, psi=DEG, r=DEG),
    "knots": headed({"u": "Surge speed (kn)", "v": "Sway speed (kn)"}, u=1 / KNOT, v=1 / KNOT),
    "underscores": headed({"psi": "heading_deg", "r": "yaw_rate", "v": "sway_velocity"}, psi=DEG),
    "Greek": headed({"psi": "ψ [deg]"}, psi=DEG),
    "without accelerations": plain().drop(columns=["udot", "vdot", "rdot"]),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_a_table_in_other_words_is_read(name: str) -> None:
    read = nw.read_captive(READ[name], TESTS.configuration)
    for column in ("t", "y", "psi", "u", "v", "r", "X", "Y", "N"):
        np.testing.assert_allclose(read[column], TESTS[column], rtol=1e-9, atol=1e-12, err_msg=column)
    inner = np.ones(read.rows, bool)
    inner[read.starts[:-1]] = inner[read.starts[1:] - 1] = False
    assert np.abs(read["vdot"] - TESTS["vdot"])[inner].max() < 0.05 * np.abs(TESTS["vdot"]).max()
    assert len(read.notes) > len(TESTS.notes) or name == "plain"


REFUSED = {
    "degrees without a unit": (headed({"psi": "Heading"}, psi=DEG), {"Heading": "psi [deg]"}),
    "two headings": (plain().assign(Kurswinkel=0.0).rename(columns={"psi": "Heading"}), {"Heading": "psi"}),
    "a speed of nobody": (headed({"u": "Geschw."}), {"Geschw.": "u"}),
    "a force of nobody": (headed({"Y": "Kanal 7"}), {"Kanal 7": "Y"}),
}


@pytest.mark.parametrize("name", REFUSED)
def test_the_remedy_of_a_refusal_works(name: str) -> None:
    frame, remedy = REFUSED[name]
    with pytest.raises(nw.InputError) as told:
        nw.identify(nw.read_captive(frame, TESTS.configuration))
    assert all(re.search(re.escape(word.split(" ")[0]), str(told.value)) for word in remedy.values())
    read = nw.read_captive(frame.rename(columns=remedy), TESTS.configuration)
    assert nw.identify(read).coefficients


def test_the_sheet_with_the_numbers_is_read(tmp_path) -> None:
    path = tmp_path / "lab.xlsx"
    with pd.ExcelWriter(path) as book:
        pd.DataFrame({"Project": ["bank tests"], "Date": ["2026"]}).to_excel(book, sheet_name="Info", index=False)
        plain().to_excel(book, sheet_name="Data", index=False)
    read = nw.read_captive(path, TESTS.configuration)
    assert read.rows == TESTS.rows
    assert any("'Data' is read" in note for note in read.notes)


def test_a_group_row_over_the_names(tmp_path) -> None:
    """Merged cells over the header: a row of groups, then the names, then the units."""
    path, frame = tmp_path / "lab.csv", plain()
    groups = ";".join(["Run", "Motion", *[""] * (len(frame.columns) - 2)])
    body = frame.to_csv(index=False, sep=";", decimal=",")
    path.write_text(f"{groups}\n{body}", encoding="utf-8")
    np.testing.assert_allclose(nw.read_captive(path, TESTS.configuration)["Y"], TESTS["Y"])


def test_a_surge_force_counted_astern_is_told() -> None:
    """On measured tests, where noise hides which sign fits better."""
    measured = nw.measured_tests("kcs").by_condition()["C0101A02"]
    frame = measured.to_dataframe()
    assert not any("counted astern" in sentence for sentence in nw.identify(measured).implausible)
    turned = nw.read_captive(frame.assign(X=-frame["X"]), measured.configuration)
    assert any("X" in sentence and "counted astern" in sentence for sentence in nw.identify(turned).implausible)
