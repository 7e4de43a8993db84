"""Without Numba and without threads, as in a browser: imports, fits, voyages, and fleets by columns of NumPy."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import narrows as nw
from narrows.simulation.outcome import KINDS
from narrows.waterway import Bank, Centreline, Waterway
from tables import short_twin

TESTS = Path(__file__).parents[1]
BROWSER = """
import json, sys, threading
def refused(self):
    raise RuntimeError("can't start new thread")
sys.modules["numba"], threading.Thread.start = None, refused
import narrows as nw
from tables import short_twin
model = nw.published("mikkelsen2025_dtc")
voyage = nw.simulate(model, y=0.5, u=1.0, dt=0.2)
fleet = nw.ensemble(model, y=[0.5, -0.5], u=1.0, dt=0.2)
fit = nw.identify(short_twin())
model.forces(y=1.0, u=1.0), nw.stability(fit.model, y=0.5, u=1.0), nw.derivative(model, [0, 0.5, 0, 1, 0, 0])
tanker = nw.published("yasukawa2015_kvlcc2")
course = nw.steady_course(tanker, y=[0.0, 1.0], u=1.0, Y=50.0)
try:
    nw.safe_envelope(tanker, y=[0.0], u=[1.0])
except nw.InputError as error:
    refusal = str(error)
print(json.dumps([
    voyage.outcome.time, *fleet.time.values.tolist(), fit.model["b_bank"], course.rudder.values.tolist(), refusal,
]))
"""


def alone(text: str) -> subprocess.CompletedProcess[str]:
    """Run a text in a process of its own, beside the modules of the tests."""
    beside = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, (str(TESTS), os.environ.get("PYTHONPATH"))))}
    return subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, env=beside)


def test_what_works_where_numba_and_threads_do_not() -> None:
    done = alone(BROWSER)
    assert done.returncode == 0, done.stderr
    voyage, one, mirrored, b_bank, rudder, refusal = json.loads(done.stdout)
    expected = nw.simulate(nw.published("mikkelsen2025_dtc"), y=0.5, u=1.0, dt=0.2).outcome.time
    assert (voyage, b_bank) == (expected, nw.identify(short_twin()).coefficients["b_bank"])
    assert one == mirrored
    assert abs(one - expected) < 1e-9
    course = nw.steady_course(nw.published("yasukawa2015_kvlcc2"), y=[0.0, 1.0], u=1.0, Y=50.0)
    np.testing.assert_allclose(rudder, course.rudder, atol=1e-12)
    assert re.match(r"compiled simulation .* needs numba: .* -m pip install 'numba", refusal)


BESIDE = """
import sys
sys.modules["numba"] = None
from engine import test_no_compiler as own
own.{}
"""


@pytest.mark.parametrize("work", ["sails_to('corners')", "sails_to('midship')", "feels_gear_law_and_waterway()"])
def test_columns_end_as_single_voyages_do(work: str) -> None:
    done = alone(BESIDE.format(work))
    assert done.returncode == 0, done.stderr


def sails_to(contact: Any) -> None:
    offsets, options = [-2.3, -0.2, 0.0, 0.6, 2.4], {"contact": contact, "duration": 20.01, "dt": 0.05}
    model = nw.published("mikkelsen2025_dtc")
    held(nw.ensemble(model, y=offsets, u=[0.5, 1.0], **options), model, options)


def feels_gear_law_and_waterway() -> None:
    """A pilot with a gear, in bends: the table is read in columns, the banks themselves by whoever is near."""
    model = nw.published("yasukawa2015_kvlcc2")
    north = np.linspace(0.0, 200.0, 101)
    line = Centreline(np.stack([6.0 * np.sin(north / 40.0), north], axis=1))
    banks = (Bank(side, line.length * np.array([0.0, 1.0]), np.array([8.0, 7.0])) for side in ("starboard", "port"))
    options = {"waterway": Waterway(line, *banks, name="bent"), "x": 10.0, "duration": 45.0, "dt": 0.5}
    options |= {"controller": nw.ConstantRudder(0.05)}
    held(nw.ensemble(model, y=[-3.0, 0.5], u=[1.1], **options), model, options)


def held(fleet: Any, model: nw.Model, options: dict[str, Any]) -> None:
    """Every voyage of a fleet beside the single one."""
    for y in fleet.y.values:
        for u in fleet.u.values:
            end, one = fleet.sel(y=y, u=u), nw.simulate(model, y=y, u=u, **options).outcome
            assert KINDS[int(end.outcome)] == one.kind
            assert abs(float(end.time) - one.time) < 1e-9
            assert abs(float(end.distance) - one.distance) < 1e-9
            assert abs(float(end.y_end) - one.state["y"]) < 1e-9
            side = {1: "starboard", -1: "port", 0: None}[int(end.side)]
            assert side == (one.side if one.kind == "grounded" else None)
