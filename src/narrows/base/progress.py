"""Progress of long operations: bars, stages, and log lines to listeners."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import IO, Any

# Size of a file that takes long to read [bytes].
LARGE_FILE = 20_000_000
# Listeners to long operations, such as the command line on a terminal.
LISTENERS: list[Callable[[str], None]] = []


@contextmanager
def listening(listener: Callable[[str], None], wanted: bool = True) -> Iterator[None]:
    """Listen to long operations: log lines of the package, with bars."""
    if not wanted:
        yield
        return
    logger, lines = logging.getLogger("narrows"), logging.Handler(logging.INFO)
    lines.emit = lambda record: listener(record.getMessage())  # type: ignore[method-assign]
    before = logger.level
    logger.addHandler(lines)
    logger.setLevel(logging.INFO)
    LISTENERS.append(listener)
    try:
        yield
    finally:
        LISTENERS.remove(listener)
        logger.removeHandler(lines)
        logger.setLevel(before)


@contextmanager
def bar(total: int, shown: bool, what: str = "voyages") -> Iterator[Callable[[int], None]]:
    """Show a bar of finished items, if wanted."""
    if not shown:
        yield lambda done: None
        return
    with _task(what, total) as (display, task):
        yield lambda done: display.advance(task, done)


def is_shown() -> bool:
    """Return whether progress is visible: a listener, or a requested bar."""
    return bool(LISTENERS or _DISPLAYS)


@contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """Open a file, with a bar of the bytes read if it is large and there is a listener."""
    with path.open("rb") as file:
        size = path.stat().st_size
        if not LISTENERS or size < LARGE_FILE:
            yield file
            return
        with _task(f"reading {path.name}", size) as (display, task), display.wrap_file(file, task_id=task) as counted:
            yield counted


@contextmanager
def stage(what: str) -> Iterator[None]:
    """Show the current stage, if there is a listener."""
    with _task(what, None) if LISTENERS else nullcontext():
        yield


@contextmanager
def _task(what: str, total: int | None) -> Iterator[tuple[Any, Any]]:
    """A line of the terminal's one display; whoever starts the display ends it."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with nullcontext() if _DISPLAYS else Progress(*columns, console=Console(stderr=True), transient=True) as started:
        _DISPLAYS.extend([started] if started else [])
        task = _DISPLAYS[0].add_task(what, total=total)
        try:
            yield _DISPLAYS[0], task
        finally:
            _DISPLAYS[0].remove_task(task)
            if started:
                _DISPLAYS.clear()


_DISPLAYS: list[Any] = []
