"""What takes long is said where somebody listens, and nowhere else."""

import logging
from pathlib import Path

import pytest
import rich.progress

import narrows as nw
from narrows.base import progress
from narrows.base.progress import bar, listening, opened, stage
from narrows.codegen import cache
from tables import frame_of, short_twin, written

TEXT = """
import numba

cached = numba.njit(cache=True)
lane = {}

@cached
def three():
    return 3

@cached
def four(one):
    return three() + one
"""


def test_lines_go_to_who_listens() -> None:
    heard: list[str] = []
    tell = logging.getLogger("narrows").info
    tell("before")
    with listening(heard.append):
        tell("while")
        with listening(heard.append, wanted=False):
            tell("once")
    tell("after")
    assert heard == ["while", "once"]


def test_a_first_compilation_says_that_it_compiles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Once a module, and not where Numba finds on disk what it compiled before."""
    monkeypatch.setenv("NARROWS_CACHE_DIR", str(tmp_path))
    heard: list[str] = []
    with listening(heard.append):
        for name in ("first", "first", "second"):
            made = cache.import_generated("kernel", [name, str(tmp_path)], lambda name=name: TEXT.format(repr(name)))
            assert made.four(1) == made.four(2) - 1 == 4
        cache.import_generated("plain", [str(tmp_path)], lambda: "lane = 3\n")
        assert len(heard) == 2
        cache._MODULES.clear()
        again = cache.import_generated("kernel", ["first", str(tmp_path)], lambda: "")
        assert again is not made
        assert again.four(1) == 4
    assert len(heard) == 2
    assert heard[0].startswith("compiling loops over vessels")


def test_the_bar_of_a_compilation_is_full_at_its_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every function that Numba compiles is counted once, beside a bar that waits for it."""
    monkeypatch.setenv("NARROWS_CACHE_DIR", str(tmp_path))
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    seen: dict[str, list[float]] = {}
    advance = rich.progress.Progress.advance

    def counted(self: rich.progress.Progress, task: rich.progress.TaskID, steps: float = 1) -> None:
        advance(self, task, steps)
        of = {task.id: task for task in self.tasks}[task]
        seen.setdefault(of.description, []).append(of.percentage)

    monkeypatch.setattr(rich.progress.Progress, "advance", counted)
    with bar(2, shown=True) as done:
        module = cache.import_generated("kernel", ["full", str(tmp_path)], lambda: TEXT.format("'full'"))
        assert module.four(1) == 4
        done(1)
        done(1)
    assert seen == {"compiling": [50.0, 100.0], "voyages": [50.0, 100.0]}


def test_large_tables_are_read_behind_a_bar(
    ship_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(frame_of(short_twin()), tmp_path / "t.csv")
    monkeypatch.setattr(progress, "LARGE_FILE", 100)
    monkeypatch.setenv("FORCE_COLOR", "1")  # By which rich takes any stream for a terminal.
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    with listening(lambda sentence: None):
        assert nw.read_captive(path, ship_file).rows == short_twin().rows
        with stage("fitting"):
            pass
    assert "reading t.csv" in capsys.readouterr().err
    nw.read_captive(path, ship_file)
    assert capsys.readouterr().err == ""
    with opened(path) as file:
        assert file.read() == path.read_bytes()


def test_a_bar_that_is_not_shown_counts_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with bar(3, shown=False) as advance:
        advance(1)
    assert capsys.readouterr().err == ""
