"""Raw records to signals: from the map to the waterway, from fixed axes to the ship's, from the antenna to midship."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from narrows.errors import InputError
from narrows.logbook.reading.log_rows import LogMapping, RawRecord
from narrows.logbook.settings import HEADING_GAP
from narrows.logbook.ship_record import SIGNALS, TURNING, ShipRecord, Signal
from narrows.waterway import Waterway
from narrows.waterway.map_lines import projected

# Directions from north, for those from the axes of the record.
BY_MAP = {"psi": "heading", "course": "course_over_ground", "wind_direction": "wind_from"}
JUMPING = (*TURNING, *BY_MAP.values())
Signals = dict[str, Signal]
# Times [s], and places east and north; in a plane without a waterway x is north [m].
Fixes = tuple[np.ndarray, np.ndarray]


class RawSignals(NamedTuple):
    raw: RawRecord  # The record
    late: dict[str, float]  # By how much columns are late [s]

    def together(self, *names: str) -> tuple[np.ndarray, ...] | None:
        """Return times and columns where all of some were measured at once; None where one never was."""
        # Directions are without jumps; values of one time, which is rounded then, are one by their mean.
        if not set(names) <= self.raw.columns.keys():
            return None
        columns = [self.raw.columns[name] for name in names]
        known = np.isfinite(columns).all(axis=0)
        if not known.any():
            return None
        t = self.raw.t[known] - self.late.get(names[0], 0.0)
        columns_known = {name: column[known] for name, column in zip(names, columns, strict=True)}
        return _once(t, [np.unwrap(column) if name in JUMPING else column for name, column in columns_known.items()])

    def signal(self, name: str) -> Signal | None:
        return _smoothly(name, Signal(*measured)) if (measured := self.together(name)) else None


@dataclass(frozen=True, eq=False)
class Placing:
    table: str  # The file, for sentences
    mapping: LogMapping = field(default_factory=LogMapping)  # Lateness, antenna, loading
    waterway: Waterway | None = None  # Line of the positions; a plane where there is none

    def record(self, raw: RawRecord) -> ShipRecord:
        columns, antenna = RawSignals(raw, dict(self.mapping.late)), self.mapping.antenna
        signals = {name: signal for name in SIGNALS if (signal := columns.signal(name)) is not None}
        fixes = self._fixes(columns, any(antenna))
        if fixes is not None:
            signals |= self._along(fixes)
        signals |= self._directions(columns, signals)
        if any(antenna) and fixes is not None and "psi" in signals:
            signals |= self._along(self._at_midship(fixes, signals, antenna))
            signals |= self._directions(columns, signals)
        signals |= self._over_ground(columns, signals)
        brought = fixes is not None and "psi" in signals
        return ShipRecord(
            raw.name, {name: signals[name] for name in SIGNALS if name in signals}, (0.0, 0.0) if brought else antenna,
            self.mapping.condition,
        )  # fmt: skip

    def _fixes(self, columns: RawSignals, moved: bool) -> Fixes | None:
        """Positions by the map; those along the waterway too where they must be moved."""
        if measured := columns.together("longitude", "latitude"):
            t, *degrees = measured
            return t, projected(np.stack(degrees, axis=1), self._origin(degrees))
        if measured := columns.together("east", "north"):
            return measured[0], np.stack(measured[1:], axis=1)
        if moved and (measured := columns.together("x", "y")):
            t, x, y = measured
            return t, self.waterway.to_map(x, y)[0] if self.waterway else np.stack([y, x], axis=1)
        return None

    def _origin(self, degrees: list[np.ndarray]) -> np.ndarray:
        if self.waterway is None:
            return np.array([degrees[0][0], degrees[1][0]])
        if self.waterway.origin is None:
            raise InputError(
                f"{self.table}: longitude and latitude have no place on {self.waterway.name}, which has no "
                "position on earth; give its origin, or read it from GeoJSON"
            )
        return np.array(self.waterway.origin)

    def _along(self, fixes: Fixes) -> Signals:
        if self.waterway is None:
            y, x = fixes[1].T
        else:
            x, y = self.waterway.line.locate(fixes[1])
        return {"x": Signal(fixes[0], x), "y": Signal(fixes[0], y)}

    def _axis(self, t: np.ndarray, signals: Signals) -> np.ndarray:
        """Direction of the axis that headings are measured from [rad] from north: of the waterway's line, or north."""
        if self.waterway is None:
            return np.zeros(len(t))
        if "x" not in signals:
            raise InputError(
                f"{self.table}: a direction from north is measured from a bend of {self.waterway.name} only where the "
                "position is known; give longitude and latitude, or x"
            )
        return self.waterway.line.heading(np.interp(t, signals["x"].t, signals["x"].values))

    def _directions(self, columns: RawSignals, signals: Signals) -> Signals:
        found = {}
        for name, by_map in BY_MAP.items():
            if name not in columns.raw.columns and (signal := columns.signal(by_map)):
                from_axis = signal.values - self._axis(signal.t, signals)
                found[name] = _smoothly(name, Signal(signal.t, from_axis))
        return found

    def _at_midship(self, fixes: Fixes, signals: Signals, antenna: tuple[float, float]) -> Fixes:
        t, positions = fixes
        heading = signals["psi"].at(t, HEADING_GAP) + self._axis(t, signals)
        known = np.isfinite(heading)
        ahead = np.stack([np.sin(heading), np.cos(heading)], axis=1)
        starboard = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
        moved = positions - antenna[0] * ahead - antenna[1] * starboard
        return t[known], moved[known]

    def _over_ground(self, columns: RawSignals, signals: Signals) -> Signals:
        """Velocities in fixed axes, along and across the ship; of midship where the yaw rate is known."""
        by_axes, by_map = columns.together("x_rate", "y_rate"), columns.together("north_rate", "east_rate")
        measured = by_axes or by_map
        if measured is None or "u_ground" in signals:
            return {}
        if "psi" not in signals:
            raise InputError(f"{self.table}: velocities in fixed axes need the heading; give psi, or heading")
        t, north, east = measured
        angle = signals["psi"].at(t, HEADING_GAP) + (0.0 if by_axes else self._axis(t, signals))
        forward, starboard = self.mapping.antenna
        turn = signals["r"].at(t, HEADING_GAP) if "r" in signals and (forward or starboard) else np.zeros(len(t))
        u = north * np.cos(angle) + east * np.sin(angle) + starboard * turn
        v = east * np.cos(angle) - north * np.sin(angle) - forward * turn
        known = np.isfinite(u)
        return {"u_ground": Signal(t[known], u[known]), "v_ground": Signal(t[known], v[known])}


def _smoothly(name: str, signal: Signal) -> Signal:
    """A direction without jumps, from less than half a turn off the axis on; any other signal as it is."""
    if name not in TURNING or not len(signal):
        return signal
    values = np.unwrap(signal.values)
    return Signal(signal.t, values - 2 * np.pi * np.round(values[0] / (2 * np.pi)))


def _once(t: np.ndarray, columns: list[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Times, each once where it stands several times in a row, and the means of what was measured then."""
    first = np.flatnonzero(np.diff(t, prepend=np.nan) != 0)
    if len(first) == len(t):
        return (t, *columns)
    counts = np.diff(first, append=len(t))
    return (t[first], *(np.add.reduceat(column, first) / counts for column in columns))
