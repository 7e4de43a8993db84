"""Console blocks of the docs, run as a reader would run them, and held to what the page shows.

A block has commands, each after ``$ ``, and below each what it prints. Every command runs, in a folder of the page's
own, and leaves with exit code 0, or with N where its comment says ``exit N``. Lines that are shown below it are what it
prints, all of it and in order; ``...`` stands for any lines, or within a line for anything. ``# not run: reason`` is
the one way out; ``# your files`` asks for stand-ins of the files that a reader brings.
"""

import multiprocessing
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory

ROOT = Path(__file__).parents[1]
READ_BY_PAGES = ("docs/broken.csv", "docs/ship.toml", "src/narrows/captive/measured")
COMMENT = re.compile(r"\s#\s(?P<comment>.*)$")
LIMIT = 300
"""Seconds that a command may take."""
WIDTH = "120"
"""Of the terminal, in characters."""
FORKED = multiprocessing.get_context(
    "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
)
if FORKED.get_start_method() == "forkserver":
    FORKED.set_forkserver_preload(
        ["narrows.cli", "scipy.stats", "scipy.optimize", "pandas", "xarray", "sympy", "numba", "matplotlib.pyplot"]
    )


@dataclass(frozen=True)
class Command:
    """A command of a page: what is typed, what its comment says, and the lines shown below it."""

    text: str
    comment: str
    shown: tuple[str, ...]

    @property
    def exit_code(self) -> int:
        found = re.search(r"\bexit (\d+)", self.comment)
        return int(found[1]) if found else 0

    @property
    def runs(self) -> bool:
        return not re.match(r"not run: \w", self.comment)


def commands(block: str) -> Iterator[Command]:
    """Yield the commands of a console block."""
    before, *parts = ("\n" + block).split("\n$ ")
    assert not before.strip(), f"a console block begins with a command after '$ ', not with {before.strip()!r}"
    for part in parts:
        text, _, shown = part.partition("\n")
        found = COMMENT.search(text)
        yield Command(text, found["comment"] if found else "", tuple(shown.rstrip().splitlines()))


def agrees(shown: tuple[str, ...], printed: str) -> bool:
    """Whether the lines that a page shows are what was printed, in order and with nothing left out but by ``...``."""
    pattern = "".join(r"(?:[^\n]*\n)*" if line.strip() == "..." else _line(line) for line in shown)
    return re.fullmatch(pattern, "".join(f"{line.rstrip()}\n" for line in printed.rstrip().splitlines())) is not None


def _line(shown: str) -> str:
    return r"[^\n]*".join(map(re.escape, shown.rstrip().split("..."))) + r"\n"


def run(command: Command, folder: Path) -> None:
    """Run a command in a folder and hold it to its page."""
    if "your files" in command.comment:
        shutil.copytree(readers_files().name, folder, dirs_exist_ok=True)
    words = shlex.split(command.text, comments=True)
    code, printed = in_fork(words, folder) if words[0] == "narrows" else in_process(words, folder)
    said = f"$ {command.text}\n{printed}"
    assert code == command.exit_code, f"exit code {code}, not {command.exit_code}:\n{said}"
    expected = "\n".join(command.shown)
    assert not command.shown or agrees(command.shown, printed), f"the page shows\n{expected}\nbut\n{said}"


def in_process(words: list[str], folder: Path) -> tuple[int, str]:
    """Run a command in a process; return its exit code and what it prints."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    source = os.pathsep.join(filter(None, [str(ROOT / "src"), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        words, cwd=folder, env={**os.environ, "PATH": path, "PYTHONPATH": source, "COLUMNS": WIDTH},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, encoding="utf-8", timeout=LIMIT,
    )  # fmt: skip
    return done.returncode, done.stdout


def in_fork(words: list[str], folder: Path) -> tuple[int, str]:
    """Run the command line in a fork of a process that has imported its libraries: they take half of most commands."""
    with NamedTemporaryFile("r", encoding="utf-8") as printed:
        process = FORKED.Process(target=_command_line, args=(words, folder, printed.name, dict(os.environ)))
        process.start()
        process.join(LIMIT)
        assert process.exitcode is not None, f"{words} took more than {LIMIT} s"
        return process.exitcode, printed.read()


def _command_line(words: list[str], folder: Path, printed: str, environment: dict[str, str]) -> None:
    from narrows.cli import main

    os.environ.update(environment, COLUMNS=WIDTH)
    os.chdir(folder)
    with open(printed, "w", encoding="utf-8") as file:
        sys.argv, sys.stdout, sys.stderr = words, file, file
        main()


def fill(folder: Path) -> None:
    """Put the files of the repository that pages read into a folder, under the names they have there."""
    for name in READ_BY_PAGES:
        source, target = ROOT / name, folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(source, target) if source.is_dir() else shutil.copy(source, target)


@cache
def readers_files() -> TemporaryDirectory[str]:
    """Return a folder, kept to the end of the run, with the files that a reader brings."""
    import readers_files

    folder = TemporaryDirectory(prefix="narrows-docs-")
    readers_files.write(Path(folder.name))
    return folder
