"""The function of MATLAB by Octave, in the order of states of MSS."""

import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
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
