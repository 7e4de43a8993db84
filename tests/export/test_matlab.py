"""The function of MATLAB by Octave, and the S-function of Simulink in C, in the order of states of MSS."""

import ctypes
import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from compiled import COMPILER, FLAGS, needs_compiler, pointer
from exported import STEERED, model_of, states
from test_scripts import BOUNDED, bits

import narrows as nw

OCTAVE = shutil.which("octave")
SCRIPT = """for x = {rows}'
    [xdot, U, beyond] = ship(x, {order});
    printf('%.17g ', [xdot; U; beyond]); printf('\\n');
end
"""


def said(model: nw.Model, at: np.ndarray, order: str, folder: Path) -> np.ndarray:
    """Rates, speed and beyond of states [u v r x y psi ...] by Octave."""
    nw.export.write(model, folder / "ship.m")
    rows = json.dumps(at.tolist()).replace("], [", "; ").replace("[[", "[").replace("]]", "]")
    (folder / "run.m").write_text(SCRIPT.format(rows=rows, order=order), encoding="utf-8")
    done = subprocess.run(
        [OCTAVE, "--norc", "--no-gui", "run.m"], cwd=folder, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return np.array([line.split() for line in done.stdout.splitlines()], float)


def in_mss(at: np.ndarray) -> np.ndarray:
    x, y, cosine, sine, u, v, r, *rudder = at.T
    return np.stack([u, v, r, x, y, np.arctan2(sine, cosine), *rudder], axis=1)


@pytest.mark.skipif(OCTAVE is None, reason="no Octave is here")
@pytest.mark.parametrize("name", ["paper", "steered", "mmg+delta"])
def test_rates_are_those_of_python(name: str, tmp_path: Path) -> None:
    model, at = replace(model_of(name), data_range=BOUNDED), states(name, 8)
    given = in_mss(at)
    answers = said(model, given, "0.1" if name in STEERED else "[]", tmp_path)
    for number, row in enumerate(given):
        places = {"rudder": row[6]} if name in STEERED else {}
        rates = nw.derivative(model, [*row[3:6], *row[:3]], **places)
        np.testing.assert_allclose(answers[number, :6], rates[[3, 4, 5, 0, 1, 2]], rtol=1e-12, atol=1e-12)
        assert answers[number, -2] == pytest.approx(np.hypot(row[0], row[1]), rel=1e-14)
        assert answers[number, -1] == bits(at[number][:7])
        if name in STEERED:  # At the rate of its gear towards the order, and not beyond it.
            rate = model.configuration.steering.rate
            assert abs(answers[number, 6]) <= rate * (1 + 1e-12)
            assert np.sign(answers[number, 6]) == np.sign(0.1 - row[6])


@pytest.mark.skipif(OCTAVE is None, reason="no Octave is here")
def test_forces_from_outside_come_after_the_orders(tmp_path: Path) -> None:
    model, row = model_of("steered"), [[1.0, 0.1, 0.02, 0.0, 0.3, 0.1, 0.05]]
    answer = said(model, np.array(row * 2), "[0.1; 0.7; -0.4]", tmp_path)[0]
    rates = nw.derivative(model, [0.0, 0.3, 0.1, 1.0, 0.1, 0.02], Y=0.7, N=-0.4, rudder=0.05)
    np.testing.assert_allclose(answer[:3], rates[3:], rtol=1e-12, atol=1e-13)


def simulink(model: nw.Model, folder: Path) -> ctypes.CDLL:
    """The S-function of a model behind a stand-in for Simulink's own interface."""
    nw.export.write(model, folder / "ship.c")
    stub = ["-DMATLAB_MEX_FILE", f"-I{Path(__file__).with_name('simulink')}"]
    made = ["-shared", "-fPIC", "ship.c", "-o", "ship.so", "-lm"]
    subprocess.run([COMPILER, *FLAGS, *stub, *made], cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / "ship.so"))
    library.begin.restype = ctypes.c_char_p
    return library


def begun(block: ctypes.CDLL, start: np.ndarray, given: list[float]) -> bytes | None:
    block.kept = start, np.array([*given, 0.0, 0.0])
    return block.begin(pointer(block.kept[0]), len(start), pointer(block.kept[1]))


@needs_compiler
@pytest.mark.parametrize("name", ["paper", "steered"])
def test_the_block_of_simulink_has_the_rates_of_python(name: str, tmp_path: Path) -> None:
    model, at = replace(model_of(name), data_range=BOUNDED), states(name, 8)
    block, order = simulink(model, tmp_path), [0.1] * (name in STEERED)
    half = model.configuration.canal.width / 2
    hull = model.configuration.ship
    for state, row in zip(at, in_mss(at), strict=True):
        assert begun(block, row.copy(), [*order, 0.7, -0.4]) is None
        dx, out = np.zeros(len(row)), np.zeros(len(row) + 5)
        block.rates(pointer(dx), pointer(out))
        places = {"rudder": row[6]} if name in STEERED else {}
        rates = nw.derivative(model, [*row[3:6], *row[:3]], Y=0.7, N=-0.4, **places)
        np.testing.assert_allclose(dx[:6], rates[[3, 4, 5, 0, 1, 2]], rtol=1e-12, atol=1e-12)
        np.testing.assert_array_equal(out[: len(row)], row)
        reach = hull.length / 2 * abs(state[3]) + hull.beam / 2 * state[2]
        np.testing.assert_allclose(out[len(row) : -3], [half - row[4] - reach, half + row[4] - reach], rtol=1e-12)
        np.testing.assert_array_equal(out[-2:], out[len(row) : -3])
        assert out[-3] == bits(state[:7])
        if name in STEERED:
            assert 0 < abs(dx[6]) <= model.configuration.steering.rate * (1 + 1e-12)
            assert np.sign(dx[6]) == np.sign(0.1 - row[6])


@needs_compiler
def test_the_block_of_simulink_sails_to_the_bank(tmp_path: Path) -> None:
    """By ode4 with the step of a voyage; a start of another length is an error that Simulink shows."""
    model, dt = model_of("paper"), 0.05
    block, outcome = simulink(model, tmp_path), nw.simulate(model, y=0.5, psi=0.05, u=1.0, dt=dt, duration=60.0).outcome
    end = np.zeros(6)
    for side in (1.0, -1.0):  # To either bank
        assert begun(block, np.array([1.0, 0.0, 0.0, 0.0, side * 0.5, side * 0.05]), []) is None
        assert 0 <= block.integrate(ctypes.c_double(dt), 1200, pointer(end)) * dt - outcome.time < 2 * dt
    assert begun(block, np.array([1.0, 0.0, 0.0, 0.0, 0.5, 0.05]), []) is None
    steps = int(outcome.time / dt) - 10
    assert block.integrate(ctypes.c_double(dt), steps, pointer(end)) == steps
    voyage = nw.simulate(model, y=0.5, psi=0.05, u=1.0, dt=dt, duration=steps * dt)
    np.testing.assert_allclose(end[3:6], [voyage.x[-1], voyage.y[-1], voyage.psi[-1]], rtol=1e-6)
    assert b"give 6 numbers, [u v r x y psi]" in begun(block, np.zeros(5), [])
