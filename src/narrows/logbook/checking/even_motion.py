"""A record at even times, each signal as the mean of what was measured about them, on the map and over windows."""

from dataclasses import dataclass

import numpy as np

from narrows.logbook.ship_record import ShipRecord
from narrows.logbook.signals import Signal
from narrows.waterway import Waterway

# Even times for the way of a ship length.
A_LENGTH = 40
# Even times of a record.
FEWEST, MOST = 16, 20_000
# Of a record, over which its usual speed is measured.
PIECES = 50
# Steps of a signal or of even time, over which values are still joined.
JOINED = 3.0

Windows = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class EvenMotion:
    """A record at even times."""

    t: np.ndarray  # (n,) Rising evenly [s]
    columns: dict[str, np.ndarray]  # (n,) By signal; NaN where nothing was measured near by
    # (n,) Direction that headings are measured from: of the waterway's line, from north; 0 in a plane [rad]
    axis: np.ndarray
    position: np.ndarray  # (n,) On the map, north and i times east; x and i times y in a plane [m]
    pace: float  # For the way of a ship length [s]

    @property
    def dt(self) -> float:
        """Between two times [s]."""
        return float(self.t[1] - self.t[0])

    def __contains__(self, name: object) -> bool:
        """Whether there is such a signal."""
        return name in self.columns

    def __getitem__(self, name: str) -> np.ndarray:
        """A signal."""
        return self.columns[name]

    @property
    def heading(self) -> np.ndarray:
        """Heading on the map [rad]."""
        return np.asarray(self["psi"] + self.axis)

    def windows(self, lengths: float) -> Windows:
        """Return first and last places of windows, each half over the next."""
        width = max(2, round(lengths * self.pace / self.dt))
        first = np.arange(0, len(self.t) - width, max(1, width // 2))
        return first, first + width

    def integrals(self, values: np.ndarray, windows: Windows) -> np.ndarray:
        """Return the integral of a column over windows, (windows,); NaN over gaps."""
        # values (n,)
        steps = (values[1:] + values[:-1]) * (self.dt / 2)
        unknown = ~np.isfinite(steps)
        way = np.concatenate([[0.0], np.cumsum(np.where(unknown, 0.0, steps))])
        lapses = np.concatenate([[0], np.cumsum(unknown)])
        return np.where(changes(lapses, windows) > 0, np.nan, changes(way, windows))


def changes(values: np.ndarray, windows: Windows) -> np.ndarray:
    """Return by how much a column changes over windows, (windows,)."""
    # values (n,)
    first, last = windows
    return np.asarray(values[last] - values[first])


def even_motion(record: ShipRecord, length: float, waterway: Waterway | None = None) -> EvenMotion | None:
    """Return a record at even times; None where it is too short, or nothing tells how fast the ship is."""
    # length [m]
    speed = usual_speed(record)
    if speed is None or not record.duration > 0:
        return None
    pace = length / speed
    t = np.arange(record.start, record.stop, max(pace / A_LENGTH, record.duration / MOST))
    if len(t) < FEWEST:
        return None
    columns = {name: _evenly(signal, t) for name, signal in record.signals.items() if len(signal)}
    axis, position = np.zeros(len(t)), np.full(len(t), np.nan, complex)
    if {"x", "y"} <= columns.keys():
        known = np.isfinite(columns["x"] + columns["y"])
        x, y = columns["x"][known], columns["y"][known]
        if waterway is None:
            position[known] = x + 1j * y
        else:
            (east, north), axis = waterway.to_map(x, y)[0].T, np.full(len(t), np.nan)
            position[known] = north + 1j * east
            axis[known] = np.unwrap(waterway.line.heading(x))
    return EvenMotion(t, columns, axis, position, pace)


def usual_speed(record: ShipRecord) -> float | None:
    """Return how fast the ship is by its positions [m/s], or else by its speeds; None where it has neither."""
    if "x" in record and "y" in record and len(record["x"]) > PIECES:
        at = np.linspace(record["x"].t[0], record["x"].t[-1], PIECES + 1)
        steps = np.hypot(*(np.diff(record[name].at(at)) for name in ("x", "y")))
        speed = float(np.median(steps[np.isfinite(steps)]) / (at[1] - at[0])) if np.isfinite(steps).any() else 0.0
    else:
        known = [record[name].values for name in ("u_ground", "speed_over_ground", "u") if name in record]
        speed = float(np.median(known[0])) if known else 0.0
    return speed if speed > 0 else None


def _evenly(signal: Signal, t: np.ndarray) -> np.ndarray:
    """Means of what was measured about even times; straight between what came less often."""
    dt = float(t[1] - t[0])
    if signal.step < dt / 2:
        bins = np.floor((signal.t - t[0]) / dt + 0.5).astype(int)
        first = np.flatnonzero(np.diff(bins, prepend=-1))
        counts = np.diff(first, append=len(bins))
        signal = Signal(*(np.add.reduceat(column, first) / counts for column in (signal.t, signal.values)))
    return signal.at(t, JOINED * max(signal.step, dt))
