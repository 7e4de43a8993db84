"""What importers may do with an FMU: ends of voyages, order of calls, bounds, two in one program."""

import shutil
import subprocess
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compiled import COMPILER, needs_compiler
from exported import bent, model_of

import narrows as nw

pytest.importorskip("fmpy", reason="FMPy is not installed")
from fmus import Imported, imported

pytestmark = needs_compiler
DT = 0.05
# y = 0.5 m off, on the way to the bank.
START = {"x": 6.0, "y": 0.5, "psi": 0.05, "u": 1.0}
OUTCOMES = {"afloat": 0, "grounded": 1, "diverged": 2, "outside": 3, "astern": 4, "passed": 5}
Fmus = Any


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Fmus:
    made: dict[Any, Path] = {}

    def fmu(name: str = "paper", fmi: int = 2, curved: bool = False, **choices: Any) -> Path:
        key = (name, fmi, curved, str(choices))
        if key not in made:
            path = tmp_path_factory.mktemp("fmu") / f"{name.replace('+', '_')}_{len(made)}.fmu"
            model = model_of(name).in_open_water() if choices.get("contact") == "none" else model_of(name)
            surge = "free" if name == "mmg+delta" else "held"
            told = {"dt": DT, "waterway": bent(name) if curved else None, "surge": surge} | choices
            nw.export.write(model, path, fmi=fmi, **told)
            made[key] = path
        return made[key]

    return fmu


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_derivative_is_refused(fmus: Fmus, fmi: int) -> None:
    with imported(fmus("paper", fmi), exchange=True) as fmu:
        fmu.start(START)
        assert fmu.refuses(fmu.slope, ["der(v)"], ["y"], [1.0])


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("step", [0.0, 1e-13, -1.0, 1000.0, np.nan, np.inf])
def test_a_step_that_is_none_is_refused_when_it_is_set(fmus: Fmus, fmi: int, step: float) -> None:
    with imported(fmus("paper", fmi)) as fmu:
        assert fmu.refuses(fmu.set, step=step)
        fmu.start(START)
        fmu.step(0.0, 1.0)
        assert abs(fmu.get("x")[0] - 7.0) < 0.1


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_tiny_step_does_not_hang(fmus: Fmus, fmi: int) -> None:
    with imported(fmus("paper", fmi)) as fmu:
        fmu.start({**START, "step": 2e-12})
        assert fmu.refuses(fmu.step, 0.0, 10.0), "five million million steps"


@pytest.mark.parametrize("fmi", [2, 3])
def test_calls_out_of_turn_are_errors(fmus: Fmus, fmi: int) -> None:
    with imported(fmus("paper", fmi)) as fmu:
        assert fmu.refuses(fmu.step, 0.0, 1.0)
        assert fmu.refuses(fmu.fmu.exitInitializationMode)
        assert fmu.refuses(fmu.fmu.terminate)
        fmu.start(START, stop=30.0)
        assert fmu.refuses(fmu.fmu.enterInitializationMode)
        for time, length in ((0.0, 0.0), (0.0, -1.0), (0.0, np.nan), (777.0, 1.0), (np.nan, 1.0), (0.0, 31.0)):
            assert fmu.refuses(fmu.step, time, length), (time, length)
        fmu.step(0.0, 1.0)
        assert fmu.refuses(fmu.step, 0.0, 1.0), "that step was done"
        fmu.step(1.0, 1.0)
        fmu.fmu.terminate()
        assert fmu.refuses(fmu.step, 2.0, 1.0)
        fmu.fmu.reset()
        fmu.start(START)
        fmu.step(0.0, 1.0)
    with imported(fmus("paper", fmi), exchange=True) as fmu:
        assert fmu.refuses(fmu.fmu.enterContinuousTimeMode)
        fmu.start(START)
        assert fmu.refuses(fmu.put_states, [0.0] * 6), "in event mode"
        fmu.fmu.enterContinuousTimeMode()
        assert fmu.refuses(fmu.put_states, [0.0] * 5)
        assert fmu.refuses(fmu.put_states, [np.nan] * 6)
        assert fmu.refuses(fmu.fmu.setTime, np.nan)


@pytest.mark.parametrize("fmi", [2, 3])
def test_what_an_importer_may_set_and_when(fmus: Fmus, fmi: int) -> None:
    with imported(fmus("steered", fmi)) as fmu:
        for values in ({"time": 1.0}, {"der(v)": 1.0}, {"clearance_port": 1.0}, {"outcome_time": 1.0}, {"y": np.nan},
                       {"parameters.b_vdot": -1.0}, {"parameters.length": 0.0}, {"parameters.block_coefficient": 1.5},
                       {"parameters.width": np.inf}):  # fmt: skip
            assert fmu.refuses(fmu.set, **values), values
        fmu.start({**START, "rudder": 0.1, "parameters.c_bank": 0.2})
        assert fmu.get("parameters.c_bank", "rudder").tolist() == [0.2, 0.1]
        for values in ({"y": 0.0}, {"u": 2.0}, {"rudder": 0.0}, {"step": 0.1}):
            assert fmu.refuses(fmu.set, **values), values
        fmu.set(**{"rudder_order": 0.2, "Y_in": 1.0, "parameters.c_bank": 0.3})
        for variable in fmu.description.modelVariables:
            if variable.variability in ("tunable", "fixed"):
                low, high = (float(end) for end in (variable.min or -np.inf, variable.max or np.inf))
                assert low <= float(variable.start) <= high


def test_parameters_that_make_no_ship_do_not_start(fmus: Fmus) -> None:
    with imported(fmus("paper")) as fmu, pytest.raises(Exception, match="ExitInitializationMode"):
        fmu.start({**START, "parameters.width": 0.6})
    with imported(fmus("steered", curved=True)) as fmu, pytest.raises(Exception, match="ExitInitializationMode"):
        fmu.start({**START, "x": -5.0})


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_contact_within_a_step_has_its_time(fmus: Fmus, fmi: int) -> None:
    """With communication steps of 5 s, as with those of the voyage."""
    outcome = nw.simulate(model_of("paper"), **START, duration=60.0, dt=DT).outcome
    with imported(fmus("paper", fmi)) as fmu:
        fmu.start(START)
        for time in np.arange(0.0, 60.0, 5.0):
            fmu.step(time, 5.0)
        assert fmu.whole("outcome") == OUTCOMES[outcome.kind]
        assert fmu.whole("side") == {"starboard": 1, "port": -1}[outcome.side]
        assert abs(fmu.get("outcome_time")[0] - outcome.time) < 1e-9
        np.testing.assert_allclose(fmu.get("x", "y"), [outcome.state["x"], outcome.state["y"]], atol=1e-9)
        assert fmu.get("u", "v", "r", "der(x)", "der(u)").tolist() == [0.0] * 5, "it lies still"


def test_a_step_ends_early_at_a_contact(fmus: Fmus) -> None:
    """FMI 3.0: the importer handles the event, the speed of the contact is still there to be read, and goes on."""
    outcome = nw.simulate(model_of("paper"), **START, duration=60.0, dt=DT).outcome
    with imported(fmus("paper", 3), eventModeUsed=True, earlyReturnAllowed=True) as fmu:
        fmu.start(START)
        fmu.fmu.enterStepMode()
        time, event = 0.0, False
        while not event:
            event, _, early, time = fmu.step(time, 5.0)
            assert early == event
        assert abs(time - outcome.time) < 1e-9
        assert fmu.whole("outcome") == OUTCOMES["afloat"]
        np.testing.assert_allclose(fmu.get("u", "v", "r"), [outcome.state[name] for name in "uvr"], atol=1e-7)
        fmu.fmu.enterEventMode()
        fmu.fmu.updateDiscreteStates()
        assert fmu.whole("outcome") == OUTCOMES["grounded"]
        fmu.fmu.enterStepMode()
        assert fmu.step(time, 5.0) == (False, False, False, time + 5.0)


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_end_of_a_waterway_is_an_outcome(fmus: Fmus, fmi: int) -> None:
    length = bent("steered").line.length
    with imported(fmus("steered", fmi, curved=True)) as fmu:
        fmu.start({"x": length - 2.0, "u": 1.0})
        for time in range(5):
            fmu.step(float(time), 1.0)
        assert fmu.whole("outcome") == OUTCOMES["passed"]
        assert abs(fmu.get("x")[0] - length) < 1e-6
        assert 1.0 < fmu.get("outcome_time")[0] < 3.0


def test_beyond_the_tests_is_told_while_it_is_so(tmp_path: Path) -> None:
    model = nw.published("mikkelsen2025_dtc")
    covered = model.data_range
    assert covered.abs_y is not None
    for fmi in (2, 3):
        nw.export.write(model, tmp_path / "dtc.fmu", fmi=fmi)
        with imported(tmp_path / "dtc.fmu") as fmu:
            fmu.start({"y": 0.5 * covered.abs_y[1], "u": 1.0})
            assert fmu.whole("beyond") & 2 == 0
            said = []
            for time in range(10):
                fmu.step(float(time), 1.0)
                said.append((fmu.whole("beyond") & 2 > 0, abs(fmu.get("y")[0]) > 1.01 * covered.abs_y[1]))
            assert all(told == is_so for told, is_so in said)
            assert any(told for told, _ in said)


@pytest.mark.parametrize("gear", [nw.SteeringGear(25.0, 9.0), nw.SteeringGear(25.0, 9.0, dead_time=1.0, lag=0.5)])
def test_both_kinds_turn_the_rudder_as_a_voyage_does(tmp_path: Path, gear: nw.SteeringGear) -> None:
    """The gear is a state of either: 12 degrees of difference once were the importer's."""
    import fmpy

    model = replace(model_of("steered"), configuration=replace(model_of("steered").configuration, steering=gear))
    nw.export.write(model, tmp_path / "ship.fmu", dt=DT)
    voyage = nw.simulate(model, y=0.1, u=1.0, dt=DT, duration=6.0, controller=nw.ConstantRudder(0.3))
    for kind, most in (("CoSimulation", 1e-10), ("ModelExchange", gear.rate * DT)):
        rows = fmpy.simulate_fmu(
            str(tmp_path / "ship.fmu"), fmi_type=kind, start_values={"y": 0.1, "u": 1.0, "rudder_order": 0.3},
            stop_time=6.0, output_interval=DT, relative_tolerance=1e-10, output=["rudder", "y", "psi"],
        )  # fmt: skip
        assert 0.2 < rows["rudder"][-1] <= 0.3 + 1e-9  # the importer's integrator rounds
        np.testing.assert_allclose(rows["rudder"], voyage.rudder, atol=most)
        np.testing.assert_allclose(rows["psi"], voyage.psi, atol=most)


def test_open_water(fmus: Fmus) -> None:
    """No clearance, no contact, and a heading that counts whole turns, as in a turning circle of Python."""
    with imported(fmus("steered", contact="none")) as fmu:
        assert not any("clearance" in name for name in fmu.variables)
        fmu.start({"u": 1.0, "rudder_order": 0.4})
        for time in range(200):
            fmu.step(float(time), 1.0)
        voyage = nw.simulate(model_of("steered").in_open_water(), u=1.0, contact="none", duration=200.0, dt=DT,
                             controller=nw.ConstantRudder(0.4))  # fmt: skip
        assert fmu.get("psi")[0] > 2 * np.pi
        np.testing.assert_allclose(fmu.get("x", "y", "psi"), [voyage.x[-1], voyage.y[-1], voyage.psi[-1]], rtol=1e-9)


def test_a_full_size_ship_has_an_experiment_of_its_size(fmus: Fmus, tmp_path: Path) -> None:
    full = nw.published("mikkelsen2025_dtc").scale(355.0).model
    nw.export.write(full, tmp_path / "full.fmu")
    sizes = [Imported(path).description.defaultExperiment for path in (fmus("paper"), tmp_path / "full.fmu")]
    stops = [float(one.stopTime) for one in sizes]
    assert stops[1] / stops[0] == pytest.approx((355.0 / 3.984) ** 0.5, rel=0.1)
    assert all(float(one.stepSize) < float(one.stopTime) / 100 for one in sizes)
    steps = [float(one.stopTime) / float(one.stepSize) for one in sizes]
    assert steps == pytest.approx([round(number) for number in steps], abs=1e-6)


@pytest.mark.parametrize("fmi", [2, 3])
def test_eight_threads_sail_as_one_does(fmus: Fmus, fmi: int) -> None:
    """Eight instances of one loaded library, each on its own course: the same numbers to the bit."""
    path = fmus("steered", fmi)

    def voyage(fmu: Imported, order: float) -> np.ndarray:
        fmu.start({**START, "y": order, "rudder_order": order, "step": 1e-4})
        for time in np.arange(0.0, 8.0, 4.0):
            fmu.step(time, 4.0)  # Forty thousand steps in C, in which the threads run side by side
        return fmu.get("x", "y", "psi", "v", "r", "rudder", "outcome_time")

    orders = np.linspace(-0.3, 0.3, 8)
    with imported(path) as first:
        instances = [first, *(Imported(path, folder=first.folder) for _ in orders[1:])]
        with ThreadPoolExecutor(8) as pool:
            together = list(pool.map(voyage, instances, orders))
        for fmu in instances:
            fmu.fmu.reset()
        np.testing.assert_array_equal(
            together, [voyage(fmu, order) for fmu, order in zip(instances, orders, strict=True)]
        )
        assert len({row[0] for row in together}) == 8
        for fmu in instances[1:]:
            fmu.fmu.freeInstance()


@pytest.mark.parametrize("fmi", [2, 3])
def test_two_source_fmus_in_one_program(fmus: Fmus, fmi: int, tmp_path: Path) -> None:
    """By the prefix macro of the standard's headers; a compiler without a warning."""
    prefixes = []
    for name in ("paper", "steered"):
        with zipfile.ZipFile(fmus(name, fmi)) as packed:
            packed.extractall(tmp_path / name)
        description = (tmp_path / name / "modelDescription.xml").read_text("utf-8")
        prefixes.append(description.partition('modelIdentifier="')[2].partition('"')[0])
        macro = f"-DFMI{fmi}_FUNCTION_PREFIX={prefixes[-1]}_"
        compile_ = [
            COMPILER,
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
            macro,
            "-c",
            f"{name}/sources/fmi{fmi}.c",
        ]
        subprocess.run([*compile_, "-o", f"{name}.o"], cwd=tmp_path, check=True)
    assert prefixes[0] != prefixes[1]
    calls = "".join(f"extern const char *{prefix}_fmi{fmi}GetVersion(void);\n" for prefix in prefixes)
    both = " + ".join(f"({prefix}_fmi{fmi}GetVersion()[0] == '{fmi}')" for prefix in prefixes)
    (tmp_path / "main.c").write_text(f"{calls}int main(void) {{ return {both} == 2 ? 0 : 1; }}\n", encoding="utf-8")
    subprocess.run([COMPILER, "main.c", "paper.o", "steered.o", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"]).returncode == 0


@pytest.mark.skipif(shutil.which("cmake") is None, reason="no cmake is here for FMPy to build the sources with")
def test_an_importer_builds_the_sources(fmus: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from fmpy.build import build_platform_binary

    monkeypatch.setattr("narrows.export.fmu.builds_here", lambda fmi: ())
    for fmi in (2, 3):
        path = tmp_path / f"bare{fmi}.fmu"
        nw.export.write(model_of("paper"), path, fmi=fmi)
        folder = tmp_path / f"bare{fmi}"
        (tmp_path / f"build{fmi}").mkdir()
        with zipfile.ZipFile(path) as packed:
            packed.extractall(folder)
        build_platform_binary(folder, tmp_path / f"build{fmi}")
        assert list(folder.glob("binaries/*/bare*"))
