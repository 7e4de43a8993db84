"""Steps and file names that are none, at the doors of exported files: refused at once."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from compiled import CompiledShip, needs_compiler
from exported import model_of, states
from test_scripts import python_of

import narrows as nw

REFUSED = 6
# A step of 1000 s would take this ship of 4 m through the canal many times over.
STEPS = [(0.0, 20.0), (1e-12, 20.0), (-1.0, 20.0), (1000.0, 20.0), (np.nan, 20.0), (np.inf, 20.0), (np.inf, 1.0),
         (0.05, -1.0), (0.05, np.nan), (0.05, np.inf)]  # fmt: skip


@needs_compiler
def test_c_refuses_by_its_status(tmp_path: Path) -> None:
    ship, state = CompiledShip(model_of("paper"), tmp_path), states("paper", 1)[0]
    for step, duration in STEPS:
        outcome, _, _, after = ship.integrate(state, step, duration)
        assert outcome == REFUSED
        np.testing.assert_array_equal(after, state)
    assert ship.integrate(state, 0.05, 0.0)[0] == 0, "no time at all is a time"


def test_the_python_file_refuses_in_words(tmp_path: Path) -> None:
    ship = python_of("paper", tmp_path)
    for step, duration in STEPS:
        state, end = ship.rest(), np.zeros(2)
        state[ship.U] = 1.0
        with pytest.raises(ValueError, match="ship length"):
            ship.integrate(state, ship.AT_REST, ship.prepare(ship.MODEL), None, step, duration, end)


@pytest.mark.skipif(shutil.which("node") is None, reason="no node is here to run the exported module")
def test_the_module_refuses_in_words(tmp_path: Path) -> None:
    nw.export.write(model_of("paper"), tmp_path / "ship.mjs")
    steps = json.dumps(STEPS).replace("NaN", '"NaN"').replace("Infinity", '"Infinity"')
    script = f"""import * as ship from "./ship.mjs";
let refused = 0;
for (const [step, duration] of {steps}) {{
  const state = ship.rest(), end = [0, 0];
  state[ship.U] = 1;
  try {{ ship.integrate(state, ship.atRest, ship.prepare(ship.model), +step, +duration, end); }} catch (error) {{
    if (error instanceof RangeError && error.message.includes("ship length")) refused += 1;
  }}
}}
console.log(refused);
"""
    (tmp_path / "run.mjs").write_text(script, encoding="utf-8")
    done = subprocess.run(["node", "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=20)
    assert int(done.stdout) == len(STEPS)
