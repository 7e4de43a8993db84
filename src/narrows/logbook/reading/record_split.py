"""Rows of a log to records: by their column, or where nothing came for long; none longer than memory likes."""

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from narrows.errors import InputError
from narrows.logbook.reading.log_rows import LogRows

# Of a record: a longer one goes on in another, so that memory does not grow with the log.
MOST_ROWS = 500_000


class RawRecord(NamedTuple):
    """The rows of one record."""

    name: str  # Of it
    t: np.ndarray  # (rows,) Time, as it came [s]
    columns: dict[str, np.ndarray]  # (rows,) In SI; NaN where nothing was measured


class RecordSplit:
    """Cuts rows into records as they come."""

    def __init__(self, table: str, stem: str, gap: float) -> None:
        self.table, self.stem, self.gap = table, stem, gap
        self.names: list[str] = []
        self.cuts = 0
        self._last = ("", np.nan)
        self._held: list[LogRows] = []

    def records(self, pieces: Iterable[LogRows]) -> Iterator[RawRecord]:
        """Yield each record when its last row has come."""
        for piece in pieces:
            for part, begins in self._parts(piece):
                if begins and _label(part) in self.names:
                    raise InputError(
                        f"{self.table}: the rows of record {_label(part)} do not stand together; sort it by record"
                    )
                if self._held and (begins or sum(len(held.t) for held in self._held) + len(part.t) > MOST_ROWS):
                    yield self._finished()
                self._held.append(part)
                self._last = (_label(part), float(part.t[-1]))
        if self._held:
            yield self._finished()

    def _parts(self, piece: LogRows) -> Iterator[tuple[LogRows, bool]]:
        """Stretches of one record each, and whether a record begins with it."""
        if not len(piece.t):
            return
        if piece.record.size:
            other = np.concatenate([[self._last[0]], piece.record[:-1]]) != piece.record
        else:
            other = np.diff(piece.t, prepend=self._last[1]) > self.gap
            self.cuts += int(other.sum())
        edges = np.unique([0, *np.flatnonzero(other), len(piece.t)])
        for start, stop in pairwise(edges.tolist()):
            columns = {name: column[start:stop] for name, column in piece.columns.items()}
            yield LogRows(piece.t[start:stop], piece.record[start:stop], columns), bool(other[start])

    def _finished(self) -> RawRecord:
        """Put what is held together."""
        held, self._held = self._held, []
        name = self._named(_label(held[0]))
        names = dict.fromkeys(name for part in held for name in part.columns)
        columns = {own: np.concatenate([_column(part, own) for part in held]) for own in names}
        return RawRecord(name, np.concatenate([part.t for part in held]), columns)

    def _named(self, label: str) -> str:
        """Its label, or that of the file; numbered where it is not the first of that name."""
        stem = label or self.stem
        name = f"{stem} {len(self.names) + 1}" if stem in self.names else stem
        self.names.append(name)
        return name


def _label(rows: LogRows) -> str:
    return str(rows.record[0]) if rows.record.size else ""


def _column(rows: LogRows, name: str) -> np.ndarray:
    return rows.columns.get(name, np.full(len(rows.t), np.nan))
