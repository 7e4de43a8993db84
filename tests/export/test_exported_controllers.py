"""Exported controllers: a law in a file steers as it does in a voyage of Python."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compiled import CompiledShip, needs_compiler
from exported import bent, model_of
from test_scripts import python_of

import narrows as nw
from narrows.simulation.controllers import CONTROLLERS
from narrows.simulation.initial_state import initial_state
from narrows.simulation.ship import SimulatedShip, steering_of

STEERED, DT, DURATION = "steered", 0.05, 12.0
START = {"y": 0.3, "psi": 0.02, "u": 1.0}


def law(name: str, curved: bool) -> Any:
    model, way = model_of(STEERED), bent(STEERED) if curved else None
    if name == "regulator":
        return nw.control.regulator(model, 0.2, 1.0, waterway=way)
    return CONTROLLERS[name](model.configuration.ship.length)


def start_of(controller: Any, curved: bool) -> list[float]:
    """The state as the engine keeps it, memory of the controller with it."""
    ship = SimulatedShip(model_of(STEERED))
    start = {**dict.fromkeys(("x", "y", "psi", "u", "v", "r", "rudder"), 0.0), **START, "x": 5.0 if curved else 0.0}
    return list(
        initial_state(ship, steering_of(controller, ship.actuators), start, bent(STEERED) if curved else None, False)[1]
    )


def voyage(controller: Any, curved: bool) -> nw.Voyage:
    place = {"waterway": bent(STEERED), "x": 5.0} if curved else {}
    return nw.simulate(model_of(STEERED), **START, **place, controller=controller, dt=DT, duration=DURATION)


@needs_compiler
@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("name", ["regulator", *CONTROLLERS])
def test_a_header_steers_as_the_voyage_does(tmp_path: Path, name: str, curved: bool) -> None:
    controller = law(name, curved)
    choices = {"waterway": bent(STEERED)} if curved else {}
    ship = CompiledShip(model_of(STEERED), tmp_path, controller=controller, **choices)
    *_, state = ship.integrate(start_of(controller, curved), DT, DURATION)
    expected = voyage(controller, curved)
    for place, of in enumerate(("x", "y")):
        assert state[place] == pytest.approx(getattr(expected, of)[-1], abs=1e-9)


def test_a_python_file_steers_as_the_voyage_does(tmp_path: Path) -> None:
    controller = law("regulator", False)
    ship = python_of(STEERED, tmp_path, controller=controller)
    state, end = np.array([*start_of(controller, False), 0.0, 0.0]), np.zeros(2)
    ship.integrate(state, ship.AT_REST, ship.prepare(ship.MODEL), None, DT, DURATION, end)
    assert state[1] == pytest.approx(voyage(controller, False).y[-1], abs=1e-9)


@needs_compiler
def test_an_fmu_steers_as_the_voyage_does(tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    controller = law("regulator", False)
    nw.export.write(model_of(STEERED), tmp_path / "ship.fmu", controller=controller, u=1.0, dt=DT)
    start = {**START, "memory_last_order": 0.0}
    rows = fmpy.simulate_fmu(
        str(tmp_path / "ship.fmu"), start_values=start, stop_time=DURATION, output_interval=DT, output=["y", "rudder"]
    )
    assert validate_fmu(str(tmp_path / "ship.fmu")) == []
    expected = voyage(controller, False)
    assert rows["y"][-1] == pytest.approx(expected.y[-1], abs=1e-9)
    assert rows["rudder"][-1] == pytest.approx(expected.rudder[-1], abs=1e-9)


def test_what_is_no_law_is_refused(tmp_path: Path) -> None:
    with pytest.raises(nw.InputError, match=r"steers in nw\.simulate alone"):
        nw.export.write(model_of(STEERED), tmp_path / "ship.h", controller=lambda time, state: 0.1)
