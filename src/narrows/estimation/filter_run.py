"""A run of one filter in real time: readings in the order of measurement, with a history for late ones."""

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.estimation.recursion import DriftMonitor, UpdateResult
from narrows.estimation.sensor import Sensor
from narrows.estimation.settings import SAME_TIME
from narrows.estimation.ship_filter import MotionStep, ShipFilter
from narrows.estimation.unscented import Gaussian

Readings = dict[str, tuple[float, ...]]


class Moment(NamedTuple):
    """The filter's state at a time, from which it can continue or repeat."""

    t: float  # Time [s]
    state: Gaussian
    positions: np.ndarray  # (actuators,) Indicated positions
    readings: Readings  # Readings of that time
    monitor: DriftMonitor  # Drift monitor after them
    steps: Sequence[MotionStep] = ()  # Steps of the motion since the moment before


@dataclass
class FilterRun:
    filter: ShipFilter
    history: list[Moment]  # Recent moments, the current one last
    horizon: float  # Largest delay of a reading [s]
    kept: float  # Duration of the history [s]
    left_out: frozenset[str] = frozenset()  # Sensors whose readings are stored and not used
    results: list[UpdateResult] = field(default_factory=list)  # Results of the last call
    times: list[float] | None = None  # Times of the results [s]; if given, likelihoods are computed
    begun: float = field(init=False)  # Time of the start [s]

    def __post_init__(self) -> None:
        self.begun = self.history[0].t

    @property
    def last(self) -> Moment:
        return self.history[-1]

    def update(self, t: float, measured: Readings, at: np.ndarray, notes: list[str]) -> bool:
        """Process the readings of one time; return False if the mean of the state met a bank."""
        self.results, self.times = [], None
        now = max(t, self.last.t)
        if t > self.last.t + SAME_TIME and not self.horizon:
            afloat = self.advance(t, at, measured)
        else:
            afloat = self._sorted(t, now, measured, at, notes)
        while len(self.history) > 1 and self.history[1].t <= now - self.kept + SAME_TIME:
            del self.history[0]
        return afloat

    def _sorted(self, t: float, now: float, measured: Readings, at: np.ndarray, notes: list[str]) -> bool:
        groups: dict[float, Readings] = {now: {}}
        for name, reading in measured.items():
            groups.setdefault(t - self.filter.sensors[name].late, {})[name] = reading
        return all(self._insert(time, groups[time], at, now, notes) for time in sorted(groups))

    def _insert(self, time: float, readings: Readings, at: np.ndarray, now: float, notes: list[str]) -> bool:
        """Insert readings at their time, and repeat later updates."""
        history = self.history
        place = bisect_right(history, time + SAME_TIME, key=lambda moment: moment.t)
        if place == 0 or time < now - self.horizon - SAME_TIME:
            names = ", ".join(readings)
            notes.append(f"The readings of {names} are of t = {time:g} s, before anything that is kept: not used.")
            return True
        later, base = history[place:], history[place - 1]
        del history[place:]
        ahead_t, ahead = (later[0].t, later[0].positions) if later else (now, at)
        share = 1.0 if ahead_t - base.t <= SAME_TIME else min(1.0, (time - base.t) / (ahead_t - base.t))
        positions = base.positions + share * (ahead - base.positions)
        if not self.advance(time, positions, readings):
            return False
        fresh, self.results = self.results, []
        afloat = all(self.advance(moment.t, moment.positions, moment.readings) for moment in later)
        self.results = fresh
        return afloat

    def advance(self, time: float, positions: np.ndarray, readings: Readings) -> bool:
        """Advance from the last moment to a time and use its readings; return False if the mean met a bank."""
        last = self.last
        state, monitor, known, taken = last.state, last.monitor, last.readings, last.steps
        if time - last.t > SAME_TIME:
            taken = self.filter.steps(state, time - last.t, last.positions, positions)
            if taken[-1].aground:
                return False
            state, known = taken[-1].state, {}
        else:
            self.history.pop()
            time = last.t
        used = {name: one for name, one in readings.items() if name not in self.left_out} if self.left_out else readings
        if used:
            monitor = monitor.copy() if self.horizon else monitor
            result = self.filter.recursion.update(state, used, monitor, self.times is not None)
            state = result.state
            self.results.append(result)
            if self.times is not None:
                self.times.append(time)
        self.history.append(Moment(time, state, positions, {**known, **readings}, monitor, taken))
        return True


def replay(
    filter: ShipFilter, first: Moment, later: Sequence[Moment], horizon: float, kept: float,
    left_out: frozenset[str] = frozenset(),
) -> FilterRun | None:  # fmt: skip
    """Repeat a filter from a stored moment over later readings, with likelihoods; None if it meets a bank."""
    run = FilterRun(filter, [first], horizon, kept, left_out, times=[])
    for moment in later:
        if not run.advance(moment.t, moment.positions, moment.readings):
            return None
    return run


TIME = "t"


@dataclass(frozen=True)
class Records:
    t: np.ndarray  # (rows,) Rising times [s]
    readings: dict[str, np.ndarray]  # (rows, numbers) Readings by sensor
    positions: dict[str, np.ndarray]  # (rows,) Positions of actuators, by name

    def rows(self) -> Iterator[tuple[float, dict[str, np.ndarray], dict[str, float]]]:
        """Yield each time with the valid readings and actuator positions."""
        for number, t in enumerate(self.t.tolist()):
            now = {name: column[number] for name, column in self.readings.items() if np.isfinite(column[number]).all()}
            known = {n: float(column[number]) for n, column in self.positions.items() if np.isfinite(column[number])}
            yield t, now, known


def records_of(table: Any, sensors: Mapping[str, Sensor], actuators: Sequence[str]) -> Records:
    columns = _columns(table)
    fields = {field for sensor in sensors.values() for field in sensor.fields}
    if TIME not in columns:
        raise InputError("records need their times; give a column t [s]")
    for name in columns:
        if name not in fields and name not in actuators and name != TIME:
            known = (TIME, *sorted(fields), *actuators)
            hint = did_you_mean(name, known) or f"; there are {', '.join(known)}"
            raise InputError(f"no sensor of this estimator has a column {name!r}{hint}")
    t = columns[TIME]
    if len(t) == 0 or not np.isfinite(t).all() or (np.diff(t) <= 0.0).any():
        raise InputError("times of records are finite and rise; sort them, and merge rows of one time")
    nothing = np.full(len(t), np.nan)
    readings = {
        name: np.stack([columns.get(field, nothing) for field in sensor.fields], axis=1)
        for name, sensor in sensors.items()
    }
    return Records(t, readings, {name: columns[name] for name in actuators if name in columns})


def _columns(table: Any) -> dict[str, np.ndarray]:
    if hasattr(table, "coords") and hasattr(table, "data_vars"):
        table = {str(name): table[name].to_numpy() for name in (*table.coords, *table.data_vars)}
    elif hasattr(table, "reset_index"):
        frame = table.reset_index() if table.index.name == TIME else table
        table = {str(name): frame[name].to_numpy() for name in frame.columns}
    if not isinstance(table, Mapping):
        raise InputError("records are a DataFrame, a Dataset or a mapping of columns; give one")
    try:
        columns = {str(name): np.asarray(column, float) for name, column in table.items()}
    except (TypeError, ValueError):
        raise InputError("records contain a value that is not a number; leave missing values empty (NaN)") from None
    sizes = {column.shape for column in columns.values()}
    if len(sizes) > 1 or any(len(size) != 1 for size in sizes):
        raise InputError("columns of records have different lengths; give one value per row, NaN for no reading")
    return columns


# Readings from a bridge: by name, checked, without NaN.
Reading = float | Sequence[float]


def checked_readings(
    readings: Mapping[str, Any], sensors: Mapping[str, Sensor], actuators: Sequence[str]
) -> tuple[dict[str, tuple[float, ...]], dict[str, float], tuple[str, ...]]:
    """Split readings into those of sensors and of actuators, without NaN, and a note on invalid ones."""
    measured: dict[str, tuple[float, ...]] = {}
    positions: dict[str, float] = {}
    lost = []
    for name, reading in readings.items():
        if name not in sensors and name not in actuators:
            known = (*sensors, *actuators)
            hint = did_you_mean(name, known) or f"; there are {', '.join(known)}"
            raise InputError(f"no sensor of this estimator is called {name!r}{hint}")
        numbers = _numbers(name, reading, len(sensors[name].fields) if name in sensors else 1)
        if not all(map(math.isfinite, numbers)):
            lost.append(name)
        elif name in sensors:
            measured[name] = numbers
        else:
            positions[name] = numbers[0]
    notes = (f"The reading of {' and '.join(lost)} is not a number and was not used.",) if lost else ()
    return measured, positions, notes


def _numbers(name: str, reading: Any, count: int) -> tuple[float, ...]:
    if count == 1 and isinstance(reading, float):  # Fast path for the most frequent case
        return (reading,)
    if reading is None:
        return (math.nan,) * count
    try:
        numbers = tuple(np.asarray(reading, float).ravel().tolist())
    except (TypeError, ValueError):
        raise InputError(f"a reading of {name} is {count} number(s), and this one is {reading!r}") from None
    if len(numbers) != count:
        raise InputError(f"a reading of {name} is {count} number(s), and this one has {len(numbers)}; give as many")
    return numbers
