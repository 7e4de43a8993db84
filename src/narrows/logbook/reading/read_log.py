"""A ship's own log into records: tables, text, Parquet, NMEA 0183; whole, or record by record."""

import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_count
from narrows.logbook.reading.log_rows import VOCABULARY, LogMapping, RawRecord, log_mapping, one_ship, renamed
from narrows.logbook.settings import MOST_ROWS, PIECE_ROWS, RECORD_GAP
from narrows.logbook.ship_log import ShipLog, ShipRecord
from narrows.quantities.names import DEGREE, KNOT
from narrows.readers.cells import (
    as_sheet,
    check_once,
    labels,
    name_of,
    numbers,
    recognised_in,
    row_number,
    with_seconds,
)
from narrows.readers.frames import STREAMED, notes_of, read_chunks, read_frame
from narrows.readers.nmea import Recording, is_nmea
from narrows.waterway import Waterway, read_waterway


@accept_aliases
def read_log(
    log: Any, waterway: Waterway | str | Path | None = None,
    mapping: str | Path | Mapping[str, Any] | None = None, units: Mapping[str, str] | None = None, *,
    gap: float = RECORD_GAP, mmsi: int | None = None,
) -> ShipLog:  # fmt: skip
    """Read a ship's own records into memory, in SI and the package's axes.

    Columns are those of ``SIGNALS``, SI and radians unless a header carries a unit, and those of docs/ship-log.md:
    longitude and latitude, heading and course from north, velocities in fixed axes. Empty cells are times at which that
    was not measured. Tables of the Danish and of NOAA's AIS archive are read as they are, speeds in knots and
    directions in degrees by the standard of AIS.

    Raises an InputError in one sentence with file, row, column and remedy.

    Parameters
    ----------
    log : str, Path, DataFrame, Dataset, or a sequence of them
        CSV and text in any dialect, Parquet, Excel, a recording of NMEA 0183, or a table.
    waterway : Waterway, str or Path, optional
        Line of the positions; a plane where there is none.
    mapping : str, Path or mapping, optional
        The ship's own names, units and signs, what is late [s], where the antenna stands [m] and the loading: a TOML
        file with ``[columns]``, ``[units]``, ``[positive]``, ``[late]``, ``[antenna]`` and ``[condition]``, or these
        as in ``{"antenna": {"forward": -70.0}, "condition": {"draft": 10.2}}``.
    units : mapping of str to str, optional
        Units of columns without one in the header.
    gap, mmsi : float [s], int, optional
        A time without a row after which another record begins, where no column ``record`` names them; whose AIS reports
        to read of a recording or an archive, by default what the ship reports of itself.
    """
    parts = log if isinstance(log, list | tuple) else [log]
    if not parts:
        raise InputError("there is no log to read; give one or more")
    records: list[ShipRecord] = []
    notes: list[str] = []
    for part in parts:
        streamed = stream_log(part, waterway, mapping, units, gap=gap, mmsi=mmsi)
        reading = LogReading(streamed)
        taken = {record.name for record in records}
        records += [
            replace(record, name=f"{Path(streamed.name).stem} {record.name}") if record.name in taken else record
            for record in reading.records()
        ]
        notes += [note for note in reading.notes() if note not in notes]
    return ShipLog(tuple(records), streamed.waterway, tuple(notes))


@dataclass(frozen=True, eq=False)
class StreamedLog:
    """The records of a ship, read from disk each time they are asked for."""

    table: Any  # CSV, text, Parquet, or a recording of NMEA 0183; a DataFrame too
    mapping: LogMapping  # Names of columns, delays, place of the antenna
    waterway: Waterway | None  # Line of the positions; a plane where there is none
    gap: float  # Time without a row after which another record begins [s]
    mmsi: int | None = None  # Whose AIS reports to read
    notes: ClassVar[tuple[str, ...]] = ("records are read from disk one by one",)

    def __iter__(self) -> Iterator[ShipRecord]:
        return LogReading(self).records()

    @property
    def name(self) -> str:
        return str(self.table) if isinstance(self.table, Path) else name_of(self.table)


@accept_aliases
def stream_log(
    log: Any, waterway: Waterway | str | Path | None = None,
    mapping: str | Path | Mapping[str, Any] | None = None, units: Mapping[str, str] | None = None, *,
    gap: float = RECORD_GAP, mmsi: int | None = None,
) -> StreamedLog:  # fmt: skip
    """Open a log whose records are read one by one each time they are asked for; fits take it as a ``ShipLog``.

    Raises an InputError where the file is absent, or an option is none; rows are checked as they pass.

    Parameters
    ----------
    log, waterway, mapping, units, gap, mmsi : Any
        As for ``read_log``: a table or one file of CSV, text, Parquet or NMEA 0183, and ``gap`` in [s].
    """
    if not gap > 0:
        raise InputError(f"gap = {gap} s is no time without a row; give one over 0")
    if mmsi is not None:
        check_count("mmsi", mmsi, 1, 999_999_999)
    table = Path(log) if isinstance(log, str | os.PathLike) else log
    if isinstance(table, Path) and not table.is_file():
        raise InputError(f"{table}: there is no such file; check the path")
    water = read_waterway(waterway) if isinstance(waterway, str | Path) else waterway
    return StreamedLog(table, log_mapping(mapping, units), water, gap, mmsi)


EARTH = {"latitude": 90.0, "longitude": 360.0}  # Degrees that a place on earth has at most
# Codes of AIS for missing values (ITU-R M.1371), as sent and in SI.
ABSENT = {
    "longitude": (181.0,), "latitude": (91.0,), "heading": (511.0, 511.0 * DEGREE),
    "course_over_ground": (360.0, 360.0 * DEGREE), "speed_over_ground": (102.3, 102.3 * KNOT),
    "r": (-128.0, -128.0 * DEGREE / 60),
}  # fmt: skip
DAY_FIRST = re.compile(r"\d\d/\d\d/\d{4} ")  # A date as the Danish archive writes it, 31/12/2015 23:59:59


class LogReading:
    def __init__(self, log: StreamedLog) -> None:
        self.log, self.table = log, log.name
        is_recording = isinstance(log.table, Path) and is_nmea(log.table)
        self.mmsi = None if is_recording else log.mmsi
        self.names: list[str] = []
        self.about: tuple[str, ...] = ()
        self.mapped: tuple[str, ...] = ()
        self.begin: pd.Timestamp | None = None
        self.absent: Counter[str] = Counter()
        self.given = self.cuts = 0

    def records(self) -> Iterator[ShipRecord]:
        for raw in self._split(map(self._rows, self._frames())):
            record = raw.record()
            self.given += bool(record.signals)
            if record.signals:
                yield record
        if not self.given:
            raise InputError(f"{self.table}: has no signal of a ship; give a log with at least one row and one signal")

    def notes(self) -> tuple[str, ...]:
        antenna = any(self.log.mapping.antenna)
        cut = f"cut into {self.given} records where nothing came for {self.log.gap:g} s; gap= sets another time"
        remarks = {
            f"t counts from {self.begin.isoformat() if self.begin else ''}": self.begin is not None,
            **{f"{count} of {name} stand for none and were left out": True for name, count in self.absent.items()},
            cut: self.cuts,
            "positions are brought from the antenna to midship, where the heading is known": antenna,
        }
        return (*self.about, *self.mapped, *(note for note, holds in remarks.items() if holds))

    def _frames(self) -> Iterator[pd.DataFrame]:
        table = self.log.table
        if not isinstance(table, Path):
            yield as_sheet(table).frame
        elif is_nmea(table):
            recording = Recording(table, self.log.mmsi)
            yield from recording.frames(PIECE_ROWS)
            self.about = recording.notes()
        elif table.suffix.lower() in STREAMED:
            self.about = notes_of(table)
            yield from read_chunks(table, PIECE_ROWS)
        else:
            sheet = read_frame(table)
            self.about = sheet.notes
            yield sheet.frame

    def _rows(self, raw: pd.DataFrame) -> pd.DataFrame:
        """A table in SI: t, record if it has one, and signals with NaN where nothing was measured."""
        mapped = self.log.mapping.columns
        if archive := one_ship(raw, self.mmsi, self.table, mapped):
            raw, self.mmsi, mapped = archive
        elif self.mmsi is not None:
            raise InputError(f"{self.table}: mmsi={self.mmsi} needs AIS reports, and this table has none; leave it out")
        frame, self.mapped = mapped.applied(renamed(raw, mapped.columns.values()), self.table, VOCABULARY)
        frame = with_seconds(frame)
        recognised = recognised_in(frame, VOCABULARY.quantities, self.table)
        check_once(recognised, list(map(str, frame.columns)), VOCABULARY.quantities, self.table)
        columns = {
            column.quantity: numbers(frame, column.header, self.table, column.quantity != "t") * column.scale
            for column in recognised
        }
        t = columns.pop("t") if "t" in columns else self._clock(frame)
        if not columns:
            raise InputError(f"{self.table}: has times and nothing else; head its columns as in docs/ship-log.md")
        for name, column in columns.items():
            none = np.isin(column, ABSENT.get(name, ()))
            if (beyond := (np.abs(column) > EARTH.get(name, np.inf)) & ~none).any():
                row, value = row_number(frame, beyond), column[int(np.argmax(beyond))]
                raise InputError(f"{self.table}: row {row}, {name} {value:g} is not on earth; give degrees, WGS84")
            if none.any():
                self.absent[name] += int(none.sum())
                columns[name] = np.where(none, np.nan, column)
        named = {"record": labels(frame, "record", self.table)} if "record" in frame else {}
        rows = pd.DataFrame({"t": t, **named, **columns})
        # Receivers pass on reports in any order.
        return rows.sort_values("t", kind="stable", ignore_index=True) if archive else rows

    def _clock(self, frame: pd.DataFrame) -> np.ndarray:  # [s]
        if "time" not in frame:
            raise InputError(f"{self.table}: no column has the time; head one 't [s]', or 'time' for dates and times")
        if not len(frame):
            return np.empty(0)
        dated = frame["time"] if frame["time"].dtype.kind == "M" else frame["time"].astype(str)
        by_day = dated.dtype.kind != "M" and bool(DAY_FIRST.match(dated.iloc[0]))
        times = pd.to_datetime(dated, utc=True, errors="coerce", format="%d/%m/%Y %H:%M:%S" if by_day else "ISO8601")
        if times.isna().any():
            row = row_number(frame, times.isna().to_numpy())
            raise InputError(f"{self.table}: row {row}, column 'time' is no date and time; write 2026-05-01T10:00:00Z")
        begin = self.begin = self.begin or times.min()
        return (times - begin).dt.total_seconds().to_numpy(float)

    def _split(self, pieces: Iterable[pd.DataFrame]) -> Iterator[RawRecord]:
        label, last, held = "", np.nan, list[pd.DataFrame]()
        for piece in pieces:
            for number, part in piece.groupby(np.cumsum(self._begins(piece, label, last))):
                label, last = str(part["record"].iloc[0]) if "record" in part else "", float(part["t"].iloc[-1])
                if number and label in self.names:
                    raise InputError(f"{self.table}: rows of record {label} do not stand together; sort it by record")
                if held and (number or sum(map(len, held)) + len(part) > MOST_ROWS):
                    yield self._finished(held)
                    held = []
                held.append(part)
        if held:
            yield self._finished(held)

    def _begins(self, piece: pd.DataFrame, label: str, last: float) -> np.ndarray:  # (rows,)
        if "record" in piece:
            names = piece["record"].to_numpy()
            return np.asarray(np.append(np.array([label], object), names[:-1])[: len(names)] != names)
        other = np.diff(piece["t"], prepend=last) > self.log.gap
        self.cuts += int(other.sum())
        return other

    def _finished(self, held: list[pd.DataFrame]) -> RawRecord:
        stem = str(held[0]["record"].iloc[0]) if "record" in held[0] else ""
        stem = stem or (self.log.table.stem if isinstance(self.log.table, Path) else "record")
        self.names.append(f"{stem} {len(self.names) + 1}" if stem in self.names else stem)
        rows = pd.concat(held).drop(columns="record", errors="ignore")
        t, columns = rows.pop("t").to_numpy(), {str(name): column.to_numpy() for name, column in rows.items()}
        return RawRecord(self.names[-1], t, columns, self.log.mapping, self.log.waterway, self.table)
