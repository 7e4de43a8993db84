"""What is imported when: start-up counts."""

import subprocess
import sys

import pytest

HEAVY = ("pandas", "scipy", "matplotlib", "sympy", "numba", "xarray")


def loaded_by(code: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())


@pytest.mark.parametrize("module", ["narrows", "narrows.cli"])
def test_importing_the_package_and_its_commands_loads_nothing_heavy(module: str) -> None:
    assert not loaded_by(f"import {module}") & set(HEAVY)


@pytest.mark.slow
def test_identification_needs_no_compiler() -> None:
    code = "import narrows as nw; nw.identify(nw.twin(rate=1.0)).to_dict()"
    assert not loaded_by(code) & {"numba", "sympy", "matplotlib"}


@pytest.mark.slow
def test_one_voyage_needs_no_compiler() -> None:
    code = "import narrows as nw; nw.simulate(nw.published('mikkelsen2025_dtc'), y=1.0)"
    loaded_by(code)  # the first run may trace; the second finds what it wrote
    assert not loaded_by(code) & set(HEAVY)


@pytest.mark.slow
def test_identifying_the_measured_tests_needs_no_charts_and_no_units_library() -> None:
    few = "part.where([place % 4 == 0 for place in range(len(part.names))])"
    read = "import narrows as nw; part = nw.measured_tests('kcs').by_condition()['C0101A03']"
    code = f"{read}; nw.identify({few}).to_dict()"
    assert not loaded_by(code) & {"pint", "matplotlib", "sympy", "numba"}
