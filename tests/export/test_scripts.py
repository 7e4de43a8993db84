"""The exported ES module, Python file and equations beside the package."""

import importlib.util
import json
import runpy
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported import STEERED, bent, model_of, speed_of, states

import narrows as nw
from narrows.model.data_range import DataRange
from narrows.model.water import speeds_afloat

CASES = [("own", False), ("steered", True)]
NODE = shutil.which("node")
SCRIPT = """
import * as ship from "./ship.mjs";
import { readFileSync } from "fs";
const { states, inputs, u, order } = JSON.parse(readFileSync("given.json"));
const at = { ...ship.atRest, ...inputs }, constants = ship.prepare(ship.model), plain = (values) => Array.from(values);
const water = ship.canal === undefined ? [] : [ship.canal];
const rates = states.map((state) => plain(ship.rates(state, at, constants, ...water)));
const slopes = ["byState", "byInput", "byCoefficient"].map((name) =>
    states.map((state) => plain(ship[name](state, at, constants, ...water))));
const state = ship.rest(), end = [0, 0];
state[ship.X] = 6.0; state[ship.Y] = 0.5; state[ship.U] = u;
const held = order === null ? ship.atRest : { ...ship.atRest, rudder_order: order };
const outcome = ship.integrate(state, held, constants, ...water, 0.05, 60.0, end);
console.log(JSON.stringify({ rates, slopes, outcome, end, state: plain(state) }));
"""


def python_of(name: str, folder: Path, **choices: Any) -> Any:
    nw.export.write(model_of(name), folder / "ship.py", **choices)
    spec = importlib.util.spec_from_file_location(f"ship_{name.replace('+', '_')}", folder / "ship.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def expected(name: str, state: np.ndarray) -> tuple[np.ndarray, Any]:
    x, y, cosine, sine, u, v, r, *rudder = state
    positions = dict(zip(("rudder",), rudder, strict=False))
    rates = nw.derivative(model_of(name), [x, y, np.arctan2(sine, cosine), u, v, r], Y=0.7, N=-0.4, **positions)
    return rates[[0, 1, 3, 4, 5]], positions


def reached(state: Any) -> list[float]:
    return [state[0], state[1], np.arctan2(state[3], state[2]), *state[4:7]]


def sailed(name: str, curved: bool) -> nw.Outcome:
    told = {"controller": nw.ConstantRudder(0.1)} if name in STEERED else {}
    way = bent(name) if curved else None
    return nw.simulate(model_of(name), x=6.0, y=0.5, u=speed_of(name), dt=0.05, waterway=way, **told).outcome


@pytest.mark.parametrize(("name", "curved"), CASES)
def test_the_python_file(tmp_path: Path, name: str, curved: bool) -> None:
    ship = python_of(name, tmp_path, waterway=bent(name) if curved else None)
    water = ship.CANAL if curved else None
    constants, at = ship.prepare(ship.MODEL), states(name, 6)
    ship.AT_REST.Y_in, ship.AT_REST.N_in = 0.7, -0.4
    columns = ship.rates(at.T, ship.AT_REST, constants, water)
    for number, state in enumerate(at):
        rates = ship.rates(state, ship.AT_REST, constants, water)
        np.testing.assert_allclose(columns[:, number], rates, rtol=1e-12, atol=1e-14)
        if not curved:
            np.testing.assert_allclose(rates[[0, 1, 4, 5, 6]], expected(name, state)[0], rtol=1e-12, atol=1e-12)
    ship.AT_REST.Y_in, ship.AT_REST.N_in = 0.0, 0.0
    if name in STEERED:
        ship.AT_REST.rudder_order = 0.1
    start, end, outcome = ship.rest(), np.zeros(2), sailed(name, curved)
    start[[ship.X, ship.Y, ship.U]] = 6.0, 0.5, speed_of(name)
    assert ship.integrate(start, ship.AT_REST, constants, water, 0.05, 60.0, end) == ship.GROUNDED
    np.testing.assert_allclose(reached(start), list(outcome.state.values()), rtol=1e-10, atol=1e-10)
    assert end[0] == pytest.approx(outcome.time, rel=1e-10)


BOUNDED = DataRange((0.6, 1.1), (0.0, 0.9), (0.0, 0.2), (0.0, 0.15))
BEYOND_SCRIPT = """
import * as ship from "./ship.mjs";
import { readFileSync } from "fs";
const constants = ship.prepare(ship.model);
console.log(JSON.stringify(JSON.parse(readFileSync("given.json")).map((at) => ship.beyond(at, constants))));
"""


def bits(state: np.ndarray) -> int:
    """By the rule of the package, a measure at a time."""
    _, y, cosine, sine, u, _, r = state
    sizes = {"speed": u, "abs_y": abs(y), "abs_psi": abs(np.arctan2(sine, cosine)), "abs_r": abs(r)}
    out = sum(bit * bool(BOUNDED.outside(name, sizes[name])) for name, bit in zip(sizes, (1, 2, 4, 8), strict=True))
    return out + 128 * bool(abs(u) > min(speeds_afloat(model_of("paper").configuration.values())))


def test_beyond_the_tests_in_python_and_javascript(tmp_path: Path) -> None:
    model, at = replace(model_of("paper"), data_range=BOUNDED), 1.6 * states("paper", 40)
    nw.export.write(model, tmp_path / "ship.py")
    ship = runpy.run_path(str(tmp_path / "ship.py"))
    right, constants = [bits(state) for state in at], ship["prepare"](ship["MODEL"])
    assert set(right) > {0, 1, 2, 8}
    assert [int(ship["beyond"](state, constants)) for state in at] == right
    assert ship["beyond"](at.T, constants).tolist() == right
    if NODE is None:
        pytest.skip("no node is here to run the exported module")
    nw.export.write(model, tmp_path / "ship.mjs")
    (tmp_path / "given.json").write_text(json.dumps(at.tolist()), encoding="utf-8")
    (tmp_path / "run.mjs").write_text(BEYOND_SCRIPT, encoding="utf-8")
    done = subprocess.run([NODE, "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == right


def test_the_python_file_needs_numpy_alone(tmp_path: Path) -> None:
    nw.export.write(model_of("paper"), tmp_path / "ship.py")
    check = "import sys, ship; print([name for name in ('narrows', 'sympy', 'numba', 'scipy') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", check], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.skipif(NODE is None, reason="no node is here to run the exported module")
@pytest.mark.parametrize(("name", "curved"), CASES)
def test_the_module(tmp_path: Path, name: str, curved: bool) -> None:
    """Node's sine and powers are its own: a last place off here and there."""
    way = bent(name) if curved else None
    nw.export.write(model_of(name), tmp_path / "ship.mjs", waterway=way)
    at, push = states(name, 6), {"Y_in": 0.7, "N_in": -0.4}
    told = {"states": at.tolist(), "inputs": push, "u": speed_of(name), "order": 0.1 if name in STEERED else None}
    (tmp_path / "given.json").write_text(json.dumps(told), encoding="utf-8")
    (tmp_path / "run.mjs").write_text(SCRIPT, encoding="utf-8")
    done = subprocess.run([NODE, "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    said, ship = json.loads(done.stdout), python_of(name, tmp_path, waterway=way)
    constants = ship.prepare(ship.MODEL)
    ship.AT_REST.Y_in, ship.AT_REST.N_in = 0.7, -0.4
    for number, state in enumerate(at):
        given = (state, ship.AT_REST, constants, getattr(ship, "CANAL", None))
        np.testing.assert_allclose(said["rates"][number], ship.rates(*given), rtol=1e-12, atol=1e-12)
        for slopes, function in zip(said["slopes"], (ship.by_state, ship.by_input, ship.by_coefficient), strict=True):
            np.testing.assert_allclose(slopes[number], function(*given).ravel(), rtol=1e-11, atol=1e-12)
    outcome = sailed(name, curved)
    assert said["outcome"] == 1
    np.testing.assert_allclose(reached(said["state"]), list(outcome.state.values()), rtol=1e-10, atol=1e-10)


# Ships whose equations are typeset, with their pages.
PRINTED = {"mikkelsen2025_dtc": 1, "yasukawa2015_kvlcc2": 2, "son1982_s175": 2, "estimated_kcs": 3}


def test_the_equations_have_their_numbers(tmp_path: Path) -> None:
    nw.export.write(nw.published("mikkelsen2025_dtc"), tmp_path / "ship.tex")
    symbols, numbers = (tmp_path / "ship.tex").read_text(encoding="utf-8").split(r"\end{align*}")[:2]
    assert symbols.endswith(nw.latex(nw.PAPER).removeprefix(r"\begin{aligned}").removesuffix(r"\end{aligned}"))
    assert "1.07" in numbers


@pytest.mark.parametrize(("name", "pages"), PRINTED.items())
def test_the_equations_fit_their_page(name: str, pages: int, tmp_path: Path) -> None:
    """Typeset: the MMG model has 27 coefficients, propeller and rudder."""
    if shutil.which("pdflatex") is None:
        pytest.skip("no pdflatex is here to typeset the equations with")
    nw.export.write(nw.published(name), tmp_path / "ship.tex")
    page = r"\documentclass{article}\usepackage{amsmath}\begin{document}\input{ship.tex}\end{document}"
    (tmp_path / "page.tex").write_text(page, encoding="utf-8")
    done = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "page.tex"], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0
    assert "Overfull" not in done.stdout
    assert f"({pages} page" in done.stdout
