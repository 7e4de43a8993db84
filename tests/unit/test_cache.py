"""The cache: made once, by however many processes at once, and mended where it is spoilt."""

import ctypes
import os
import pickle
import random
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import narrows as nw
from narrows.codegen import cache
from narrows.codegen.compilation import address
from narrows.codegen.free_motion import Choices
from narrows.codegen.system import System

SAIL = """
import importlib
import sys
import narrows as nw
model = nw.published("mikkelsen2025_dtc")
nw.simulate(model, y=0.5, duration=1.0)
plain = not {{"sympy", "numba"}} & set(sys.modules)
found = {work}
from narrows.codegen.cache import compiled_loops
loops = importlib.import_module("narrows.codegen.kernels.{module}")
stats = compiled_loops(loops).{function}.stats
hits, misses = (sum(count.values()) for count in (stats.cache_hits, stats.cache_misses))
print(plain, "sympy" in sys.modules, hits, misses, found.hex())
"""
TANGENT = 'nw.sensitivities(model, by=("y",), y=0.5, duration=1.0).of("y", "y")[-1]', "loops", "integrate"
FLEET = 'nw.ensemble(model, y=0.5, duration=40.0)["distance"].item()', "queue", "integrate_fleet"
VALUES = {**(DTC := nw.published("mikkelsen2025_dtc")).configuration.values(), **DTC.coefficients}


def system() -> System:
    """One of its own, that has read nothing yet."""
    return System(nw.PAPER, "held", False, Choices())


def started(folder: Path, seed: str, work: tuple[str, str, str]) -> subprocess.Popen[str]:
    environment = {**os.environ, "NARROWS_CACHE_DIR": str(folder), "PYTHONHASHSEED": seed}
    text = SAIL.format(**dict(zip(("work", "module", "function"), work, strict=True)))
    return subprocess.Popen([sys.executable, "-c", text], env=environment, stdout=subprocess.PIPE, text=True)


def said(process: subprocess.Popen[str]) -> list[str]:
    answer, _ = process.communicate(timeout=300)
    assert process.returncode == 0
    return answer.split()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("work", "parts"),
    [(TANGENT, ["loops", "plain", "plain", "tangent"]), (FLEET, ["bank", "event", "kernel", "plain", "queue"])],
    ids=["tangent", "fleet"],
)
def test_two_processes_at_once_then_a_third_that_compiles_nothing(
    work: tuple[str, str, str], parts: list[str], tmp_path: Path
) -> None:
    """Different hash seeds: the text does not depend on the order of a set."""
    both = [started(tmp_path, seed, work) for seed in ("1", "2")]
    first, second = (said(process) for process in both)
    files = {path.name: path.read_text() for path in (tmp_path / "compiled").glob("*.py")}
    plain, with_sympy, hits, misses, x = said(started(tmp_path, "3", work))
    assert (plain, with_sympy, hits, misses) == ("True", "False", "1", "0")
    assert first[-1] == second[-1] == x
    assert sorted(name.partition("_")[0] for name in files) == parts
    assert files == {path.name: path.read_text() for path in (tmp_path / "compiled").glob("*.py")}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("NARROWS_CACHE_DIR", str(tmp_path))
    return tmp_path / "compiled"


def test_a_new_fit_makes_no_new_file(folder: Path) -> None:
    for b_v in (100.0, 120.0):
        system().constants({**VALUES, "b_v": b_v})
    assert len(list(folder.glob("*.py"))) == 1


@pytest.mark.parametrize("spoilt", ["", "def rates(x, y", "\0\1\2"])
def test_a_spoilt_file_is_made_again(folder: Path, monkeypatch: pytest.MonkeyPatch, spoilt: str) -> None:
    before = system().constants(VALUES)
    (path,) = folder.glob("*.py")
    path.write_text(spoilt)
    monkeypatch.setattr(cache, "_MODULES", {})
    assert system().constants(VALUES) == before
    assert path.read_text().endswith(cache.LAST_LINE)


def test_a_closed_folder_is_done_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("no folder can be made below a file")
    monkeypatch.setenv("NARROWS_CACHE_DIR", str(tmp_path / "file"))
    assert system().constants(VALUES)
    assert (tmp_path / "file").is_file()


TWICE = """
import sys
from narrows.codegen import cache
function = cache.import_generated("twice", ["part"], lambda: sys.argv[1]).twice
print(function(21.0), sum(function.stats.cache_hits.values()), sum(function.stats.cache_misses.values()))
"""


def test_two_processes_compile_a_function_at_once_and_a_third_reads_it(tmp_path: Path) -> None:
    environment = {**os.environ, "NARROWS_CACHE_DIR": str(tmp_path)}

    def begun() -> subprocess.Popen[str]:
        words = [sys.executable, "-c", TWICE, TEXT]
        return subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, text=True)

    assert [said(process)[0] for process in (begun(), begun())] == ["42.0", "42.0"]
    assert said(begun()) == ["42.0", "1", "0"]


PLACES = {
    "linux": (".cache/narrows", {}),
    "darwin": ("Library/Caches/narrows", {}),
    "win32": ("AppData/Local/narrows/narrows/Cache", {}),
    "linux with XDG_CACHE_HOME": ("other/narrows", {"XDG_CACHE_HOME": "other"}),
    "win32 with LOCALAPPDATA": ("other/narrows/narrows/Cache", {"LOCALAPPDATA": "other"}),
}


@pytest.mark.parametrize("case", PLACES)
def test_the_folder_is_where_the_system_keeps_caches(case: str, tmp_path: Path, monkeypatch) -> None:
    place, variables = PLACES[case]
    for variable in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(variable, raising=False)
    for variable, folder in variables.items():
        monkeypatch.setenv(variable, str(tmp_path / folder))
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr("sys.platform", case.split()[0])
    assert cache.user_cache_folder() == tmp_path / place


def test_versions_are_part_of_the_name(monkeypatch: pytest.MonkeyPatch) -> None:
    before = cache.key_of(["a", "b"])
    assert before == cache.key_of(["a", "b"]) != cache.key_of(["a", "c"])
    monkeypatch.setattr(cache, "versions", lambda: "another world")
    assert before != cache.key_of(["a", "b"])


TEXT = """import numba

cached = numba.njit(cache=True)


@cached
def twice(x):
    return 2 * x
"""

SUM = """
def sum_of(values):
    return (values[0] + values[1],)
"""


def twice() -> tuple[float, int]:
    """What a generated function says in a process that has not read it yet, and whether it was compiled before."""
    function = cache.import_generated("twice", ["part"], lambda: TEXT).twice
    return function(21.0), sum(function.stats.cache_hits.values())


@pytest.fixture
def anew(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], tuple[float, int]]:
    def run() -> tuple[float, int]:
        monkeypatch.setattr(cache, "_MODULES", {})
        return twice()

    assert run() == (42.0, 0)
    assert run() == (42.0, 1)
    return run


def test_signatures_that_two_processes_compile_at_once_have_two_files(tmp_path: Path, monkeypatch) -> None:
    """Each process sees an empty folder, as two do that begin together."""
    names = []
    for i, value in enumerate((21.0, 21, 21.0)):
        monkeypatch.setenv("NARROWS_CACHE_DIR", str(tmp_path / str(i)))
        monkeypatch.setattr(cache, "_MODULES", {})
        assert cache.import_generated("twice", ["part"], lambda: TEXT).twice(value) == 42
        names += [path.name for path in (tmp_path / str(i)).rglob("*.nbc")]
    assert names[0] == names[2] != names[1]


def middle(content: bytes) -> bytes:
    at = len(content) // 2
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


DAMAGE = {
    "empty": lambda content: b"",
    "cut short": lambda content: content[: len(content) // 2],
    "a byte short": lambda content: content[:-1],
    "zeros": lambda content: bytes(len(content)),
    "garbage": lambda content: random.Random(0).randbytes(len(content)),
    "one bit": middle,
    "another pickle": lambda content: pickle.dumps("0.1") + pickle.dumps(("stamp", 3)),
    "more": lambda content: content + b"#",
}


@pytest.mark.parametrize("kind", DAMAGE)
@pytest.mark.parametrize("suffix", [".py", ".nbc"])
def test_a_damaged_file_is_made_again(kind: str, suffix: str, folder: Path, anew) -> None:
    (path,) = folder.rglob(f"*{suffix}")
    path.write_bytes(DAMAGE[kind](path.read_bytes()))
    assert anew()[0] == 42.0
    assert anew() == (42.0, 1)


def test_nothing_of_pythons_own_is_read(folder: Path, anew) -> None:
    assert not list(folder.rglob("*.pyc"))


@pytest.mark.parametrize("suffix", [".py", ".nbc"])
def test_a_folder_in_the_place_of_a_file(suffix: str, folder: Path, anew) -> None:
    (path,) = folder.rglob(f"*{suffix}")
    path.unlink()
    path.mkdir()
    assert anew()[0] == 42.0


def test_a_folder_that_vanishes(folder: Path, anew) -> None:
    shutil.rmtree(folder)
    assert anew() == (42.0, 0)
    assert anew() == (42.0, 1)


def test_a_folder_that_vanishes_before_the_function_compiles(folder: Path) -> None:
    function = cache.import_generated("twice", ["part"], lambda: TEXT).twice
    shutil.rmtree(folder)
    folder.write_text("no folder can be made here now")
    assert function(21.0) == 42.0


FULL = """
import resource, sys
from narrows.codegen import cache
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), resource.RLIM_INFINITY))
function = cache.import_generated("twice", ["part"], lambda: sys.argv[2]).twice
print(function(21.0), function.__code__.co_filename)
"""


@pytest.mark.skipif(os.name != "posix", reason="a limit on the size of files is one of Unix")
@pytest.mark.parametrize("room", [0, 1, 300, 2000])
def test_a_disk_without_room(room: int, tmp_path: Path) -> None:
    """No file may grow beyond so many bytes: none at all, no module, the module but not its machine code."""
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(room), TEXT], env={**os.environ, "NARROWS_CACHE_DIR": str(tmp_path)},
        capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    assert done.stdout.startswith("42.0"), done.stderr
    assert not done.stderr
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and (room < 300 or path.suffix == ".nbc")]


def test_a_mistake_in_what_is_generated_is_not_hidden(folder: Path) -> None:
    with pytest.raises(SyntaxError):
        cache.import_generated("wrong", [], lambda: "def f(:")
    assert not [name for name in sys.modules if name.startswith("narrows_wrong")]


def sum_of(numbers: tuple[float, float]) -> float:
    """What a straight line gives in a process that has not read it yet."""
    module = cache.import_generated("sum", ["part"], lambda: SUM)
    given, results = (ctypes.c_double * 2)(*numbers), (ctypes.c_double * 1)()
    ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)(address(module, "sum_of"))(given, results)
    return results[0]


@pytest.mark.parametrize("kind", DAMAGE)
def test_damaged_machine_code_is_made_again(kind: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was made is then read: a compiler that fails is not asked."""
    assert sum_of((40.0, 2.0)) == 42.0
    (path,) = folder.glob("*.o")
    whole = path.read_bytes()
    path.write_bytes(DAMAGE[kind](whole))
    monkeypatch.setattr(cache, "_MODULES", {})
    assert sum_of((40.0, 2.0)) == 42.0
    assert path.read_bytes() == whole
    monkeypatch.setattr(cache, "_MODULES", {})
    monkeypatch.setattr("narrows.codegen.compilation.optimised", None)
    assert sum_of((20.0, 1.0)) == 21.0


def test_machine_code_of_another_text_is_not_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert sum_of((40.0, 2.0)) == 42.0
    monkeypatch.setattr(cache, "_MODULES", {})
    for path in folder.glob("*.py"):
        path.unlink()
    monkeypatch.setitem(globals(), "SUM", SUM.replace("+", "-"))
    assert sum_of((40.0, 2.0)) == 38.0


def test_machine_code_needs_no_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder.write_text("no folder can be made here")
    assert sum_of((40.0, 2.0)) == 42.0
