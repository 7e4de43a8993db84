"""Rows of a log in SI: time, whose record each is, and columns with NaN where nothing was measured."""

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.errors import InputError
from narrows.logbook.reading.log_columns import ABSENT, QUANTITIES, VOCABULARY, LogMapping, renamed
from narrows.readers import cells
from narrows.readers.headers import recognised_in

# Degrees that a place on earth has at most.
EARTH = {"latitude": 90.0, "longitude": 360.0}


class LogRows(NamedTuple):
    """Rows of a log."""

    t: np.ndarray  # (rows,) Time, as it came [s]
    record: np.ndarray  # (rows,) Whose each row is; empty where the log does not say
    columns: dict[str, np.ndarray]  # (rows,) In SI


class RowReader:
    """Brings pieces of one table to rows, one after the other."""

    def __init__(self, table: str, mapping: LogMapping) -> None:
        self.table, self.mapping = table, mapping
        self.notes: tuple[str, ...] = ()
        self.begin: pd.Timestamp | None = None
        self.absent: Counter[str] = Counter()

    def rows(self, raw: pd.DataFrame) -> LogRows:
        """Return a piece in SI."""
        frame, notes = self.mapping.columns.applied(renamed(raw), self.table, VOCABULARY)
        self.notes = notes
        recognised = recognised_in(frame, QUANTITIES, self.table)
        cells.check_once(recognised, [str(header) for header in frame.columns], QUANTITIES, self.table)
        columns = {
            column.quantity: cells.numbers(frame, column.header, self.table, column.quantity != "t") * column.scale
            for column in recognised
        }
        t = columns.pop("t") if "t" in columns else self._clock(frame)
        if not columns:
            raise InputError(f"{self.table}: has times and nothing else; head its columns as in docs/ship-log.md")
        self._check_on_earth(frame, columns)
        record = cells.labels(frame, "record", self.table) if "record" in frame else np.empty(0, dtype=object)
        return LogRows(t, record, {name: self._measured(name, column) for name, column in columns.items()})

    def told(self) -> tuple[str, ...]:
        """What there is to say of the rows that were read."""
        begin = (f"t counts from {self.begin.isoformat()}",) if self.begin is not None else ()
        absent = [f"{count} of {name} stand for none and were left out" for name, count in self.absent.items()]
        return (*self.notes, *begin, *absent)

    def _clock(self, frame: pd.DataFrame) -> np.ndarray:
        """Seconds since the first row, of a column of dates and times."""
        if "time" not in frame:
            raise InputError(f"{self.table}: no column tells the time; head one 't [s]', or 'time' for dates and times")
        if not len(frame):
            return np.empty(0)
        dated = frame["time"] if frame["time"].dtype.kind == "M" else frame["time"].astype(str)
        times = pd.to_datetime(dated, utc=True, errors="coerce", format="ISO8601")
        if times.isna().any():
            row = cells.row_number(frame, times.isna().to_numpy())
            raise InputError(f"{self.table}: row {row}, column 'time' is no date and time; write 2026-05-01T10:00:00Z")
        begin = self.begin = self.begin or times.iloc[0]
        return (times - begin).dt.total_seconds().to_numpy(float)

    def _check_on_earth(self, frame: pd.DataFrame, columns: dict[str, np.ndarray]) -> None:
        for name in columns.keys() & EARTH.keys():
            beyond = (np.abs(columns[name]) > EARTH[name]) & ~np.isin(columns[name], ABSENT[name])
            if beyond.any():
                row, value = cells.row_number(frame, beyond), columns[name][int(np.argmax(beyond))]
                raise InputError(
                    f"{self.table}: row {row}, {name} {value:g} is not on earth; give it in degrees, WGS84"
                )

    def _measured(self, name: str, column: np.ndarray) -> np.ndarray:
        """A column without the numbers that stand for none."""
        none = np.isin(column, ABSENT.get(name, ()))
        if none.any():
            self.absent[name] += int(none.sum())
        return np.where(none, np.nan, column) if none.any() else column


# Rows of a log to records: by their column, or where nothing came for long; none longer than memory likes.
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
