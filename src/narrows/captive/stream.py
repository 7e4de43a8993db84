"""Tests that stay on disk: the same blocks of rows, read when asked for, so that memory does not grow."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from narrows.captive.frames import read_chunks
from narrows.captive.read import Rows, checked, prepared, sha256_of
from narrows.captive.tests import BLOCK_ROWS, Block, Span
from narrows.errors import InputError
from narrows.model import Source
from narrows.particulars import Setting, read_ship
from narrows.terms import PAPER, TermTable


@dataclass(frozen=True)
class StreamedTests:
    """Captive tests on disk.

    Parameters
    ----------
    path : Path
        CSV or Parquet.
    setting : Setting
        Ship, canal and water.
    terms : TermTable
        What the columns must suffice for.
    where : str, optional
        Which rows to take.
    source : Source
        Where the rows come from.
    """

    path: Path
    setting: Setting
    terms: TermTable
    where: str | None = None
    source: Source = field(default_factory=Source)
    notes: tuple[str, ...] = ("rows streamed from disk",)
    names: tuple[str, ...] = ()

    def blocks(self, pieces: int = 1) -> Iterator[Block]:
        """Yield every row once, in blocks; each test must stand in one stretch of the file.

        Parameters
        ----------
        pieces : int
            Into how many groups of rows each test is cut, in turn.

        Raises
        ------
        InputError
            At the first thing that is wrong, or where the rows are of more than one condition.
        """
        seen: dict[str, int] = {}
        last: tuple[str, float] = ("", -np.inf)
        conditions: set[str] = set()
        for chunk in read_chunks(self.path, BLOCK_ROWS):
            frame, _ = prepared(chunk, self.where, str(self.path))
            if not len(frame):
                continue
            rows = checked(frame, self.setting, self.terms, str(self.path))
            conditions |= set(rows.condition)
            self._check_continued(rows, last, conditions)
            last = (str(rows.test[-1]), float(rows.columns["t"][-1]) if "t" in rows.columns else -np.inf)
            yield Block({**self.setting.values(), **rows.columns}, len(frame), _spans(rows, pieces, seen))

    def _check_continued(self, rows: Rows, last: tuple[str, float], conditions: set[str]) -> None:
        if len(conditions) > 1:
            raise InputError(
                f"{self.path}: holds several conditions ({', '.join(sorted(conditions)[:3])}, ...); "
                "choose one with a selection of rows"
            )
        name, t = last
        if "t" in rows.columns and rows.test[0] == name and rows.columns["t"][0] <= t:
            raise InputError(f"{self.path}: test {name} goes back in time at t = {rows.columns['t'][0]:g} s; sort it")


def _spans(rows: Rows, pieces: int, seen: dict[str, int]) -> list[Span]:
    edges = np.flatnonzero(np.concatenate([[True], rows.test[1:] != rows.test[:-1], [True]]))
    spans = []
    for start, stop in pairwise(edges):
        name = str(rows.test[start])
        spans.append(Span(name, seen.get(name, 0) % pieces, int(start), int(stop)))
        seen[name] = seen.get(name, 0) + 1
    return spans


def stream_captive(
    path: str | Path, ship: str | Path | Setting, terms: TermTable = PAPER, where: str | None = None
) -> StreamedTests:
    """Open a table of captive tests that is read block by block each time it is needed.

    Parameters
    ----------
    path : str or Path
        CSV or Parquet, in the columns of ``read_captive``.
    ship : str, Path or Setting
        The ship file, or what was read from it.
    terms : TermTable
        What the columns must suffice for.
    where : str, optional
        Which rows to take.

    Returns
    -------
    StreamedTests
        For ``identify``; figures need the rows in memory.

    Raises
    ------
    InputError
        Where the file is absent; rows are checked as they pass.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: there is no such file; check the path")
    setting = ship if isinstance(ship, Setting) else read_ship(ship)
    return StreamedTests(path, setting, terms, where, Source("captive tests", path.name, sha256_of(path)))
