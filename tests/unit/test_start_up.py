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


def test_importing_the_package_loads_nothing_heavy() -> None:
    assert not loaded_by("import narrows") & set(HEAVY)


@pytest.mark.parametrize("package", ["narrows", "narrows.report", "narrows.simulation"])
def test_every_name_of_a_stub_loads(package: str) -> None:
    code = f"import importlib\npackage = importlib.import_module({package!r})\nassert dir(package) == package.__all__\n"
    loaded_by(f"{code}assert all(hasattr(package, name) for name in package.__all__)")


def test_a_module_does_not_hide_the_function_of_its_name() -> None:
    assert loaded_by(
        "import narrows.simulation.ensemble\nfrom narrows.simulation import ensemble\nensemble.__defaults__"
    )


@pytest.mark.slow
def test_identification_needs_no_compiler() -> None:
    code = "import narrows as nw; nw.identify(nw.twin(rate=1.0)).to_dict()"
    assert not loaded_by(code) & {"numba", "sympy", "matplotlib"}


@pytest.mark.slow
def test_one_voyage_needs_no_compiler() -> None:
    code = "import narrows as nw; nw.simulate(nw.published('mikkelsen2025_dtc'), y=1.0)"
    loaded_by(code)  # the first run may trace; the second finds what it wrote
    assert not loaded_by(code) & {"numba", "sympy", "pandas", "xarray", "matplotlib"}


@pytest.mark.slow
def test_identifying_the_measured_tests_needs_no_optimiser_and_no_units_library() -> None:
    code = "import narrows as nw; nw.identify(nw.measured_tests('kcs').by_condition()['C0101A01']).to_dict()"
    heavy = {"scipy.optimize", "scipy.linalg", "pint", "matplotlib"}
    # SciPy 1.18 loads scipy.linalg with its special functions, which the intervals need.
    assert not (loaded_by(code) - loaded_by("import scipy.special")) & heavy
