"""The script that counts how far a number walks: on a package made for it, and on this one."""

import ast
import importlib
import subprocess
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = {
    "narrows/__init__.py": "",
    "narrows/cli.py": "from narrows.fits import fitted\n\ndef verb():\n    print(fitted(1).interval)\n",
    "narrows/fits/__init__.py": "from narrows.fits.fit import fitted as fitted\n",
    "narrows/fits/fit.py": (
        "from narrows.tables import read\n\n"
        "class Fit:\n    @property\n    def interval(self):\n        return bounded(self)\n\n"
        "def fitted(z):\n    read(z)\n    return Fit()\n\n"
        "def bounded(fit):\n    return 0, 1\n"
    ),
    "narrows/tables.py": "def read(path):\n    read_csv(path)\n",
}


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(ROOT / "decisions")
    return importlib.import_module("walk_of_y")


@pytest.fixture
def source(script: Any) -> Any:
    made = script.Source()
    for path, text in PACKAGE.items():
        made.add(path, ast.parse(text))
    return made


def test_the_walk_goes_through_imports_and_members(script: Any, source: Any) -> None:
    stations = {
        "cell": lambda path, node: script.calling("read_csv", path, node),
        "interval": lambda path, node: script.defined_as(("bounded",), path, node),
        "nowhere": lambda path, node: script.defined_as(("absent",), path, node),
    }
    found = script.walk(source, source.edges(), "verb", stations)
    assert found["cell"] == ["narrows.cli.verb", "narrows.fits.fit.fitted", "narrows.tables.read"]
    assert found["interval"] == ["narrows.cli.verb", "narrows.fits.fit.Fit.interval", "narrows.fits.fit.bounded"]
    assert found["nowhere"] == []
    passed = {path for chain in found.values() for path in chain}
    assert script.counted(source, passed) == "3 files, 3 returns"


def test_an_arrow_counts_once(script: Any, source: Any) -> None:
    assert script.arrows(source) == {("cli", "fits"), ("fits", "tables")}


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="not a clone")
def test_every_station_is_found_now(script: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a rename makes a mark miss, the mark is to follow."""
    monkeypatch.chdir(ROOT)
    if subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, check=False).returncode:
        pytest.skip("git does not read this clone")
    source = script.Source.of("HEAD")
    edges = source.edges()
    for verb, stations in script.LEGS.values():
        assert all(script.walk(source, edges, verb, stations).values()), verb
