"""A run of one filter: its readings, checked; its start; its history, for late readings."""

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.base.errors import InputError, did_you_mean
from narrows.estimation.sensors import Sensor, error_states
from narrows.estimation.settings import SAME_TIME, START_READINGS
from narrows.estimation.ship_filter import MotionStep, ShipFilter, UpdateResult
from narrows.estimation.states import Columns, Gaussian

if TYPE_CHECKING:
    import pandas as pd

Readings = dict[str, tuple[float, ...]]
AGROUND = "At t = {:g} s the estimate lay in a bank or beyond the waterway: it begins anew."


class Moment(NamedTuple):
    """The filter's state at a time, from which it can continue or repeat."""

    t: float  # Time [s]
    state: Gaussian
    positions: np.ndarray  # (actuators,) Indicated positions
    readings: Readings  # Readings of that time
    monitor: np.ndarray  # Sums of the drift monitor after them
    steps: Sequence[MotionStep] = ()  # Steps of the motion since the moment before


@dataclass
class FilterRun:
    filter: ShipFilter
    history: list[Moment]  # Recent moments, the current one last
    horizon: float  # Largest delay of a reading [s]
    kept: float  # Duration of the history [s]
    left_out: frozenset[str] = frozenset()  # Sensors whose readings are stored and not used
    results: list[UpdateResult] = field(default_factory=list)  # Results of the last call
    begun: float = field(init=False)  # Time of the start [s]

    def __post_init__(self) -> None:
        self.begun = self.last.t

    @property
    def last(self) -> Moment:
        return self.history[-1]

    def update(self, t: float, measured: Readings, at: np.ndarray, notes: list[str]) -> bool:
        """Process the readings of one time; return False if the mean of the state met a bank."""
        self.results, now = [], max(t, self.last.t)
        groups: dict[float, Readings] = {now: {}}
        for name, reading in measured.items():
            groups.setdefault(t - self.filter.sensors[name].delay, {})[name] = reading
        afloat = all(self._insert(time, groups[time], at, now, notes) for time in sorted(groups))
        while len(self.history) > 1 and self.history[1].t <= now - self.kept + SAME_TIME:
            del self.history[0]
        return afloat

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
        positions = ahead + (1.0 - share) * (base.positions - ahead)
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
            taken = self.filter.advance(state, time - last.t, last.positions, positions)
            if taken[-1].aground:
                return False
            state, known = taken[-1].state, {}
        else:
            self.history.pop()
            time = last.t
        used = {name: one for name, one in readings.items() if name not in self.left_out} if self.left_out else readings
        if used:
            monitor = monitor.copy() if self.horizon else monitor
            state, result = self.filter.update(time, state, used, monitor)
            self.results.append(result)
        self.history.append(Moment(time, state, positions, {**known, **readings}, monitor, taken))
        return True


def replay(
    filter: ShipFilter, first: Moment, later: Sequence[Moment], horizon: float, kept: float,
    left_out: frozenset[str] = frozenset(),
) -> FilterRun | None:  # fmt: skip
    """Repeat a filter from a stored moment over later readings; None if it meets a bank."""
    run = FilterRun(filter, [first], horizon, kept, left_out)
    afloat = all(run.advance(moment.t, moment.positions, moment.readings) for moment in later)
    return run if afloat else None


TIME = "t"
# Readings from a bridge: by name, checked, without NaN.
Reading = float | Sequence[float]


def records_of(table: Any, sensors: Mapping[str, Sensor], actuators: Sequence[str]) -> "pd.DataFrame":
    """Return a column for each field and each actuator, NaN without readings, over rising times."""
    import pandas as pd

    try:
        frame = pd.DataFrame(table.to_dataframe() if hasattr(table, "to_dataframe") else table)
        frame = (frame.reset_index() if frame.index.name == TIME else frame).astype(float)
    except (TypeError, ValueError):
        raise InputError(
            "records are a DataFrame, a Dataset or a mapping of columns of numbers, all of one length; give one, with "
            "missing values empty (NaN)"
        ) from None
    known = [TIME, *(field for sensor in sensors.values() for field in sensor.fields), *actuators]
    for name in frame.columns:
        if name not in known:
            raise InputError(f"no sensor of this estimator has a column {name!r}{did_you_mean(str(name), known)}")
    if TIME not in frame:
        raise InputError("records need their times; give a column t [s]")
    t = frame[TIME].to_numpy()
    if len(t) == 0 or not np.isfinite(t).all() or (np.diff(t) <= 0.0).any():
        raise InputError("times of records are finite and rise; sort them, and merge rows of one time")
    return frame.reindex(columns=known).set_index(TIME)


def rows_of(
    records: "pd.DataFrame", sensors: Mapping[str, Sensor], actuators: Sequence[str]
) -> Iterator[tuple[float, dict[str, tuple[float, ...]]]]:
    """Yield each time with its readings, and positions of actuators, without NaN."""
    fields = {**{name: list(sensor.fields) for name, sensor in sensors.items()}, **{name: [name] for name in actuators}}
    columns = {name: records[own].to_numpy() for name, own in fields.items()}
    for number, t in enumerate(records.index.tolist()):
        now = {name: column[number] for name, column in columns.items()}
        yield t, {name: tuple(row.tolist()) for name, row in now.items() if np.isfinite(row).all()}


def checked_readings(
    readings: Mapping[str, Any], sensors: Mapping[str, Sensor], actuators: Sequence[str]
) -> tuple[dict[str, tuple[float, ...]], dict[str, float], list[str]]:
    """Split readings into those of sensors and of actuators, without NaN, and a note on invalid ones."""
    measured: dict[str, tuple[float, ...]] = {}
    positions: dict[str, float] = {}
    lost, known = [], (*sensors, *actuators)
    for name, reading in readings.items():
        if name not in known:
            raise InputError(f"no sensor of this estimator is called {name!r}{did_you_mean(name, known)}")
        numbers = _numbers(name, reading, len(sensors[name].fields) if name in sensors else 1)
        if not all(map(math.isfinite, numbers)):
            lost.append(name)
        elif name in sensors:
            measured[name] = numbers
        else:
            positions[name] = numbers[0]
    notes = [f"The reading of {' and '.join(lost)} is not a number and was not used."] if lost else []
    return measured, positions, notes


def _numbers(name: str, reading: Any, count: int) -> tuple[float, ...]:
    if count == 1 and isinstance(reading, float):  # Fast path for the most frequent case
        return (reading,)
    try:
        numbers = tuple(np.asarray(math.nan if reading is None else reading, float).ravel().tolist())
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != count and reading is not None:
        raise InputError(f"a reading of {name} is {count} number(s), and this one is {reading!r}; give as many")
    return numbers


# States needed for a start, in words; the other states begin at their priors.
NEEDED = {"x": "a place", "y": "a place", "psi": "a heading", "u": "a speed through the water"}


@dataclass
class Start:
    """The latest readings of each sensor, collected for a start: their median, not the first."""

    filter: ShipFilter
    readings: dict[str, list[tuple[float, Sequence[float]]]] = field(default_factory=dict)  # With their times [s]

    def add(self, t: float, readings: Mapping[str, Sequence[float]]) -> None:
        for name, reading in readings.items():
            self.readings[name] = [*self.readings.get(name, ())[1 - START_READINGS :], (t, reading)]

    def values(self) -> dict[str, tuple[float, dict[str, float]]]:
        """Return states, each with the entries of its row of the root; of two sensors of a state, the better."""
        found: dict[str, tuple[float, dict[str, float]]] = {}
        for name, rows in self.readings.items():
            if len(rows) < START_READINGS:
                continue
            sensor, reading = self.filter.sensors[name], rows[-1][1]
            for state, (last, std) in sensor.start(reading).items():
                values = [sensor.start(one)[state][0] for _, one in rows]
                if state == "psi":
                    values = [last + math.remainder(value - last, 2.0 * math.pi) for value in values]
                entries = {state: std}
                for error, (place, size, _) in error_states(sensor, name in self.filter.faults).items():
                    moved = [number + (component == place) for component, number in enumerate(reading)]
                    entries[error] = -size * (sensor.start(moved)[state][0] - last)
                if state not in found or math.hypot(*entries.values()) < math.hypot(*found[state][1].values()):
                    found[state] = float(np.median(values)), entries
        return found

    @property
    def missing(self) -> str:
        """Return what is missing, in words; empty if there are enough readings."""
        known = self.values()
        return " and ".join(dict.fromkeys(what for state, what in NEEDED.items() if state not in known))

    def refusal(self) -> InputError:
        what = f"an estimate starts from {START_READINGS} readings of each"
        return InputError(f"these records lack {self.missing}; {what}")

    def state(self, t: float) -> Gaussian:
        filter, known = self.filter, self.values()
        names, places = filter.states.names, filter.states.places
        current = float(filter.waterway.current_at(known["x"][0])) if filter.waterway else 0.0
        mean = filter.states.vector({"current": current, **{name: value for name, (value, _) in known.items()}})
        size, more = len(names), filter.estimated
        full = np.diag([filter.spreads.get(name, 0.0) for name in names] + [1.0] * more)
        for name, (_, entries) in known.items():
            for other, entry in entries.items():
                full[places[name], places[other]] = entry
        return Gaussian(np.concatenate([self._at_midship(t, mean, full[:size], current), np.zeros(more)]), full)

    def _at_midship(self, t: float, mean: np.ndarray, root: np.ndarray, current: float) -> np.ndarray:
        """Convert antenna positions to one time and to midship, in the root too, since the heading is uncertain."""
        filter = self.filter
        name = next(name for name, rows in self.readings.items() if "x" in filter.sensors[name].start(rows[-1][1]))
        sensor, u, psi = filter.sensors[name], mean[3], mean[2]
        way = np.array([u * math.cos(psi) + current, u * math.sin(psi)])
        place = np.median([np.array(reading) + (t - then) * way for then, reading in self.readings[name]], axis=0)
        bend = filter.lanes.bend(float(place[0]))

        def measured(state: np.ndarray) -> np.ndarray:
            found = sensor.measured(Columns(state[None], filter.states, bend))
            return np.array([float(np.ravel(number)[0]) for number in found])

        for _ in range(6):  # In a bend each round leaves a small share of the error
            mean = mean.copy()
            mean[:2] += place - measured(mean)
        small = 1e-4  # [rad]
        turned = mean.copy()
        turned[2] += small
        root[:2] -= np.outer((measured(turned) - measured(mean)) / small, root[2])
        return mean
