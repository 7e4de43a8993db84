"""FMUs beside the package's own voyages, by FMPy: validated, sailed in both kinds, differentiated, put back."""

import re
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from compiled import needs_compiler
from exported import bent, model_of, speed_of
from scipy.integrate import solve_ivp

import narrows as nw
from narrows.cli import app

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
pytestmark = needs_compiler
POSE = ("x", "y", "psi", "u", "v", "r")
START = {"x": 6.0, "y": 0.4, "psi": 0.02, "u": 1.0}
DT = 0.05


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fmu") / "paper.fmu"
    nw.export.write(model_of("paper"), path, dt=DT)
    return path


@pytest.fixture(scope="module")
def steered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fmu") / "steered.fmu"
    nw.export.write(model_of("steered"), path, dt=DT, waterway=bent("steered"))
    return path


def sailed(path: Path, kind: str, **more: Any) -> np.ndarray:
    return fmpy.simulate_fmu(
        str(path),
        fmi_type=kind,
        stop_time=20.0,
        output_interval=DT,
        output=[*POSE, "aground", "clearance_port"],
        **more,
    )


@pytest.fixture(scope="module")
def third(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fmu") / "third.fmu"
    nw.export.write(model_of("paper"), path, dt=DT, fmi=3)
    return path


@pytest.mark.parametrize("name", ["steered", "third"])
def test_the_standard_is_kept(name: str, request: pytest.FixtureRequest) -> None:
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(request.getfixturevalue(name))) == []


@pytest.mark.parametrize(("name", "checker"), [("steered", "VDMCheck2.sh"), ("third", "VDMCheck3.sh")])
def test_the_formal_rules_of_the_standard_are_kept(name: str, checker: str, request: pytest.FixtureRequest) -> None:
    """By the standard's rules as the INTO-CPS Association has them in VDM, run by its own interpreter."""
    program = shutil.which(checker)
    if program is None:
        pytest.skip(f"{checker} is not here: github.com/INTO-CPS-Association/FMI-VDM-Model builds it")
    done = subprocess.run([program, request.getfixturevalue(name)], capture_output=True, text=True)
    assert done.stdout.strip().endswith("No errors found."), done.stdout


@pytest.mark.parametrize("kind", ["cs", "me"])
@pytest.mark.parametrize("name", ["paper", "steered"])
def test_the_compliance_checker_has_no_remark(name: str, kind: str, request: pytest.FixtureRequest) -> None:
    program = shutil.which("fmuCheck.linux64")
    if program is None:
        pytest.skip("fmuCheck.linux64 is not here: github.com/modelica-tools/FMUComplianceChecker builds it")
    command = [program, "-k", kind, "-l", "3", "-n", "100", "-o", "/dev/null", request.getfixturevalue(name)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, re.findall(r"\[(?:WARNING|ERROR|FATAL)\].*", done.stdout + done.stderr)) == (0, [])


@pytest.mark.parametrize("name", ["paper", "third"])
def test_co_simulation_is_the_voyage_to_its_contact(name: str, request: pytest.FixtureRequest) -> None:
    paper = request.getfixturevalue(name)
    voyage = nw.simulate(model_of("paper"), **START, duration=20.0, dt=DT)
    rows = sailed(paper, "CoSimulation", start_values=START)
    assert voyage.grounded
    many = len(voyage.t) - 1
    for name in POSE:
        np.testing.assert_allclose(rows[name][:many], getattr(voyage, name)[:many], rtol=1e-12, atol=1e-12)
    assert rows["aground"][-1] == 1
    np.testing.assert_allclose(
        [rows[name][-1] for name in POSE[:3]], [voyage.outcome.state[n] for n in POSE[:3]], atol=1e-9
    )
    assert rows["x"][-1] == rows["x"][-2], "a grounded ship lies still"


def test_a_rudder_is_turned_by_its_gear_in_a_waterway(steered: Path) -> None:
    told = {**START, "u": speed_of("steered")}
    voyage = nw.simulate(
        model_of("steered"), **told, duration=20.0, dt=DT, waterway=bent("steered"), controller=nw.ConstantRudder(0.1)
    )
    rows = sailed(steered, "CoSimulation", start_values={**told, "rudder_order": 0.1})
    many = len(voyage.t) - 1
    for name in POSE:
        np.testing.assert_allclose(rows[name][:many], getattr(voyage, name)[:many], rtol=1e-10, atol=1e-10)


@pytest.fixture(scope="module")
def truth() -> dict[str, np.ndarray]:
    """The same equations by Dormand and Prince's eighth order, each second."""
    times = np.arange(1.0, 10.0)
    solved = solve_ivp(
        lambda t, z: nw.derivative(model_of("paper"), z), (0.0, 9.0), [START.get(name, 0.0) for name in POSE],
        method="DOP853", t_eval=times, rtol=1e-12, atol=1e-13,
    )  # fmt: skip
    return {"time": times, **dict(zip(POSE, solved.y, strict=True))}


@pytest.mark.parametrize("name", ["paper", "third"])
def test_model_exchange_is_the_solution_by_other_integrators(
    name: str, request: pytest.FixtureRequest, truth: dict[str, np.ndarray]
) -> None:
    rows = sailed(request.getfixturevalue(name), "ModelExchange", start_values=START, relative_tolerance=1e-11)
    there = np.isin(rows["time"].round(9), truth["time"])
    for one in POSE:
        np.testing.assert_allclose(rows[one][there], truth[one], rtol=1e-8, atol=1e-8)
    assert rows["aground"][-1] == 1


def test_libcosim_sails_two_ships_without_a_word(paper: Path, steered: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The Open Simulation Platform's co-simulation, FMI 2.0."""
    pytest.importorskip("libcosimpy", reason="libcosimpy is not installed")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=round(DT * 1e9))
    starts, ships = {"paper": START, "steered": {**START, "u": speed_of("steered")}}, {}
    for path in (paper, steered):
        places = {one.name: one.valueReference for one in fmpy.read_model_description(str(path)).modelVariables}
        ship = execution.add_local_slave(CosimLocalSlave(fmu_path=str(path), instance_name=path.stem))
        for name, value in starts[path.stem].items():
            execution.real_initial_value(ship, places[name], value)
        ships[path.stem] = ship, places
    seen = CosimObserver.create_last_value()
    execution.add_observer(seen)
    voyages = {
        name: nw.simulate(
            model_of(name), **starts[name], duration=20.0, dt=DT, waterway=bent(name) if name == "steered" else None
        )
        for name in ships
    }
    for number in range(1, min(len(voyage.t) for voyage in voyages.values()) - 1):
        execution.simulate_until(target_time=number * round(DT * 1e9))
        for name, (ship, places) in ships.items():
            values = seen.last_real_values(slave_index=ship, variable_references=[places[one] for one in POSE])
            wanted = [getattr(voyages[name], one)[number] for one in POSE]
            np.testing.assert_allclose(values, wanted, rtol=1e-10, atol=1e-10)
    execution.simulate_until(target_time=20_000_000_000)
    ship, places = ships["paper"]
    assert seen.last_boolean_values(slave_index=ship, variable_references=[places["aground"]]) == [True]
    assert seen.last_integer_values(slave_index=ship, variable_references=[places["outcome"]]) == [1]
    assert re.findall(r"\[(?:warning|error|fatal)\].*", capfd.readouterr().out) == []


def test_rates_and_state(paper: Path) -> None:
    description = fmpy.read_model_description(str(paper))
    place = {one.name: one.valueReference for one in description.modelVariables}
    folder = fmpy.extract(str(paper))
    ship = fmpy.fmi2.FMU2Slave(
        guid=description.guid, unzipDirectory=folder, modelIdentifier="paper", instanceName="one"
    )
    try:
        ship.instantiate()
        ship.setupExperiment(startTime=0.0)
        ship.enterInitializationMode()
        at = {"y": 0.5, "psi": 0.05, "u": 1.0, "v": 0.03, "r": -0.01}
        ship.setReal([place[name] for name in at], list(at.values()))
        ship.exitInitializationMode()
        rates = ship.getReal([place["der(v)"], place["der(r)"]])
        np.testing.assert_allclose(rates, nw.derivative(model_of("paper"), at)[[4, 5]], rtol=1e-12)
        before, kept = ship.getReal([place["y"]]), ship.getFMUState()
        ship.doStep(currentCommunicationPoint=0.0, communicationStepSize=1.0)
        assert ship.getReal([place["y"]]) != before
        ship.setFMUState(ship.deSerializeFMUstate(ship.serializeFMUstate(kept)))
        assert ship.getReal([place["y"]]) == before
        ship.freeFMUState(kept)
        ship.terminate()
    finally:
        ship.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def test_a_start_in_the_bank_is_refused(paper: Path) -> None:
    with pytest.raises(Exception, match="fmi2ExitInitializationMode"):
        sailed(paper, "CoSimulation", start_values={"y": 3.4, "u": 1.0})


def test_written_again_its_sources_are_the_same(paper: Path, tmp_path: Path) -> None:
    nw.export.write(model_of("paper"), tmp_path / "paper.fmu", dt=DT)
    with zipfile.ZipFile(paper) as one, zipfile.ZipFile(tmp_path / "paper.fmu") as other:
        names = [name for name in one.namelist() if not name.startswith("binaries")]
        assert {name: one.read(name) for name in names} == {name: other.read(name) for name in names}
    assert paper.stat().st_size < 150_000


def test_without_a_compiler_its_sources_are_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("narrows.export.fmu.builds_here", lambda fmi: ())
    done = CliRunner().invoke(app, ["export", "fmu", "mikkelsen2025_dtc", "-o", str(tmp_path / "ship.fmu")])
    assert done.exit_code == 0
    assert "sources alone" in done.stdout
    with zipfile.ZipFile(tmp_path / "ship.fmu") as packed:
        assert {"modelDescription.xml", "sources/fmi2.c", "sources/ship.h"} <= set(packed.namelist())


def test_a_compiler_that_fails_is_a_sentence_and_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = "linux64", ("false",), ".so"
    monkeypatch.setattr("narrows.export.fmu.builds_here", lambda fmi: (broken,))
    with pytest.raises(nw.InputError, match="compiler for linux64 fails"):
        nw.export.write(model_of("paper"), tmp_path / "ship.fmu")
    with pytest.raises(nw.InputError, match="no step"):
        nw.export.write(model_of("paper"), tmp_path / "ship.fmu", dt=0.0)
    assert list(tmp_path.iterdir()) == []
