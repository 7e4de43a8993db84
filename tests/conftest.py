"""What the tests share: a deterministic Hypothesis profile, and fits that are dear enough to make once."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from hypothesis import settings

import narrows as nw
from nightly import draws
from tables import DTC_SHIP, frame_of, short_twin

settings.register_profile("narrows", derandomize=True, max_examples=draws(25), deadline=None, database=None)
settings.load_profile("narrows")

DEPTHS = {100: "C0101A01", 50: "C0101A02", 20: "C0101A03"}
"""Condition of the KCS tests by under-keel clearance in per cent."""


@pytest.fixture(scope="session")
def dtc() -> nw.Model:
    return nw.published("mikkelsen2025_dtc")


@pytest.fixture(scope="session")
def kcs_tests() -> dict[int, nw.CaptiveTests]:
    """The bundled KCS tests by under-keel clearance in per cent."""
    parts = nw.measured_tests("kcs").by_condition()
    return {clearance: parts[label] for clearance, label in DEPTHS.items()}


@pytest.fixture(scope="session")
def kcs_fits(kcs_tests: dict[int, nw.CaptiveTests]) -> dict[int, nw.Fit]:
    return {clearance: nw.identify(tests) for clearance, tests in kcs_tests.items()}


@pytest.fixture(scope="session")
def twin_fit() -> nw.Fit:
    return nw.identify(nw.twin(seed=0), balance="rows")


@pytest.fixture(scope="session")
def short() -> nw.CaptiveTests:
    return short_twin()


@pytest.fixture
def table(short: nw.CaptiveTests) -> pd.DataFrame:
    """A good table, for a test to spoil."""
    return frame_of(short)


@pytest.fixture
def ship_file(tmp_path: Path) -> Path:
    path = tmp_path / "ship.toml"
    path.write_text(DTC_SHIP)
    return path


@pytest.fixture(scope="module")
def one_tuning() -> Iterator[None]:
    """Pilots without the search for their best tuning, which is most of the time of a small envelope."""
    from narrows.safety.pilots import PILOTS

    with pytest.MonkeyPatch.context() as patch:
        for name, pilot in list(PILOTS.items()):
            patch.setitem(PILOTS, name, replace(pilot, tunings=pilot.tunings[:1]))
        yield


@pytest.fixture
def cli(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Run the command line in this process: arguments in; exit code, stdout and stderr out."""
    from narrows.cli import main

    def run(*words: object) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["narrows", *map(str, words)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as left:
            main()
        shown = capsys.readouterr()
        return int(left.value.code or 0), shown.out, shown.err

    return run


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Measured data that do not come with the package, where they lie beside the repository."""
    folder = Path(__file__).parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the measured data beside the repository are absent")
    return folder
