"""Runs of filters: the start, the history for late readings, and the bank of filters that isolates faults.

All filters of the bank explain the same recent readings, each with an error of one sensor as a state: a small drift
from one of several onsets, or a recent step. The most likely one names the faulty sensor, which is then left out.

Source: Willsky and Jones (1976), A generalized likelihood ratio approach to the detection and estimation of jumps in
linear systems, IEEE Transactions on Automatic Control 21. Time-outs, and a restart after lasting refusal, follow PX4's
EKF2.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from narrows.base.errors import InputError
from narrows.estimation import settings
from narrows.estimation.sensors import error_states
from narrows.estimation.settings import SAME_TIME, START_READINGS
from narrows.estimation.ship_filter import MODEL, MotionStep, ShipFilter, UpdateResult
from narrows.estimation.states import Columns, Gaussian
from narrows.simulation.kernel_run import RUDDER

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
        small = 1e-6  # [rad]
        turned = mean.copy()
        turned[2] += small
        root[:2] -= np.outer((measured(turned) - measured(mean)) / small, root[2])
        return mean


Faults = frozenset[str]


class Hypothesis(NamedTuple):
    faults: Faults
    run: FilterRun  # Filter with these faults, run over the moments of the window
    score: float  # Log-likelihood of all readings in the bank's window, less the penalty of the faults
    is_restart: bool = False  # True if it starts from readings and not from the estimate


@dataclass
class FaultBank:
    filter: ShipFilter  # Filter without faults
    t: float = 0.0  # Time of the start [s]
    faults: Faults = frozenset()  # Current faults: sensors, the rudder's indicator, the model
    _refused: dict[str, float] = field(default_factory=dict)
    _same: dict[str, tuple[tuple[float, ...], int]] = field(default_factory=dict)
    _since: dict[str, float] = field(default_factory=dict)
    _watched: float | None = None

    def __post_init__(self) -> None:
        self.horizon = max(sensor.delay for sensor in self.filter.sensors.values())  # Largest delay of a reading [s]
        self.scale = self.filter.time_scale
        self.wait, self.window = settings.JUDGE_WAIT * self.scale, settings.REPLAY_TIME * self.scale
        self.kept = max(self.horizon, self.window)
        self._next = self._routine = self.t
        self._suspects = [*self.filter.sensors, *({RUDDER} & set(self.filter.actuators)), MODEL]

    def test_hypotheses(self, run: FilterRun, read: Readings) -> tuple[FilterRun, str]:
        """Return the run of the most likely hypothesis on new readings, and a sentence if the hypothesis changed."""
        t = run.last.t
        refusing, drifting, stuck = self._refusing(run, t), self._drifting(run, t), self._stuck(read)
        routine = bool(stuck - self.faults or self.faults) and t >= self._routine
        young = t - run.begun < self.window
        if t < max(self._next, run.begun + 2 * self.wait) or not (refusing or drifting or routine):
            return run, ""
        self._next, self._routine = t + self.wait, t + self.window
        suspects = [one for one in self._suspects if refusing or drifting or one in stuck]
        best = self._best_hypothesis(run, suspects, refusing, stuck)
        # A ship does not jump: a restart is for an estimate that was wrong from its start, or that no hypothesis
        # explains.
        unexplained = young or best is None or (refusing and _still_refused(best.run))
        restart = self._restart_hypothesis(run) if unexplained else None
        cost = 0.0 if young else settings.FAULT_PRIOR
        if restart and (
            best is None
            or restart.score - cost > _likelihood(best.run, restart.run.begun) - _penalty_of_faults(best.faults)
        ):
            best = restart
        if best is None or (best.faults == self.faults and not best.is_restart):
            return run, ""
        return self._switched_to(run, best, t)

    def _switched_to(self, run: FilterRun, best: Hypothesis, t: float) -> tuple[FilterRun, str]:
        own, (first, *later) = self.filter.with_faults(best.faults & {RUDDER, MODEL}), best.run.history
        first = first._replace(state=own.adopt(first.state, best.run.filter), monitor=own.monitor())
        after = replay(own, first, later, self.horizon, self.kept, best.faults)
        if after is None:
            return run, ""
        if not best.is_restart:
            after.begun = run.begun
            if own.states == run.filter.states:
                before = bisect_left(run.history, first.t - settings.SAME_TIME, key=lambda one: one.t)
                after.history[:0] = run.history[:before]
        said = _sentence(t, self.faults, best.faults, best.is_restart)
        self._since |= dict.fromkeys(best.faults - self.faults, t)
        self.faults, self._refused, after.results = best.faults, {}, []
        return after, said

    def _refusing(self, run: FilterRun, t: float) -> bool:
        for result in run.results:
            odd = (*result.refused, *result.surprising)
            for name in result.nis:
                if name in odd:
                    self._refused.setdefault(name, t)
                else:
                    self._refused.pop(name, None)
        periods = ((t - since) / self.filter.sensors[name].period for name, since in self._refused.items())
        return max(periods, default=0.0) >= settings.REFUSED_PERIODS

    def _drifting(self, run: FilterRun, t: float) -> bool:
        """Return whether a sensor drifts, or seemed to some readings ago: a step shows in the readings after it."""
        drift = max((result.drift_statistic for result in run.results), default=0.0)
        if self._watched is None and drift > settings.BANK_THRESHOLD and not self.faults:
            self._watched = t
        if self._watched is not None and t >= self._watched + self.wait:
            self._watched = None
            return True
        return drift > settings.DRIFT_THRESHOLD

    def _stuck(self, read: Readings) -> Faults:
        """Sensors, or the rudder's indicator, with a constant value for long: either stuck, or the motion is steady."""
        for name, reading in read.items():
            value, count = self._same.get(name, (None, 0))
            self._same[name] = (reading, count + 1 if reading == value else 1)
        return frozenset(name for name, (_, count) in self._same.items() if count >= settings.STUCK_READINGS)

    def _best_hypothesis(self, run: FilterRun, suspects: list[str], refusing: bool, stuck: Faults) -> Hypothesis | None:
        """Return the best of: no change, one sensor sound again, one more with a drift or a step."""
        moments, t, known = run.history, run.last.t, self.faults | stuck
        base = self._scored(self.faults, run.filter, moments, known)
        tried = [base]
        for one in self.faults - stuck:
            lasting = base and t - self._since[one] < settings.LONGEST_FAULT * self.scale
            cost = 0.0
            if lasting and base and not self._small(base.run, one):  # Without the wide error, right or wrong, it gains
                numbers = len(self.filter.sensors[one].fields) if one in self.filter.sensors else 1
                cost = settings.FAULT_PRIOR + numbers * math.log(settings.FAULT_STD)
            tried.append(self._scored(self.faults - {one}, run.filter, moments, known, cost))
        onsets = [(t - ago * self.scale, settings.DRIFT_START) for ago in settings.DRIFT_ONSETS]
        step = (min(self._refused.values()), 1.0) if refusing else (t - self.wait, settings.STEP_START)
        onsets.append(step)
        for one, (onset, size) in product(suspects, onsets):
            if base and one not in self.faults:
                place = max(bisect_left(moments, onset, key=lambda moment: moment.t) - 1, 0)
                cost = math.log(len(onsets)) + _likelihood(base.run, moments[place].t) - _likelihood(base.run)
                later = base.run.history[place:]
                tried.append(self._scored(self.faults | {one}, base.run.filter, later, known, cost, size))
        return _most_likely(tried)

    def _scored(
        self, faults: Faults, before: ShipFilter, moments: list[Moment], known: Faults, cost: float = 0.0,
        size: float = 1.0,
    ) -> Hypothesis | None:  # fmt: skip
        """Run a filter over moments, from the first one's state of the filter before."""
        own, (first, *later) = self.filter.with_faults(faults), moments
        state = own.adopt(first.state, before, size)
        run = replay(own, first._replace(state=state, monitor=own.monitor()), later, self.horizon, self.kept)
        score = _likelihood(run) - _penalty_of_faults(faults, known) - cost if run else 0.0
        return Hypothesis(faults, run, score) if run else None

    def _small(self, run: FilterRun, name: str) -> bool:
        """Return whether the error of a sensor is as small as its noise again."""
        if name not in self.filter.sensors:
            return True
        sensor, places = self.filter.sensors[name], run.filter.states.places
        means = (abs(run.last.state.mean[places[f"{field}_fault"]]) for field in sensor.fields)
        return all(mean <= 2.0 * sigma for mean, sigma in zip(means, sensor.sigma, strict=True))

    def _restart_hypothesis(self, run: FilterRun) -> Hypothesis | None:
        """Return the most likely restart from recent readings, without the previous state."""
        since = min(self._refused.values(), default=run.last.t - settings.RESTART_TIME * self.scale)
        recent = [one for one in run.history if one.t >= since]
        start = Start(self.filter)
        while start.missing and recent:
            start.add(recent[0].t, recent[0].readings)
            first, recent = recent[0], recent[1:]
        if start.missing or not recent:
            return None
        sensors = self.filter.sensors.items()
        placing = [name for name, sensor in sensors if "x" in sensor.start((0.0,) * len(sensor.fields))]
        suspects = [one for one in self._suspects if one not in placing or len(placing) > 1]
        sets: list[Faults] = [frozenset(), *(frozenset({one}) for one in suspects)]
        tried = []
        for faults in sets:
            own = self.filter.with_faults(faults)
            begun = first._replace(state=replace(start, filter=own).state(first.t))
            tried.append(self._scored(faults, own, [begun, *recent], self.faults))
        best = _most_likely(tried)
        return best._replace(is_restart=True) if best else None


def _most_likely(tried: list[Hypothesis | None]) -> Hypothesis | None:
    return max((one for one in tried if one), key=lambda one: one.score, default=None)


def _still_refused(run: FilterRun) -> bool:
    names = {name for result in run.results for name in result.nis}
    recent = {name: [one for one in run.results if name in one.nis][-int(settings.REFUSED_PERIODS) :] for name in names}
    return any(all(name in (*one.refused, *one.surprising) for one in last) for name, last in recent.items())


def _likelihood(run: FilterRun, since: float = -math.inf) -> float:
    return math.fsum(result.log_likelihood for result in run.results if result.t > since + settings.SAME_TIME)


def _penalty_of_faults(faults: Faults, known: Faults = frozenset()) -> float:
    return settings.FAULT_PRIOR * len(faults - known) * len(faults)


def _sentence(t: float, before: Faults, after: Faults, is_restart: bool) -> str:
    new, back = sorted(after - before), sorted(before - after)
    parts = [
        (is_restart, "the estimate contradicted the readings and started again from the sensors that agree"),
        (new, f"{' and '.join(new)} contradicts the others: left out, and the estimate is less certain"),
        (back, f"{' and '.join(back)} agrees with the others again: used"),
    ]
    said = "; ".join(sentence for holds, sentence in parts if holds)
    return f"At t = {t:g} s {said}." if said else ""
