"""The cache: made once, by however many processes at once, and mended where it is spoilt."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import narrows as nw
from narrows.compile import cache, compiled

SAIL = """
import sys
import narrows as nw
from narrows.compile import compiled
model = nw.published("mikkelsen2025_dtc")
values = {**model.configuration.values(), **model.coefficients}
program = compiled(model.terms)
program.rhs(0.0, 0.5, 1.0, 0.0, 1.0, *[0.0] * 5, 1.0, 0.0, 0.0, *program.constants(values))
plain = not {"sympy", "numba"} & set(sys.modules)
end = program.fleet(values, y=0.5, u=1.0, dt=0.02, duration=40.0)
stats = program.kernel(False, "float64", "none").fleet.stats
print(plain, "sympy" in sys.modules, sum(stats.cache_hits.values()), sum(stats.cache_misses.values()), end.x[0].hex())
"""
VALUES = {**(DTC := nw.published("mikkelsen2025_dtc")).configuration.values(), **DTC.coefficients}


def started(folder: Path, seed: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "NARROWS_CACHE_DIR": str(folder), "PYTHONHASHSEED": seed}
    return subprocess.Popen([sys.executable, "-c", SAIL], env=environment, stdout=subprocess.PIPE, text=True)


def said(process: subprocess.Popen[str]) -> list[str]:
    answer, _ = process.communicate(timeout=300)
    assert process.returncode == 0
    return answer.split()


@pytest.mark.slow
def test_two_processes_at_once_then_a_third_that_compiles_nothing(tmp_path: Path) -> None:
    """Different hash seeds: the text does not depend on the order of a set."""
    both = [started(tmp_path, seed) for seed in ("1", "2")]
    first, second = (said(process) for process in both)
    files = {path.name: path.read_text() for path in (tmp_path / "compiled").glob("*.py")}
    plain, with_sympy, hits, misses, x = said(started(tmp_path, "3"))
    assert (plain, with_sympy, hits, misses) == ("True", "False", "1", "0")
    assert first[-1] == second[-1] == x
    assert len(files) == 2
    assert files == {path.name: path.read_text() for path in (tmp_path / "compiled").glob("*.py")}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("NARROWS_CACHE_DIR", str(tmp_path))
    return tmp_path / "compiled"


def test_a_new_fit_makes_no_new_file(folder: Path) -> None:
    for b_v in (100.0, 120.0):
        compiled(nw.PAPER).constants({**VALUES, "b_v": b_v})
    assert len(list(folder.glob("*.py"))) == 1


@pytest.mark.parametrize("spoilt", ["", "def rhs(x, y", "\0\1\2"])
def test_a_spoilt_file_is_made_again(folder: Path, monkeypatch: pytest.MonkeyPatch, spoilt: str) -> None:
    before = compiled(nw.PAPER).constants(VALUES)
    (path,) = folder.glob("*.py")
    path.write_text(spoilt)
    monkeypatch.setattr(cache, "_MODULES", {})
    assert compiled(nw.PAPER).constants(VALUES) == before
    assert path.read_text().endswith(cache.LAST_LINE)


def test_a_closed_folder_is_done_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("no folder can be made below a file")
    monkeypatch.setenv("NARROWS_CACHE_DIR", str(tmp_path / "file"))
    assert compiled(nw.PAPER).constants(VALUES)
    assert cache.cache_folder().parent != tmp_path / "file"


def test_versions_are_part_of_the_name(monkeypatch: pytest.MonkeyPatch) -> None:
    before = cache.key_of(["a", "b"])
    assert before == cache.key_of(["a", "b"]) != cache.key_of(["a", "c"])
    monkeypatch.setattr(cache, "versions", lambda: "another world")
    assert before != cache.key_of(["a", "b"])
