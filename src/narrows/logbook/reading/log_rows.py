"""Rows of a log in SI: time, whose record each is, and columns with NaN where nothing was measured."""

from collections import Counter
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.errors import InputError
from narrows.logbook.reading.log_columns import ABSENT, QUANTITIES, VOCABULARY, renamed
from narrows.logbook.reading.log_mapping import LogMapping
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
