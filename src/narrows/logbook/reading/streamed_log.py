"""Logs that stay on disk: record by record, read when asked for, so that memory does not grow with them."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from narrows.errors import InputError
from narrows.logbook.reading.log_mapping import LogMapping
from narrows.logbook.reading.log_rows import RowReader
from narrows.logbook.reading.placing import Placing
from narrows.logbook.reading.record_split import RawRecord, RecordSplit
from narrows.logbook.ship_record import ShipRecord
from narrows.readers.dataframes import as_sheet, name_of
from narrows.readers.frames import STREAMED, notes_of, read_chunks, read_frame
from narrows.readers.nmea.nmea_recording import is_nmea
from narrows.readers.nmea.nmea_table import NmeaTable
from narrows.waterway import Waterway

# Of a piece that is held at once.
ROWS = 32_000


@dataclass(frozen=True, eq=False)
class StreamedLog:
    """The records of a ship, read from disk each time they are asked for.

    Parameters
    ----------
    table : Path or table
        CSV, text, Parquet, or a recording of NMEA 0183; a DataFrame too.
    mapping : LogMapping
        What is called how, what is late, where the antenna stands.
    waterway : Waterway, optional
        Along which to tell where the ship is; a plane where there is none.
    gap : float [s]
        A time without a row after which another record begins, where the log does not name its records.
    mmsi : int, optional
        Whose AIS reports to read; what the ship reports of itself unless given.
    """

    table: Any
    mapping: LogMapping
    waterway: Waterway | None
    gap: float
    mmsi: int | None = None

    def __iter__(self) -> Iterator[ShipRecord]:
        """The records, one at a time."""
        return LogReading(self).records()

    @property
    def name(self) -> str:
        """Of the file, for sentences."""
        return str(self.table) if isinstance(self.table, Path) else name_of(self.table)

    @property
    def notes(self) -> tuple[str, ...]:
        """That it is not held in memory."""
        return ("records are read from disk one by one",)


class LogReading:
    """One pass over a log, and what there is to say of it afterwards."""

    def __init__(self, log: StreamedLog) -> None:
        self.log = log
        self.rows = RowReader(log.name, log.mapping)
        stem = log.table.stem if isinstance(log.table, Path) else "record"
        self.split = RecordSplit(log.name, stem, log.gap)
        self.about: tuple[str, ...] = ()
        self.rounded = self.given = 0

    def records(self) -> Iterator[ShipRecord]:
        """Yield the records."""
        placing = Placing(self.log.name, self.log.mapping, self.log.waterway)
        for raw in self.split.records(map(self.rows.rows, self._frames())):
            self.rounded += _repeated(raw)
            record = placing.record(raw)
            self.given += bool(record.signals)
            if record.signals:
                yield record
        if not self.given:
            raise InputError(
                f"{self.log.name}: tells nothing of a ship; give a log with at least one row and one signal"
            )

    def notes(self) -> tuple[str, ...]:
        """What there is to say of what was read."""
        told = {
            f"cut into {self.given} records where nothing came for {self.log.gap:g} s": self.split.cuts > 0,
            "rows whose time repeats that of the row above, as it is rounded, are one by their means": self.rounded > 0,
            "positions are brought from the antenna to midship, where the heading is known": any(
                self.log.mapping.antenna
            ),
        }
        return (*self.about, *self.rows.told(), *(note for note, holds in told.items() if holds))

    def _frames(self) -> Iterator[pd.DataFrame]:
        table = self.log.table
        if not isinstance(table, Path):
            yield as_sheet(table).frame
        elif is_nmea(table):
            recording = NmeaTable(table, self.log.mmsi)
            yield from recording.frames(ROWS)
            self.about = recording.notes()
        elif table.suffix.lower() in STREAMED:
            self.about = notes_of(table)
            yield from read_chunks(table, ROWS)
        else:
            sheet = read_frame(table)
            self.about = sheet.notes
            yield sheet.frame


def _repeated(raw: RawRecord) -> int:
    """Rows that tell at the time of the row above what that told."""
    same = np.diff(raw.t) == 0
    again = [np.isfinite(column[1:]) & np.isfinite(column[:-1]) for column in raw.columns.values()]
    return int((same & np.any(again, axis=0)).sum())


def as_path(table: Any) -> Any:
    """Return a name of a file as a path, and a table as it is."""
    return Path(table) if isinstance(table, str | os.PathLike) else table
