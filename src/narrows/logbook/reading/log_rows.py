"""Rows of a log to signals: columns with names, units and signs; from the map to the waterway."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from narrows.base.errors import InputError, did_you_mean
from narrows.logbook.settings import HEADING_GAP
from narrows.logbook.ship_log import SIGNALS, TURNING, ShipRecord, Signal
from narrows.quantities.names import Quantity
from narrows.readers.cells import Vocabulary, split_header
from narrows.readers.mapping import ColumnMapping
from narrows.ship.checks import check_number
from narrows.ship.ship_file import check_table, load_toml
from narrows.waterway import Waterway
from narrows.waterway.map_lines import projected


class LogMapping(NamedTuple):
    columns: ColumnMapping = ColumnMapping()  # Names, units and signs
    late: Mapping[str, float] = {}  # Lateness by column [s]
    antenna: tuple[float, float] = (0.0, 0.0)  # Place of the antenna: forward and to starboard of midship [m]
    condition: Mapping[str, float] = {}  # Loading, as in ``{"draft": 10.2}``


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
    "test": "record", "run": "record", "timestamp": "time", "datetime": "time", "utc": "time", "basedatetime": "time",
    "base_date_time": "time", "lat": "latitude", "lon": "longitude", "lng": "longitude", "hdg": "heading",
    "hdt": "heading", "sog": "speed_over_ground", "cog": "course_over_ground", "rot": "r", "rate_of_turn": "r",
    "stw": "u", "rudder_angle": "rudder",
    **{name: name for name in (*QUANTITIES, *LABELS) if len(name) > 1},
}  # fmt: skip
# Columns of AIS archives and their units by ITU-R M.1371, which the headers do not state: those of the Danish Maritime
# Authority (Timestamp, MMSI, Latitude, ...) and of NOAA's MarineCadastre (MMSI, BaseDateTime, LAT, ...).
ARCHIVE_UNITS = {"speed_over_ground": "kn", "course_over_ground": "deg", "heading": "deg"}
SHIP = "mmsi"
UNDOCUMENTED = "r"  # The archives do not document the form of their rate of turn


def one_ship(
    frame: pd.DataFrame, mmsi: int | None, table: str, mapped: ColumnMapping
) -> tuple[pd.DataFrame, int | None, ColumnMapping] | None:
    """Return the rows of one ship of an AIS archive, its number, and the mapping, with the units of AIS.

    None where the table has not the headers of an archive: ships by number, and their time without a unit.
    """
    plain = {str(header): _plain(str(header)) for header in frame.columns}
    number = next((header for header, name in plain.items() if name == SHIP), None)
    if number is None or not any(ALIASES.get(name) == "time" for name in plain.values()):
        return None
    ships = pd.to_numeric(frame[number], errors="coerce")
    if mmsi is None and ships.nunique() > 1:
        raise InputError(f"{table}: holds several ships; name one by its number, as mmsi={int(ships.iloc[0])}")
    mmsi = int(ships.iloc[0]) if mmsi is None and ships.notna().any() else mmsi
    kept = {header: ARCHIVE_UNITS.get(ALIASES.get(name, "")) for header, name in plain.items()
            if ALIASES.get(name) != UNDOCUMENTED}  # fmt: skip
    units = {header: f"{header} [{unit}]" for header, unit in kept.items() if unit}
    of_mapped = {name: unit for name, unit in ARCHIVE_UNITS.items() if name in mapped.columns}
    known = replace(mapped, units={**of_mapped, **mapped.units})
    return frame.loc[ships == mmsi, list(kept)].rename(columns=units), mmsi, known


def renamed(frame: pd.DataFrame, mapped: Iterable[str] = ()) -> pd.DataFrame:
    """Return a table with the documented names, but for headers that a mapping reads."""
    headers, kept = [str(header) for header in frame.columns], set(mapped)
    new = {old: name for old in headers if not kept & {old, split_header(old)[0]} and (name := _documented(old))}
    return frame.rename(columns={old: name for old, name in new.items() if name not in headers})


def _documented(header: str) -> str | None:
    words = header if _plain(header) in ALIASES else split_header(header)[0]
    name = ALIASES.get(_plain(words))
    return None if name is None else name + header.strip()[len(words.strip()) :]


def _plain(header: str) -> str:
    return re.sub(r"\s+", "_", header.strip().removeprefix("#").strip()).lower()


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
        check_table(section, table, name)
        for key, value in table.items() if section in OF_NUMBERS else ():
            if (keys := OF_NUMBERS[section]) and key not in keys:
                raise InputError(f"{name}: [{section}] has no {key!r}{did_you_mean(str(key), keys)}")
            check_number(f"{name}: [{section}] {key}", value)
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
class RawRecord:
    name: str
    t: np.ndarray  # (rows,) Time, as it came [s]
    columns: Mapping[str, np.ndarray]  # (rows,) In SI; NaN where nothing was measured
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
        if not set(names) <= self.columns.keys():
            return None
        columns = [self.columns[name] for name in names]
        known = np.isfinite(columns).all(axis=0)
        if not known.any():
            return None
        t = self.t[known] - self.mapping.late.get(names[0], 0.0)
        columns = [column[known] for column in columns]
        columns = [np.unwrap(own) if name in JUMPING else own for name, own in zip(names, columns, strict=True)]
        first = np.flatnonzero(np.diff(t, prepend=np.nan) != 0)
        counts = np.diff(first, append=len(t))
        return (t[first], *(np.add.reduceat(column, first) / counts for column in columns))

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
