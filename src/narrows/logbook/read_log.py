"""A ship's own log into records in SI and the package's axes: tables, text, Parquet, NMEA 0183."""

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from narrows.aliases import accept_aliases
from narrows.errors import InputError, check_count, did_you_mean, shown
from narrows.logbook.settings import HEADING_GAP, PIECE_ROWS, RECORD_GAP
from narrows.logbook.ship_log import SIGNALS, TURNING, ShipLog, ShipRecord, Signal
from narrows.quantities.names import KNOT, Quantity
from narrows.readers.cells import as_sheet, check_once, labels, name_of, numbers, row_number
from narrows.readers.frames import Sheet, read_frame
from narrows.readers.headers import DEGREE, SUFFIXES, Vocabulary, recognised_in
from narrows.readers.mapping import ColumnMapping
from narrows.readers.nmea.nmea_recording import NmeaTable, is_nmea
from narrows.ship.checks import is_finite
from narrows.ship.ship_file import load_toml
from narrows.waterway import Waterway, read_waterway
from narrows.waterway.map_lines import projected

# Signals on the map, converted to the axes of the waterway or of the record.
ON_EARTH = {
    "longitude": Quantity("deg", "longitude of the antenna, WGS84"),
    "latitude": Quantity("deg", "latitude of the antenna, WGS84"),
    "east": Quantity("m", "antenna east of the origin of the map"),
    "north": Quantity("m", "antenna north of the origin of the map"),
    "heading": Quantity("rad", "heading, clockwise from true north"),
    "course_over_ground": Quantity("rad", "course over ground, clockwise from true north"),
    "east_rate": Quantity("m/s", "velocity over ground to the east"),
    "north_rate": Quantity("m/s", "velocity over ground to the north"),
    "wind_from": Quantity("rad", "where the wind comes from, clockwise from true north"),
}

IN_FIXED_AXES = {
    "x_rate": Quantity("m/s", "velocity over ground along the axis of x"),
    "y_rate": Quantity("m/s", "velocity over ground along the axis of y"),
}

QUANTITIES = {"t": Quantity("s", "time"), **SIGNALS, **ON_EARTH, **IN_FIXED_AXES}
# Columns of words: the manoeuvre or transit; date and time where there is no ``t``.
LABELS = ("record", "time")
VOCABULARY = Vocabulary(QUANTITIES, LABELS, blanks=True)
# Usual names of columns in logs, in any case of letters, a blank for an underscore; units stand in the header as ever.
ALIASES = {
    "test": "record", "run": "record", "timestamp": "time", "datetime": "time", "utc": "time", "lat": "latitude",
    "lon": "longitude", "lng": "longitude", "hdg": "heading", "hdt": "heading", "sog": "speed_over_ground",
    "cog": "course_over_ground", "rot": "r", "rate_of_turn": "r", "stw": "u", "rudder_angle": "rudder",
    **{name: name for name in (*QUANTITIES, *LABELS) if len(name) > 1},
}  # fmt: skip
HEADER = re.compile(r"([A-Za-z][A-Za-z_ ]*?)\s*(\s*[\[(].*[\])]|_(?:" + "|".join(SUFFIXES) + "))?")
# Codes of AIS for missing values (ITU-R M.1371), as sent and in SI.
ABSENT = {
    "longitude": (181.0,), "latitude": (91.0,), "heading": (511.0, 511.0 * DEGREE),
    "course_over_ground": (360.0, 360.0 * DEGREE), "speed_over_ground": (102.3, 102.3 * KNOT),
    "r": (-128.0, -128.0 * DEGREE / 60),
}  # fmt: skip
EARTH = {"latitude": 90.0, "longitude": 360.0}  # Degrees that a place on earth has at most


@accept_aliases
def read_log(
    log: Any, waterway: Waterway | str | Path | None = None,
    mapping: str | Path | Mapping[str, Any] | None = None, units: Mapping[str, str] | None = None, *,
    gap: float = RECORD_GAP, mmsi: int | None = None,
) -> ShipLog:  # fmt: skip
    """Read a ship's own records, in SI and the package's axes.

    Columns are those of ``SIGNALS``, SI and radians unless a header carries a unit, and those of docs/ship-log.md:
    longitude and latitude, heading and course from north, velocities in fixed axes. Empty cells are times at which that
    was not measured.

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
        to read of a recording, by default what the ship reports of itself.

    Raises
    ------
    InputError
        In one sentence with file, row, column and remedy.
    """
    parts = log if isinstance(log, list | tuple) else [log]
    if not parts:
        raise InputError("there is no log to read; give one or more")
    if not gap > 0:
        raise InputError(f"gap = {gap} s is no time without a row; give one over 0")
    if mmsi is not None:
        check_count("mmsi", mmsi, 1, 999_999_999)
    water = read_waterway(waterway) if isinstance(waterway, str | Path) else waterway
    named, notes, records = log_mapping(mapping, units), dict[str, None](), dict[str, ShipRecord]()
    for part in parts:
        path = Path(part) if isinstance(part, str | os.PathLike) else None
        table = name_of(part) if path is None else str(path)
        sheet = _sheet(part if path is None else path, mmsi, table)
        rows, remarks = _rows(sheet.frame, named.columns, table)
        found = []
        for name, own in _split(rows, gap, "record" if path is None else path.stem, table):
            record = Placing(name, own.pop("t").to_numpy(), own, named, water, table).record()
            found += [record] * bool(record.signals)
        if not found:
            raise InputError(f"{table}: has no signal of a ship; give a log with at least one row and one signal")
        for record in found:
            name = f"{Path(table).stem} {record.name}" if record.name in records else record.name
            records[name] = replace(record, name=name)
        cut = f"cut into {len(found)} records where nothing came for {gap:g} s; gap= sets another time"
        moved = "positions are brought from the antenna to midship, where the heading is known"
        remarks += [cut] * (len(found) > 1 and "record" not in rows) + [moved] * any(named.antenna)
        notes |= dict.fromkeys([*sheet.notes, *remarks])
    return ShipLog(tuple(records.values()), water, tuple(notes))


def _sheet(part: Any, mmsi: int | None, table: str) -> Sheet:
    if isinstance(part, Path) and not part.is_file():
        raise InputError(f"{table}: there is no such file; check the path")
    if isinstance(part, Path) and is_nmea(part):
        recording = NmeaTable(part, mmsi)
        return Sheet(pd.concat(list(recording.frames(PIECE_ROWS))), recording.notes())
    if mmsi is not None:
        raise InputError(f"{table}: mmsi = {mmsi} needs AIS reports, and this table has none; leave it out")
    return read_frame(part) if isinstance(part, Path) else as_sheet(part)


def _rows(raw: pd.DataFrame, mapping: ColumnMapping, table: str) -> tuple[pd.DataFrame, list[str]]:
    """Return a table in SI with notes: t, record if it has one, and signals with NaN where nothing was measured."""
    frame, mapped = mapping.applied(_renamed(raw, mapping), table, VOCABULARY)
    recognised, notes = recognised_in(frame, QUANTITIES, table), list(mapped)
    check_once(recognised, [str(header) for header in frame.columns], QUANTITIES, table)
    columns = {
        column.quantity: numbers(frame, column.header, table, column.quantity != "t") * column.scale
        for column in recognised
    }
    if "t" not in columns:
        columns["t"], begin = _clock(frame, table)
        notes.append(f"t counts from {begin}")
    if len(columns) == 1:
        raise InputError(f"{table}: has times and nothing else; head its columns as in docs/ship-log.md")
    for name, column in columns.items():
        none = np.isin(column, ABSENT.get(name, ()))
        if (beyond := (np.abs(column) > EARTH.get(name, np.inf)) & ~none).any():
            row, value = row_number(frame, beyond), column[int(np.argmax(beyond))]
            raise InputError(f"{table}: row {row}, {name} {value:g} is not on earth; give it in degrees, WGS84")
        if none.any():
            notes.append(f"{int(none.sum())} of {name} stand for none and were left out")
            columns[name] = np.where(none, np.nan, column)
    named = {"record": labels(frame, "record", table)} if "record" in frame else {}
    return pd.DataFrame({**named, **columns}), notes


def _renamed(frame: pd.DataFrame, mapping: ColumnMapping) -> pd.DataFrame:
    """Return a table with the documented names, but for headers that a mapping reads."""
    headers, kept = [str(header) for header in frame.columns], set(mapping.columns.values())
    new = {}
    for header in headers:
        match = HEADER.fullmatch(header.strip())
        name = ALIASES.get(match[1].strip().replace(" ", "_").lower()) if match else None
        if match and name and not {header, match[1]} & kept and (name := name + (match[2] or "")) not in headers:
            new[header] = name
    return frame.rename(columns=new)


def _clock(frame: pd.DataFrame, table: str) -> tuple[np.ndarray, str]:
    """Return the seconds since the first time of a column of dates and times, and that time."""
    if "time" not in frame:
        raise InputError(f"{table}: no column has the time; head one 't [s]', or 'time' for dates and times")
    dated = frame["time"] if frame["time"].dtype.kind == "M" else frame["time"].astype(str)
    times = pd.to_datetime(dated, utc=True, errors="coerce", format="ISO8601")
    if times.isna().any():
        row = row_number(frame, times.isna().to_numpy())
        raise InputError(f"{table}: row {row}, column 'time' is no date and time; write 2026-05-01T10:00:00Z")
    return (times - times.min()).dt.total_seconds().to_numpy(float), times.min().isoformat() if len(times) else ""


def _split(rows: pd.DataFrame, gap: float, stem: str, table: str) -> list[tuple[str, pd.DataFrame]]:
    """Return the rows of each record with its name: by the column ``record``, or cut at gaps."""
    if "record" in rows:
        begins = rows["record"] != rows["record"].shift()
        if (twice := rows["record"][begins].duplicated()).any():
            record = rows["record"][begins][twice].iloc[0]
            raise InputError(f"{table}: the rows of record {record} do not stand together; sort it by record")
    else:
        begins = rows["t"].diff() > gap
    parts = [part for _, part in rows.groupby(np.cumsum(begins))]
    firsts = [str(part.iloc[0].get("record", stem)) or stem for part in parts]
    names = [f"{name} {place + 1}" if name in firsts[:place] else name for place, name in enumerate(firsts)]
    return [(name, part.drop(columns="record", errors="ignore")) for name, part in zip(names, parts, strict=True)]


class LogMapping(NamedTuple):
    columns: ColumnMapping = ColumnMapping()  # Names, units and signs
    late: Mapping[str, float] = {}  # Lateness by column [s]
    antenna: tuple[float, float] = (0.0, 0.0)  # Place of the antenna: forward and to starboard of midship [m]
    condition: Mapping[str, float] = {}  # Loading, as in ``{"draft": 10.2}``


OF_COLUMNS = ("columns", "units", "positive")
# Sections of numbers, and the keys of each; any key of a loading.
OF_NUMBERS: Mapping[str, Iterable[str]] = {"late": QUANTITIES, "antenna": ("forward", "starboard"), "condition": ()}


def log_mapping(mapping: str | Path | Mapping[str, Any] | None, units: Mapping[str, str] | None = None) -> LogMapping:
    """Read the mapping of a log; units given as an argument take precedence over those of the file."""
    tables = {} if mapping is None else mapping if isinstance(mapping, Mapping) else load_toml(mapping)
    name = Path(mapping).name if isinstance(mapping, str | Path) else "the mapping"
    for section, table in tables.items():
        if section not in (known := (*OF_COLUMNS, *OF_NUMBERS)):
            raise InputError(f"{name}: unknown section [{section}]{did_you_mean(str(section), known)}")
        if not isinstance(table, Mapping):
            raise InputError(f"{name}: {section} = {shown(table)} is no section; write [{section}] and keys below it")
        for key, value in table.items() if section in OF_NUMBERS else ():
            if (keys := OF_NUMBERS[section]) and key not in keys:
                raise InputError(f"{name}: [{section}] has no {key!r}{did_you_mean(str(key), keys)}")
            if not is_finite(value):
                raise InputError(f"{name}: [{section}] {key} = {shown(value)} is no number; give one")
    place, parts = tables.get("antenna", {}), {section: tables.get(section, {}) for section in OF_COLUMNS}
    columns = ColumnMapping(**{**parts, "units": {**parts["units"], **(units or {})}}, name=name)
    antenna = place.get("forward", 0.0), place.get("starboard", 0.0)
    return LogMapping(columns, tables.get("late", {}), antenna, tables.get("condition", {}))


# Directions from north, for those from the axes of the record.
BY_MAP = {"psi": "heading", "course": "course_over_ground", "wind_direction": "wind_from"}
JUMPING = (*TURNING, *BY_MAP.values())
Signals = dict[str, Signal]
# Times [s], and places east and north; in a plane without a waterway x is north [m].
Fixes = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class Placing:
    """The signals of a record in the package's axes."""

    name: str
    t: np.ndarray  # (rows,) Time, as it came [s]
    columns: pd.DataFrame  # In SI; NaN where nothing was measured
    mapping: LogMapping  # Lateness, antenna, loading
    waterway: Waterway | None  # Line of the positions; a plane where there is none
    table: str  # The file, for sentences
    signals: Signals = field(default_factory=dict)

    def record(self) -> ShipRecord:
        signals, antenna = self.signals, self.mapping.antenna
        signals |= {name: signal for name in SIGNALS if (signal := self._signal(name)) is not None}
        fixes = self._fixes()
        if fixes is not None:
            self._locate(fixes)
        self._turn()
        moved = fixes is not None and "psi" in signals
        if fixes is not None and moved and any(antenna):
            self._locate(self._at_midship(fixes))
            self._turn()
        self._add_velocities()
        ordered = {name: signals[name] for name in SIGNALS if name in signals}
        return ShipRecord(self.name, ordered, (0.0, 0.0) if moved else antenna, self.mapping.condition)

    def _together(self, *names: str) -> tuple[np.ndarray, ...] | None:
        """Return times and columns where all of some were measured at once; None where one never was."""
        # Directions are without jumps; values of one time, which is rounded then, are one by their mean.
        if not set(names) <= set(self.columns):
            return None
        columns = [self.columns[name].to_numpy() for name in names]
        known = np.isfinite(columns).all(axis=0)
        if not known.any():
            return None
        t = self.t[known] - self.mapping.late.get(names[0], 0.0)
        columns = [column[known] for column in columns]
        return _once(t, [np.unwrap(own) if name in JUMPING else own for name, own in zip(names, columns, strict=True)])

    def _signal(self, name: str) -> Signal | None:
        return _smoothly(name, Signal(*measured)) if (measured := self._together(name)) else None

    def _fixes(self) -> Fixes | None:
        """Positions by the map; those along the waterway too where they must be moved."""
        if measured := self._together("longitude", "latitude"):
            t, *degrees = measured
            origin = self.waterway.origin if self.waterway else tuple(column[0] for column in degrees)
            if origin is None:
                raise InputError(
                    f"{self.table}: longitude and latitude have no place on this waterway, which has no position on "
                    "earth; give its origin, or read it from GeoJSON"
                )
            return t, projected(np.stack(degrees, axis=1), np.array(origin))
        if measured := self._together("east", "north"):
            return measured[0], np.stack(measured[1:], axis=1)
        if any(self.mapping.antenna) and (measured := self._together("x", "y")):
            t, x, y = measured
            return t, self.waterway.to_map(x, y)[0] if self.waterway else np.stack([y, x], axis=1)
        return None

    def _locate(self, fixes: Fixes) -> None:
        t, places = fixes
        x, y = places.T[::-1] if self.waterway is None else self.waterway.line.locate(places)
        self.signals.update(x=Signal(t, x), y=Signal(t, y))

    def _axis(self, t: np.ndarray) -> np.ndarray:
        """Direction of the axis that headings are measured from [rad] from north: of the waterway's line, or north."""
        if self.waterway is None:
            return np.zeros(len(t))
        if "x" not in self.signals:
            raise InputError(
                f"{self.table}: a direction from north is measured from a bend of {self.waterway.name} only where the "
                "position is known; give longitude and latitude, or x"
            )
        return self.waterway.line.heading(np.interp(t, self.signals["x"].t, self.signals["x"].values))

    def _turn(self) -> None:
        """Directions from the axis, of those from north."""
        for name, by_map in BY_MAP.items():
            if name not in self.columns and (signal := self._signal(by_map)):
                self.signals[name] = _smoothly(name, Signal(signal.t, signal.values - self._axis(signal.t)))

    def _at_midship(self, fixes: Fixes) -> Fixes:
        (t, positions), (forward, starboard) = fixes, self.mapping.antenna
        heading = self.signals["psi"].at(t, HEADING_GAP) + self._axis(t)
        known = np.isfinite(heading)
        east, north = np.sin(heading), np.cos(heading)
        off = np.stack([forward * east + starboard * north, forward * north - starboard * east], axis=1)
        return t[known], (positions - off)[known]

    def _add_velocities(self) -> None:
        """Velocities along and across the ship by those in fixed axes; of midship where the yaw rate is known."""
        by_axes, by_map = self._together("x_rate", "y_rate"), self._together("north_rate", "east_rate")
        measured = by_axes or by_map
        if measured is None or "u_ground" in self.signals:
            return
        if "psi" not in self.signals:
            raise InputError(f"{self.table}: velocities in fixed axes need the heading; give psi, or heading")
        t, north, east = measured
        angle = self.signals["psi"].at(t, HEADING_GAP) + (0.0 if by_axes else self._axis(t))
        forward, starboard = self.mapping.antenna
        moved = "r" in self.signals and any(self.mapping.antenna)
        turn = self.signals["r"].at(t, HEADING_GAP) if moved else np.zeros(len(t))
        u = north * np.cos(angle) + east * np.sin(angle) + starboard * turn
        v = east * np.cos(angle) - north * np.sin(angle) - forward * turn
        known = np.isfinite(u)
        self.signals.update(u_ground=Signal(t[known], u[known]), v_ground=Signal(t[known], v[known]))


def _smoothly(name: str, signal: Signal) -> Signal:
    """A direction without jumps, from less than half a turn off the axis on; any other signal as it is."""
    if name not in TURNING or not len(signal):
        return signal
    values = np.unwrap(signal.values)
    return Signal(signal.t, values - 2 * np.pi * np.round(values[0] / (2 * np.pi)))


def _once(t: np.ndarray, columns: list[np.ndarray]) -> tuple[np.ndarray, ...]:
    first = np.flatnonzero(np.diff(t, prepend=np.nan) != 0)
    if len(first) == len(t):
        return (t, *columns)
    counts = np.diff(first, append=len(t))
    return (t[first], *(np.add.reduceat(column, first) / counts for column in columns))
