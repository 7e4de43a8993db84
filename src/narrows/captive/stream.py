"""Tests that stay on disk: the same blocks of rows, read when asked for, so that memory does not grow."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from narrows.captive import tests
from narrows.captive.frames import read_chunks
from narrows.captive.read import Rows, checked, prepared, sha256_of, tests_of
from narrows.captive.tests import Block, Span, cuts
from narrows.errors import InputError
from narrows.files import path_of
from narrows.model.model import Source
from narrows.ship.particulars import Configuration
from narrows.ship.ship_file import read_ship
from narrows.terms.canal_tables import PAPER
from narrows.terms.term import TermTable


@dataclass(frozen=True)
class StreamedTests:
    """Captive tests on disk.

    Parameters
    ----------
    path : Path
        CSV or Parquet.
    configuration : Configuration
        Ship, canal and water.
    terms : TermTable
        What the columns must suffice for.
    where : str, optional
        Which rows to take.
    source : Source
        Where the rows come from.
    notes : tuple of str
        What the reader has to say.
    """

    path: Path
    configuration: Configuration
    terms: TermTable
    where: str | None = None
    source: Source = field(default_factory=Source)
    notes: tuple[str, ...] = ("rows streamed from disk",)

    @property
    def names(self) -> tuple[str, ...]:
        """The tests."""
        return tuple(self.lengths)

    @cached_property
    def lengths(self) -> dict[str, int]:
        """Rows of each test, by a first pass over their names; each must stand in one stretch of the file."""
        lengths: dict[str, int] = {}
        last = None
        for frame in self._frames():
            for name, start, stop in _stretches(tests_of(frame, str(self.path))):
                if name in lengths and name != last:
                    raise InputError(f"{self.path}: the rows of test {name} do not stand together; sort it by test")
                lengths[name] = lengths.get(name, 0) + stop - start
                last = name
        if not lengths:
            raise InputError(f"{self.path}: no rows are left to read; give a test at least one row")
        return lengths

    def blocks(self, pieces: int = 1) -> Iterator[Block]:
        """Yield every row once, in blocks.

        Parameters
        ----------
        pieces : int
            Into how many consecutive stretches each test is cut.

        Raises
        ------
        InputError
            At the first thing that is wrong, or where the rows are of more than one condition.
        """
        done = dict.fromkeys(self.names, 0)
        last: tuple[str, float] = ("", -np.inf)
        conditions: set[str] = set()
        for frame in self._frames():
            rows = checked(frame, self.configuration, self.terms, str(self.path))
            conditions |= set(rows.condition)
            self._check_continued(rows, last, conditions)
            last = (str(rows.test[-1]), float(rows.columns["t"][-1]) if "t" in rows.columns else -np.inf)
            spans = list(self._spans(rows.test, pieces, done))
            yield Block({**self.configuration.values(), **rows.columns}, len(frame), spans)

    def _frames(self) -> Iterator[pd.DataFrame]:
        for chunk in read_chunks(self.path, tests.BLOCK_ROWS):
            frame, _ = prepared(chunk, self.where, str(self.path))
            if len(frame):
                yield frame

    def _spans(self, test: np.ndarray, pieces: int, done: dict[str, int]) -> Iterator[Span]:
        """Cut the rows at hand where the whole test would be cut; ``done`` counts the rows that went before."""
        for name, start, stop in _stretches(test):
            first = done[name]
            done[name] += stop - start
            for piece, (a, b) in enumerate(pairwise(cuts(self.lengths[name], pieces).tolist())):
                low, high = max(a, first), min(b, done[name])
                if low < high:
                    yield Span(name, piece, start + low - first, start + high - first)

    def _check_continued(self, rows: Rows, last: tuple[str, float], conditions: set[str]) -> None:
        if len(conditions) > 1:
            raise InputError(
                f"{self.path}: holds several conditions ({', '.join(sorted(conditions)[:3])}, ...); "
                "choose one with a selection of rows"
            )
        name, t = last
        if "t" in rows.columns and rows.test[0] == name and rows.columns["t"][0] <= t:
            raise InputError(f"{self.path}: test {name} goes back in time at t = {rows.columns['t'][0]:g} s; sort it")


def _stretches(test: np.ndarray) -> Iterator[tuple[str, int, int]]:
    """Each run of rows of one test: name, first row, row after the last."""
    edges = np.flatnonzero(np.concatenate([[True], test[1:] != test[:-1], [True]]))
    for start, stop in pairwise(edges.tolist()):
        yield str(test[start]), start, stop


def stream_captive(
    path: str | Path, ship: str | Path | Configuration, terms: TermTable = PAPER, where: str | None = None
) -> StreamedTests:
    """Open a table of captive tests that is read block by block each time it is needed.

    Parameters
    ----------
    path : str or Path
        CSV or Parquet, in the columns of ``read_captive``.
    ship : str, Path or Configuration
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
    path = path_of("path", path)
    if not path.is_file():
        raise InputError(f"{path}: there is no such file; check the path")
    configuration = ship if isinstance(ship, Configuration) else read_ship(ship)
    return StreamedTests(path, configuration, terms, where, Source("captive tests", path.name, sha256_of(path)))
