"""A run of one filter: readings in the order of measurement, with a history for late ones."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from narrows.estimation.settings import SAME_TIME
from narrows.estimation.ship_filter import MotionStep, ShipFilter, UpdateResult
from narrows.estimation.unscented import Gaussian

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
            groups.setdefault(t - self.filter.sensors[name].late, {})[name] = reading
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
