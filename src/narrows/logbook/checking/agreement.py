"""Ratio of two measured changes, whichever of them is noisy; and agreement of motions in a plane."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from narrows.logbook import settings
from narrows.logbook.ship_record import ShipRecord, Signal
from narrows.waterway import Waterway


class Factor(NamedTuple):
    """Ratio of two changes, whichever of them is noisy."""

    # Frisch (1934), Statistical confluence analysis by means of complete regression systems: the slopes of either
    # regression bound that of the relation.

    low: float  # With all noise in one of the two, widened by ``SURE`` standard errors
    high: float  # With all noise in the other, widened likewise
    correlation: float  # Between the two [1]
    windows: float  # That tell independently

    @property
    def told(self) -> bool:
        """True where enough windows determine the ratio, with one sign."""
        return bool(self.windows >= settings.FEWEST_WINDOWS and self.low * self.high > 0)

    def holds(self, factor: float, slack: float) -> bool:
        low, high = sorted((factor / slack, factor * slack))
        return bool(self.low <= high and self.high >= low)

    @property
    def middle(self) -> float:
        """Its geometric mean; 0 where its sign is not told."""
        return float(np.copysign(np.sqrt(self.low * self.high), self.low)) if self.low * self.high > 0 else 0.0


def factor_of(change: np.ndarray, expected: np.ndarray) -> Factor:
    """Return by which factor changes are those that are expected, but for a constant."""
    # change, expected (windows,)
    known = np.isfinite(change) & np.isfinite(expected)
    windows = float(known.sum() / settings.OVERLAP)
    if windows < settings.FEWEST_WINDOWS:
        return Factor(-np.inf, np.inf, 0.0, windows)
    a, b = change[known] - np.mean(change[known]), expected[known] - np.mean(expected[known])
    aa, bb, ab = float(a @ a), float(b @ b), float(a @ b)
    if not aa * bb > 0 or ab == 0:
        return Factor(-np.inf, np.inf, 0.0, windows)
    correlation = ab / np.sqrt(aa * bb)
    error = settings.SURE * np.sqrt(max(1 - correlation**2, 0.0) / (windows - 2) * aa / bb)
    # The error of the slope with all noise in the other grows as the correlation falls.
    gentle, steep = sorted((ab / bb, aa / ab), key=abs)
    gentle, steep = abs(gentle) - error, abs(steep) + error / correlation**2
    low, high = (gentle, steep) if ab > 0 else (-steep, -gentle)
    return Factor(low, high, correlation, windows)


class Turned(NamedTuple):
    """Rotation and stretch between motions in a plane."""

    stretch: float  # By which factor [1]
    turn: float  # By which angle [rad]
    error: float  # Standard error of the stretch, and of the turn [rad] [1]
    apart: float  # What is left of the motions, over their size [1]


def turned_of(way: np.ndarray, expected: np.ndarray) -> Turned | None:
    """Return how far ways are those that are expected, turned and stretched; None where too few are known."""
    # way, expected (windows,) [m]
    known = np.isfinite(way) & np.isfinite(expected)
    a, b = way[known], expected[known]
    windows, bb, aa = known.sum() / settings.OVERLAP, float((np.abs(b) ** 2).sum()), float((np.abs(a) ** 2).sum())
    if windows < settings.FEWEST_WINDOWS or not bb * aa > 0:
        return None
    factor = np.vdot(b, a) / bb
    left = float((np.abs(a - factor * b) ** 2).sum())
    error = np.sqrt(left / (2 * (windows - 1)) / bb / settings.OVERLAP)
    return Turned(float(abs(factor)), float(np.angle(factor)), float(error), float(np.sqrt(left / aa)))


class Estimates(NamedTuple):
    values: np.ndarray  # (numbers,) With their standard errors
    errors: np.ndarray  # (numbers,) With their standard errors


def least_squares(
    column: np.ndarray, regressors: Sequence[np.ndarray], overlap: float = settings.OVERLAP
) -> Estimates | None:
    """Return the numbers that make a column of others; None where too few rows are known."""
    # column (rows,); regressors (rows,)
    design = np.stack(regressors, axis=1)
    known = np.isfinite(column) & np.isfinite(design).all(axis=1)
    rows = known.sum() / overlap - design.shape[1]
    if rows < settings.FEWEST_WINDOWS:
        return None
    scale = np.abs(design[known]).max(axis=0)
    scale[scale == 0] = 1.0
    scaled = design[known] / scale
    values = np.linalg.lstsq(scaled, column[known], rcond=None)[0]
    left = column[known] - scaled @ values
    spread = np.linalg.pinv(scaled.T @ scaled) * float(left @ left) / rows
    return Estimates(values / scale, np.sqrt(np.diag(spread)) / scale)


class Pooled(NamedTuple):
    value: float  # With its standard error
    error: float  # With its standard error
    numbers: int  # How many are in it


def pooled(effects: Sequence[tuple[float, float]]) -> Pooled | None:
    """Return the mean of numbers, weighted by their standard errors; None where there is none."""
    # effects (float, float)
    known = [(effect, error) for effect, error in effects if error > 0]
    if not known:
        return None
    weight = sum(error**-2 for _, error in known)
    return Pooled(sum(effect * error**-2 for effect, error in known) / weight, weight**-0.5, len(known))


def nearest(factor: float, known: Mapping[str, float], slack: float = 1.1) -> str | None:
    if not factor > 0:
        return None
    off = {cause: float(abs(np.log(factor / usual))) for cause, usual in known.items()}
    best = min(off, key=lambda cause: off[cause])
    return best if off[best] < np.log(slack) else None


Windows = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class EvenMotion:
    t: np.ndarray  # (n,) Rising evenly [s]
    columns: dict[str, np.ndarray]  # (n,) By signal; NaN where nothing was measured near by
    axis: np.ndarray  # (n,) Zero of headings: direction of the line, from north; 0 in a plane [rad]
    position: np.ndarray  # (n,) On the map, north and i times east; x and i times y in a plane [m]
    pace: float  # For the way of a ship length [s]

    @property
    def dt(self) -> float:
        return float(self.t[1] - self.t[0])

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __getitem__(self, name: str) -> np.ndarray:
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
    speed = usual_speed(record)
    if speed is None or not record.duration > 0:
        return None
    pace = length / speed
    t = np.arange(
        record.start, record.stop, max(pace / settings.STEPS_A_LENGTH, record.duration / settings.MOST_READINGS)
    )
    if len(t) < settings.FEWEST_READINGS:
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
    if "x" in record and "y" in record and len(record["x"]) > settings.SPEED_PIECES:
        at = np.linspace(record["x"].t[0], record["x"].t[-1], settings.SPEED_PIECES + 1)
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
    return signal.at(t, settings.JOINED * max(signal.step, dt))
