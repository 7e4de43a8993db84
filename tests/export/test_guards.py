"""Steps, waterways and file names that are none, at the doors of exported files: refused at once."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from compiled import CompiledShip, needs_compiler
from exported import bent, model_of, speed_of, states
from test_scripts import python_of

import narrows as nw

REFUSED = 6
# A step of 1000 s would take this ship of 4 m through the canal many times over.
STEPS = [(0.0, 20.0), (1e-12, 20.0), (-1.0, 20.0), (1000.0, 20.0), (np.nan, 20.0), (np.inf, 20.0), (np.inf, 1.0),
         (0.05, -1.0), (0.05, np.nan), (0.05, np.inf)]  # fmt: skip
SECTIONS = np.array([[0.0, 4.0, 3.5, 0.3, 0.0, 4.0, 3.5], [40.0, 3.0, 3.5, 0.3, 0.01, 3.0, 3.5]])


@needs_compiler
def test_c_refuses_by_its_status(tmp_path: Path) -> None:
    ship, state = CompiledShip(model_of("paper"), tmp_path), states("paper", 1)[0]
    for step, duration in STEPS:
        outcome, _, _, after = ship.integrate(state, step, duration)
        assert outcome == REFUSED
        np.testing.assert_array_equal(after, state)
    assert ship.integrate(state, 0.05, 0.0)[0] == 0, "no time at all is a time"


@needs_compiler
@pytest.mark.parametrize(
    ("row", "column", "value"),
    [(1, 0, 0.0), (1, 0, -5.0), (0, 1, -1.0), (1, 2, 0.0), (1, 3, 0.0), (0, 5, np.nan), (1, 4, 0.4), (1, 0, np.inf)],
    ids=["nowhere", "unsorted", "negative", "no port", "dry", "no number", "bends into itself", "endless"],
)
def test_sections_that_are_no_waterway(ship: CompiledShip, row: int, column: int, value: float) -> None:
    sections = SECTIONS.copy()
    sections[row, column] = value
    refuses(ship, sections, 81)


@needs_compiler
def test_a_waterway_needs_two_sections_and_two_nodes(ship: CompiledShip) -> None:
    for rows, nodes in ((SECTIONS[:1], 81), (SECTIONS[:0], 81), (SECTIONS, 1), (SECTIONS, 0)):
        refuses(ship, rows, nodes)
    ship.lie_in(SECTIONS, 2)
    assert ship.integrate([5.0, 0, 1, 0, speed_of("steered"), 0, 0, 0], 0.05, 1.0)[0] == 0


@pytest.fixture(scope="module")
def ship(tmp_path_factory: pytest.TempPathFactory) -> CompiledShip:
    return CompiledShip(model_of("steered"), tmp_path_factory.mktemp("ship"), waterway=bent("steered"))


def refuses(ship: CompiledShip, sections: np.ndarray, nodes: int) -> None:
    """And writes nowhere: the arrays are as small as the nodes."""
    ship.lie_in(sections, max(nodes, 2), nodes)
    assert ship.integrate(states("steered", 1)[0], 0.05, 1.0)[0] == REFUSED
    assert not np.any(ship.water[0])


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
