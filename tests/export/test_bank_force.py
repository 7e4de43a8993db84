"""The bank's force in other languages beside ``model.bank_forces``: each compiled or run where its tools are."""

import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported import model_of
from scipy.integrate import solve_ivp

import narrows as nw
from narrows.model.data_range import DataRange
from narrows.ship.particulars import equivalent_wall

FIELDS = ("starboard", "port", "slope_starboard", "slope_port", "depth")
C = """#include <stdio.h>
#include "bank.h"
int main(void) {{
    const double at[][8] = {rows};
    for (unsigned i = 0; i < sizeof at / sizeof *at; ++i) {{
        const bank_water water = {{at[i][3], at[i][4], at[i][5], at[i][6], at[i][7]}};
        const bank_force f = bank_bank_force(at[i][0], at[i][1], at[i][2], &water);
        printf("%.17g %.17g %.17g %.17g %d\\n", f.Y, f.N, f.Y_deviation, f.N_deviation, f.beyond);
    }}
    return 0;
}}
"""
CSHARP = """using System;
class Host {{
    static void Main() {{
        double[,] at = {rows};
        for (int i = 0; i < at.GetLength(0); ++i) {{
            var water = new bank.Water {{ starboard = at[i, 3], port = at[i, 4], slopeStarboard = at[i, 5],
                slopePort = at[i, 6], depth = at[i, 7] }};
            var f = bank.BankForce(at[i, 0], at[i, 1], at[i, 2], water);
            Console.WriteLine(string.Format(System.Globalization.CultureInfo.InvariantCulture,
                "{{0:R}} {{1:R}} {{2:R}} {{3:R}} {{4}}", f.Y, f.N, f.YDeviation, f.NDeviation, f.beyond));
        }}
    }}
}}
"""
NODE = """import {{ bankForce }} from "./bank.mjs";
for (const [y, psi, u, starboard, port, slopeStarboard, slopePort, depth] of {rows}) {{
    const f = bankForce(y, psi, u, {{ starboard, port, slopeStarboard, slopePort, depth }});
    console.log([f.Y, f.N, f.YDeviation, f.NDeviation, f.beyond].join(" "));
}}
"""
MATLAB = """at = {rows};
water = struct('starboard', at(:, 4), 'port', at(:, 5), 'slope_starboard', at(:, 6), 'slope_port', at(:, 7), ...
               'depth', at(:, 8));
[Y, N, Y_deviation, N_deviation, beyond] = bank(at(:, 1), at(:, 2), at(:, 3), water);
printf('%.17g %.17g %.17g %.17g %d\\n', [Y, N, Y_deviation, N_deviation, beyond]');
"""
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
# By language: the file, the program beside it, rows as the language writes them, commands.
LANGUAGES: dict[str, Any] = {
    "c": ("bank.h", "host.c", C, "{}", [["gcc", "-std=c99", *WARNINGS, "host.c", "-o", "host", "-lm"], ["./host"]]),
    "cpp": ("bank.h", "host.cpp", C, "{}", [["g++", "-std=c++11", *WARNINGS, "host.cpp", "-o", "host"], ["./host"]]),
    "csharp": ("bank.cs", "Host.cs", CSHARP, "{}", [["mcs", "-warnaserror", "-out:host.exe", "Host.cs", "bank.cs"],
                                                    ["mono", "host.exe"]]),
    "javascript": ("bank.mjs", "host.mjs", NODE, "[]", [["node", "host.mjs"]]),
    "octave": ("bank.m", "host.m", MATLAB, "[]", [["octave", "--no-gui", "--norc", "host.m"]]),
}  # fmt: skip


def settled(name: str) -> nw.Model:
    """A model with a covariance that correlates everything, and a range of data."""
    model, n = model_of(name), len(model_of(name).terms)
    mix = np.random.default_rng(5).normal(size=(n, n)) * 0.01
    covered = DataRange((0.5, 1.2), (0.0, 0.9), (0.0, 0.1), None, (1.0, 3.0), (10.0, 14.0))
    return replace(model, covariance=mix @ mix.T, data_range=covered)


ROWS = np.array([
    [0.5, 0.0, 1.0, 3.5, 3.5, 0.0, 0.0, 0.3], [-0.8, 0.2, 0.7, 3.5, 3.5, 0.0, 0.0, 0.3],
    [0.3, -0.1, 1.4, 3.0, 3.8, 2.0, 1.0, 0.35], [1.6, 0.05, 0.9, 4.0, 3.0, 3.0, 0.0, 0.25],
    [2.4, 0.5, 1.0, 3.5, 3.5, 0.0, 0.0, 0.3], [-3.3, 0.0, 1.0, 3.5, 3.5, 0.0, 0.0, 0.3],
    [4.02, 0.0, 1.0, 4.0, 3.0, 3.0, 0.0, 0.25],  # The keel of 0.163 m lies on the slope, short of the equivalent wall.
])  # fmt: skip
# With as much water as the draft of 0.163 m, or less, the force is no number, as ``nw.bank_force`` refuses it; nor at a
# place or a heading of a simulator whose numbers have diverged.
AGROUND = [[0.5, 0.0, 1.0, 3.5, 3.5, 0.0, 2.0, depth] for depth in (0.163, 0.1, 0.0, -1.0)]
AGROUND += [[y, psi, 1.0, 3.5, 3.5, 0.0, 0.0, 0.3] for y, psi in ((np.nan, 0.0), (0.5, np.nan))]


def expected(model: nw.Model, row: np.ndarray) -> list[float]:
    """By the model's own forces in the canal of the equivalent walls, and by the spread of its coefficients."""
    y, psi, u, starboard, port, slope_starboard, slope_port, depth = row
    feet = ((starboard, slope_starboard), (port, slope_port))
    walls = [
        equivalent_wall(((foot, 0.0), (foot + slope * depth, depth)), depth) if slope else foot for foot, slope in feet
    ]
    there = model.with_canal(width=sum(walls), depth=depth)
    motion = nw.Motion.at(y=y - (walls[0] - walls[1]) / 2, psi=psi, u=u)
    forces = there.bank_forces(motion)
    slopes = {force: np.zeros(len(model.terms)) for force in "YN"}
    for place, name in enumerate(model.terms.names):
        if model.terms[name].from_bank:
            more = there.with_coefficients({name: model[name] + 1.0}).bank_forces(motion)
            for force, slope in slopes.items():
                slope[place] = more[force] - forces[force]
    deviations = [np.sqrt(slope @ model.covariance @ slope) for slope in slopes.values()]
    ship, known = model.configuration.ship, model.data_range
    asked = {"speed": (1, u), "abs_y": (2, abs(motion.y)), "abs_psi": (4, abs(psi)),
             "width_to_beam": (16, sum(walls) / ship.beam), "depth_to_draft": (32, depth / ship.draft)}  # fmt: skip
    beyond = sum(bit for name, (bit, value) in asked.items() if known.outside(name, value))
    # The corners of the hull's rectangle, turned about midship.
    corners = [y + ahead * np.sin(psi) + side * np.cos(psi) for ahead in (-1.992, 1.992) for side in (-0.286, 0.286)]
    ends = [min(wall, foot + slope * (depth - 0.163)) for wall, (foot, slope) in zip(walls, feet, strict=True)]
    beyond += 64 * (max(corners) >= ends[0] or min(corners) <= -ends[1])
    return [forces["Y"], forces["N"], *deviations, beyond]


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", ["paper", "paper+keel_gap", "paper+tapered"])
def test_the_force_is_that_of_the_model(language: str, name: str, tmp_path: Path) -> None:
    file, host, text, brackets, commands = LANGUAGES[language]
    if any(shutil.which(command[0]) is None for command in commands if not command[0].startswith(".")):
        pytest.skip(f"no {commands[0][0]} is here")
    model = settled(name)
    nw.export.write(model, tmp_path / file, kind="bank-force")
    rows = json.dumps([*ROWS.tolist(), *AGROUND]).replace("NaN", "0.0 / 0.0")
    if language == "octave":
        rows = rows.replace("], [", "; ").replace("[[", "[").replace("]]", "]")
    rows = rows.replace("[", brackets[0]).replace("]", brackets[1])
    (tmp_path / host).write_text(text.format(rows=rows), encoding="utf-8")
    for command in commands:
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
    said = np.array([line.split() for line in done.stdout.splitlines()], float)
    said, aground = np.split(said, [len(ROWS)])
    assert np.isnan(aground[:, :4]).all()
    assert (aground[:, 4] >= 64).all()
    np.testing.assert_allclose(said, [expected(model, row) for row in ROWS], rtol=1e-14)
    assert set(said[:, 4]) >= {0.0}
    assert len(set(said[:, 4] % 64)) > 2
    assert sum(said[:, 4] >= 64) == 3


@pytest.mark.parametrize("name", ["paper", "paper+keel_gap", "paper+tapered", "steered"])
def test_the_call_of_python(name: str) -> None:
    """One question at a time, and all of them at once."""
    model = settled(name)
    y, psi, u, starboard, port, slope_starboard, slope_port, depth = ROWS.T
    water = {"starboard": starboard, "port": port, "slope_starboard": slope_starboard, "slope_port": slope_port,
             "depth": depth}  # fmt: skip
    answers = nw.bank_force(model, y, u, psi, **water)
    np.testing.assert_allclose(answers.to_dataframe(), [expected(model, row) for row in ROWS], rtol=1e-14)
    for number, row in enumerate(ROWS):
        one = nw.bank_force(model, row[0], row[2], row[1], **{name: value[number] for name, value in water.items()})
        np.testing.assert_array_equal(one.to_dataframe(), answers.to_dataframe()[number : number + 1])
    assert "beyond the data" in answers.summary().lower()


def test_the_canal_of_the_model_is_meant_unless_given() -> None:
    model = nw.published("mikkelsen2025_dtc")
    force = nw.bank_force(model, 0.5, 1.0, 0.1)
    known = model.bank_forces(nw.Motion.at(y=0.5, psi=0.1, u=1.0))
    assert (force.Y, force.N) == pytest.approx((known["Y"], known["N"]), rel=1e-14)
    assert np.isnan(force.Y_deviation) == (model.covariance is None)
    assert [nw.bank_force(model, 0.0, 1.0, psi).beyond for psi in (0.7, 1.0)] == [0, 4]


@pytest.mark.parametrize(
    ("told", "message"),
    [({"starboard": -9.0}, "no water"), ({"depth": 0.1}, "no water"), ({"starboard": np.nan}, "no water")],
)
def test_water_that_is_none_is_refused(told: dict[str, float], message: str) -> None:
    with pytest.raises(nw.InputError, match=message):
        nw.bank_force(nw.published("mikkelsen2025_dtc"), 0.5, 1.0, **told)


def test_a_slope_needs_a_depth_and_a_model_needs_a_bank() -> None:
    model = nw.published("mikkelsen2025_dtc")
    dry = replace(model, configuration=replace(model.configuration, canal=nw.Canal(7.0)))
    with pytest.raises(nw.InputError, match="depth"):
        nw.bank_force(dry, 0.5, 1.0, slope_port=2.0)
    with pytest.raises(nw.InputError, match="mmg\\+delta"):
        nw.bank_force(nw.published("yasukawa2015_kvlcc2"), 0.5, 1.0)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no C compiler is here")
@pytest.mark.parametrize("exchange", [False, True])
@pytest.mark.parametrize("fmi", [2, 3])
def test_the_fmu_without_states(fmi: int, exchange: bool, tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
    from fmpy.validation import validate_fmu
    from fmus import Imported

    model = settled("paper+keel_gap")
    nw.export.write(model, tmp_path / "bank.fmu", fmi=fmi, kind="bank-force")
    assert validate_fmu(str(tmp_path / "bank.fmu")) == []
    assert fmpy.read_model_description(str(tmp_path / "bank.fmu")).numberOfContinuousStates in (0, None)
    fmu, names = Imported(tmp_path / "bank.fmu", exchange).start(), ("y", "psi", "u", *FIELDS)
    said = []
    for number, row in enumerate(ROWS):
        fmu.set(**dict(zip(names, row, strict=True)))
        if not exchange:
            fmu.step(float(number), 1.0)
        said.append([*fmu.get("Y", "N", "Y_deviation", "N_deviation"), fmu.whole("beyond")])
    np.testing.assert_allclose(said, [expected(model, row) for row in ROWS], rtol=1e-14)
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmu.slope(["Y"], ["y"], [1.0])
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmu.set(depth=-1.0)


def test_an_fmu_without_deviations_has_no_variables_of_them(tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
    nw.export.write(replace(settled("paper"), covariance=None), tmp_path / "bank.fmu", kind="bank-force")
    names = {one.name for one in fmpy.read_model_description(str(tmp_path / "bank.fmu")).modelVariables}
    assert {"Y", "N", "beyond", "depth"} <= names
    assert not any("deviation" in name for name in names)


def test_a_model_without_a_bank_is_refused_with_a_table_that_has_one(tmp_path: Path) -> None:
    with pytest.raises(nw.InputError, match="mmg\\+delta"):
        nw.export.write(nw.published("yasukawa2015_kvlcc2"), tmp_path / "bank.h", kind="bank-force")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler is here")
def test_the_lines_of_the_docs_give_the_numbers_of_the_docs(tmp_path: Path) -> None:
    """Also from north, east and course, and about a centre of gravity ahead of midship, as its table says.

    One degree given as a radian is a heading of 57 degrees, and counts as not tested.
    """
    page = Path(__file__).parents[2].joinpath("docs", "bank-force.md").read_text(encoding="utf-8")
    lines = page.split("```cpp\n")[1].split("```")[0]
    rule = page.split("`y = (east")[1].split("`")[0]
    text = f"""#include <cstdio>
#include "canal.h"
using namespace std;
int main() {{
    const double c = 1.1, n0 = 3.0, e0 = -2.0, x_G = 0.4, heading = c + 0.1, psi = heading - c, u = 1.0;
    const double north = n0 + 5.0 * cos(c) - 0.8 * sin(c), east = e0 + 5.0 * sin(c) + 0.8 * cos(c);
    const double y_G = (east{rule} + x_G * sin(psi);
    const double y = y_G - x_G * sin(psi);
    double Y = 0.0, N = 0.0;
    {lines}
    printf("%.17g %.17g %.17g", Y, N, N - x_G * Y);
    return canal_bank_force(0.0, 0.7, u, &water).beyond & 4 || !(canal_bank_force(0.0, 1.0, u, &water).beyond & 4);
}}
"""
    (tmp_path / "main.cpp").write_text(text, encoding="utf-8")
    model = nw.published("mikkelsen2025_dtc")
    nw.export.write(model, tmp_path / "canal.h", kind="bank-force")
    subprocess.run(["g++", "-std=c++11", *WARNINGS, "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    done = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True, check=True)
    force = nw.bank_force(model, 0.8, 1.0, 0.1, starboard=3.5, port=3.2, depth=0.3)
    assert [*map(float, done.stdout.split())] == pytest.approx([force.Y, force.N, force.N - 0.4 * force.Y], rel=1e-12)


HOSTS = {
    "host.cpp": ("canal.h", [["g++", "-std=c++11", *WARNINGS, "host.cpp", "-o", "host"], ["./host"]]),
    "Host.cs": ("canal.cs", [["mcs", "-warnaserror", "Host.cs", "canal.cs"], ["mono", "Host.exe"]]),
}


@pytest.mark.parametrize("host", HOSTS)
def test_the_hosts_of_the_docs_run_and_agree(host: str, tmp_path: Path) -> None:
    """A simulator with a hull of its own, in C++ and C#: with banks it goes where SciPy says it does."""
    file, commands = HOSTS[host]
    if any(shutil.which(command[0]) is None for command in commands if not command[0].startswith(".")):
        pytest.skip(f"no {commands[0][0]} is here")
    root = Path(__file__).parents[2]
    text = (root / "examples" / "simulator" / host).read_text(encoding="utf-8")
    page = (root / "docs" / "bank-force.md").read_text(encoding="utf-8")
    assert f"```{{literalinclude}} ../examples/simulator/{host}" in page
    assert len(text.splitlines()) < 66
    (tmp_path / host).write_text(text, encoding="utf-8")
    model = nw.published("mikkelsen2025_dtc")
    nw.export.write(model, tmp_path / file, kind="bank-force")
    for command in commands:
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr

    def rates(t: float, s: Any) -> list[float]:
        y, psi, v, r = s[1:]
        forces = model.bank_forces(nw.Motion.at(y=y, psi=psi, u=1.0))  # Up to x = 20 m the canal is that of the tests.
        Y, N = forces["Y"] - 100.0 * v - 118.0 * r, forces["N"] - 85.0 * v - 590.0 * r
        return [np.cos(psi) - v * np.sin(psi), np.sin(psi) + v * np.cos(psi), r, Y / 980.0, N / 960.0]

    end = solve_ivp(rates, (0.0, 8.0), [0.0, 0.8, 0.0, 0.0, 0.0], rtol=1e-9, atol=1e-9).y[:, -1]
    without, with_banks = done.stdout.splitlines()
    assert "y 0.80 m, heading 0.0 deg" in without
    reached = f"y {end[1]:.2f} m, heading {np.degrees(end[2]):.1f} deg"
    assert reached in with_banks
    assert reached in page
