"""What is said while something takes long: bars, stages, and lines to whoever listens."""

import logging
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import IO, Any

LARGE = 20_000_000
"""Bytes of a file that takes long to read."""
Listener = Callable[[str], None]
LISTENERS: list[Listener] = []
"""Who hears what takes long; the command line is one where somebody looks at it."""


class _Lines(logging.Handler):
    """Hands what the package logs to a listener."""

    def __init__(self, listener: Listener) -> None:
        super().__init__(logging.INFO)
        self.listener = listener

    def emit(self, record: logging.LogRecord) -> None:
        self.listener(record.getMessage())


@contextmanager
def listening(listener: Listener, wanted: bool = True) -> Iterator[None]:
    """Hear what takes long: what the package logs, and bars beside it (ours).

    Parameters
    ----------
    listener : callable
        Takes a line.
    wanted : bool
        Whether to.
    """
    if not wanted:
        yield
        return
    logger, lines = logging.getLogger("narrows"), _Lines(listener)
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
    """Show how many are done, if wanted (ours).

    Parameters
    ----------
    total : int
        In all.
    shown : bool
        Whether to.
    what : str
        They are.
    """
    if not shown:
        yield lambda done: None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=_stderr(), transient=True) as progress:
        task = progress.add_task(what, total=total)
        yield lambda done: progress.advance(task, done)


def opened(path: Path) -> AbstractContextManager[IO[bytes]]:
    """Open a file, with a bar of the bytes that were read where it is large and somebody listens (ours).

    Parameters
    ----------
    path : Path
        The file.
    """
    if not LISTENERS or path.stat().st_size < LARGE:
        return path.open("rb")
    from rich.progress import open as opened_with_bar

    return opened_with_bar(path, "rb", description=f"reading {path.name}", console=_stderr(), transient=True)


def stage(what: str) -> AbstractContextManager[object]:
    """Show what is being done, where somebody listens (ours).

    Parameters
    ----------
    what : str
        In a word or two.
    """
    return _stderr().status(f"{what} ...") if LISTENERS else nullcontext()


def _stderr() -> Any:
    from rich.console import Console

    return Console(stderr=True)
