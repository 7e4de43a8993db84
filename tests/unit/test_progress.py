"""What takes long is said where somebody listens, and nowhere else."""

import importlib
import logging
from pathlib import Path

import pytest

import narrows as nw
from narrows.base import progress
from narrows.base.progress import bar, listening, opened, stage
from narrows.codegen import cache
from tables import frame_of, short_twin, written

LOOPS = '''"""Two functions."""
def three():
    return 3

def four(one):
    return three() + one
'''


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
    """Not where Numba finds on disk what it compiled before."""
    monkeypatch.setenv("NARROWS_CACHE_DIR", str(tmp_path))
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "two_loops.py").write_text(LOOPS)
    module = importlib.import_module("two_loops")
    heard: list[str] = []
    with listening(heard.append):
        for _ in range(2):
            cache._MODULES.clear()
            assert cache.compiled_loops.__wrapped__(module).four(1) == 4
    (note,) = heard
    assert note.startswith("compiling loops over vessels")


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
