"""A record on even times: positions of actuators, readings between, and each signal as the ship's state predicts it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from narrows.base.errors import InputError
from narrows.logbook.ship_log import MEETING, TURNING, ShipRecord, Signal
from narrows.waterway import Waterway

CURRENTS = ("current_x", "current_y")  # The current along the axes [m/s], which enters signals over ground
# How much an actuator's position is truly above what is recorded or usual: [rad] to starboard, [1/s].
OFFSET = "{}_offset".format
RUDDER = "rudder"
ERROR = "{}_error".format  # Name of the constant error of a signal
STATES = ("x", "y", "psi", "u", "v", "r")
# A pilot looks out of the window, so that the rudder holds information on the motion that no sensor has: it is one more
# signal. Ljung (1999), System Identification, chapter 13: joint input-output identification of a closed loop.
HELM = "helm"
SEEN = ("y", "psi", "v", "r")  # States that a pilot sees
HELM_GAIN = "helm_by_{}".format  # Gain of each, a state of the filter
ONE = np.ones(1)


class PredictedSignal(NamedTuple):
    value: np.ndarray  # (n,) In the unit of the signal
    by_state: Mapping[int, np.ndarray]  # (n,) Slopes by those of ``STATES`` that it depends on
    by_error: Mapping[str, np.ndarray]  # (n,) Slopes by errors of the sensors and by the current

    def rows(self, read: "Readings", slopes: np.ndarray, names: Sequence[str]) -> np.ndarray:
        """Return slopes of readings by states and processes at the start of their step, (n, 6 + m)."""
        # slopes (steps, 6, 6 + m) of the ends of steps
        row, share = np.zeros((len(read.step), 6 + len(names))), read.share[:, None]
        for state, slope in self.by_state.items():
            by = np.broadcast_to(slope, len(share))[:, None]
            row[:, [state]] += by * (1 - share)
            row += by * share * slopes[read.step, state]
        for place, name in enumerate(names):
            if name in self.by_error:
                row[:, 6 + place] += self.by_error[name]
        return row


def predicted_signal(
    name: str, states: np.ndarray, errors: Mapping[str, Any], antenna: tuple[float, float], rudder: np.ndarray
) -> PredictedSignal:
    """Predict readings of a signal from states (n, 6), errors of sensors and the rudder before the step (n,) [rad]."""
    if name == HELM:  # At the end of a step, from where it was and what is seen; the law has a memory, as pilots have.
        seen = {own: states[:, STATES.index(own)] for own in SEEN} | {RUDDER: rudder}
        gains = {own: errors.get(HELM_GAIN(own), 0.0) for own in seen}
        value = rudder + errors.get(ERROR(HELM), 0.0) + sum(gains[own] * column for own, column in seen.items())
        by_error = {HELM_GAIN(own): column for own, column in seen.items()} | {ERROR(HELM): ONE}
        return PredictedSignal(value, {STATES.index(own): np.asarray(gains[own]) for own in SEEN}, by_error)
    psi, u, v = states[:, 2:5].T
    cosine, sine = np.cos(psi), np.sin(psi)
    by_error = {ERROR(name): ONE}
    if name in STATES:
        place = STATES.index(name)
        value, by_state = states[:, place], {place: ONE}
        if name in ("x", "y"):
            (forward, starboard), ahead, aside = antenna, (cosine, sine)[place], (-sine, cosine)[place]
            value = value + forward * ahead + starboard * aside
            by_state[2] = forward * aside - starboard * ahead
    else:
        x, y = (errors.get(axis, 0.0) for axis in CURRENTS)
        along, across = cosine * x + sine * y, cosine * y - sine * x
        value, by_u, by_v = _over_ground(name, u + along, v + across)
        by_state = {2: by_u * across - by_v * along, 3: by_u * ONE, 4: by_v * ONE}
        by_error |= zip(CURRENTS, (by_u * cosine - by_v * sine, by_u * sine + by_v * cosine), strict=True)
        if name == "course":
            value, by_state[2] = value + psi, by_state[2] + 1.0
    return PredictedSignal(value + errors.get(ERROR(name), 0.0), by_state, by_error)


def _over_ground(name: str, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, Any, Any]:
    """A signal by the velocities over ground along and across the ship, with its slopes; the course off the bow."""
    if name == "u_ground":
        return u, 1.0, 0.0
    if name == "v_ground":
        return v, 0.0, 1.0
    if name == "course":
        square = np.maximum(u**2 + v**2, 1e-12)
        return np.arctan2(v, u), -v / square, u / square
    speed = np.maximum(np.hypot(u, v), 1e-9)
    return speed, u / speed, v / speed


# Signals that the motion is held to.
READ = ("x", "y", "psi", "r", "u", "v", "u_ground", "v_ground", "speed_over_ground", "course")
GAP = 3.0  # Usual times between two values; longer gaps are not interpolated
FEWEST_STEPS = 8  # Steps of a record that a fit needs at least
NODES, SPIKES = 9, 5  # Nodes in the mean, and readings in the median, of a first guess


class Readings(NamedTuple):
    """Readings of one signal, by the step that each value lies in."""

    values: np.ndarray  # (n,) In the unit of the signal
    step: np.ndarray  # (n,) Step of each reading
    share: np.ndarray  # (n,) Elapsed share of that step [1]
    counted: np.ndarray  # (n,) Number of values in each mean
    gain: float = 1.0  # How many times the true value is read


@dataclass(frozen=True)
class RecordGrid:
    record: ShipRecord  # Record
    times: np.ndarray  # (nodes,) Ends of the steps [s]
    whole: np.ndarray  # (steps,) True where the actuators are known all through it, and no other ship passes
    positions: Mapping[str, np.ndarray]  # (nodes,) Positions of the actuators at the nodes
    readings: Mapping[str, Readings]  # By signal; of whole steps alone

    def __len__(self) -> int:
        return len(self.times) - 1

    @property
    def step(self) -> float:  # [s]
        return float(self.times[1] - self.times[0])

    def times_of(self, read: Readings) -> np.ndarray:
        return np.asarray(self.times[read.step] + read.share * self.step)

    @cached_property
    def order(self) -> np.ndarray:
        return np.argsort(self._steps, kind="stable")

    @cached_property
    def first_readings(self) -> np.ndarray:  # (n + 1,)
        return np.searchsorted(self._steps[self.order], np.arange(len(self) + 1))

    def by_signal(self, ordered: np.ndarray) -> dict[str, np.ndarray]:
        values, ends = np.empty_like(ordered), np.cumsum([len(read.values) for read in self.readings.values()])
        values[self.order] = ordered
        return dict(zip(self.readings, np.split(values, ends[:-1]), strict=True))

    @cached_property
    def _steps(self) -> np.ndarray:
        return np.concatenate([read.step for read in self.readings.values()])


def grid_of(record: ShipRecord, step: float, usual: Mapping[str, float], pilot: bool = False) -> RecordGrid:
    """Return a record on even times; with a pilot the rudder at the end of each step is a reading too."""
    # step [s]
    # Values closer than a step are averaged over it; coarser ones keep their times.
    read = {name: record[name] for name in READ if name in record and len(record[name])}
    moved = {name: record[name] for name in usual if name in record and len(record[name])}
    if not read:
        raise InputError(f"record {record.name} holds nothing of the ship's motion; give x, y, psi or r")
    begun = max(min(s.t.min() for s in read.values()), max((s.t.min() for s in moved.values()), default=-np.inf))
    ended = min(max(s.t.max() for s in read.values()), min((s.t.max() for s in moved.values()), default=np.inf))
    count = int((ended - begun) / step + 1e-9)
    if count < FEWEST_STEPS:
        raise InputError(f"record {record.name} lasts {ended - begun:.0f} s, too short to learn from; leave it out")
    times = begun + step * np.arange(count + 1)
    positions = {
        name: _at_nodes(moved[name], times) if name in moved else np.full(count + 1, at) for name, at in usual.items()
    }
    whole = ~_meetings(record, times)
    for signal in moved.values():
        for i in np.flatnonzero(np.diff(signal.t) > max(GAP * signal.step, step)):
            low, high = np.searchsorted(times, signal.t[i : i + 2])
            whole[max(low - 1, 0) : high] = False
    if not whole.any():
        raise InputError(f"record {record.name} consists of marked meetings and gaps of the rudder; leave it out")
    readings = {name: _readings(name, signal, times, whole) for name, signal in read.items()}
    if pilot and RUDDER in moved:
        at = np.flatnonzero(whole)
        readings[HELM] = Readings(positions[RUDDER][at + 1], at, np.full(len(at), 0.5), np.ones(len(at)))
    return RecordGrid(record, times, whole, positions, readings)


def _at_nodes(signal: Signal, times: np.ndarray) -> np.ndarray:
    """Positions at the nodes: straight between values where these are coarser, else weighed by a hat."""
    # Hat functions, 1 at a node and 0 at its neighbours, use every value and preserve the integral of the rudder.
    from scipy.interpolate import make_interp_spline

    step = times[1] - times[0]
    if signal.step >= step:
        return np.asarray(np.interp(times, signal.t, signal.values))
    ends = (min(times[0], signal.t[0]) - 2 * step, max(times[-1], signal.t[-1]) + 2 * step)
    t, values = np.concatenate([ends[:1], signal.t, ends[1:]]), np.pad(signal.values, 1, mode="edge")
    twice = make_interp_spline(t, values, k=1).antiderivative(2)
    return np.asarray((twice(times - step) - 2 * twice(times) + twice(times + step)) / step**2)


def _meetings(record: ShipRecord, edges: np.ndarray) -> np.ndarray:
    """Return whether another ship passes at any time of a step; each value holds until the next."""
    if MEETING not in record or not len(record[MEETING]):
        return np.zeros(len(edges) - 1, bool)
    signal = record[MEETING]
    met, begun = signal.values > 0.5, np.searchsorted(signal.t, edges[:-1], side="right") - 1
    inside = np.searchsorted(edges, signal.t[met], side="right") - 1
    return ((begun >= 0) & met[begun]) | np.isin(np.arange(len(edges) - 1), inside)


def _readings(name: str, signal: Signal, times: np.ndarray, whole: np.ndarray) -> Readings:
    step, steps = times[1] - times[0], len(times) - 1
    values = np.unwrap(signal.values) if name in TURNING else signal.values
    inside = (signal.t >= times[0]) & (signal.t < times[-1])
    t, values = signal.t[inside], values[inside]
    counted = np.ones(len(t))
    if signal.step <= step / 2:
        place = np.minimum(((t - times[0]) / step).astype(int), steps - 1)
        number = np.bincount(place, minlength=steps)
        filled = number > 0
        counted = number[filled].astype(float)
        t, values = (np.bincount(place, column, minlength=steps)[filled] / counted for column in (t, values))
    position = (t - times[0]) / step
    before = np.minimum(position.astype(int), steps - 1)
    kept = whole[before]
    return Readings(values[kept], before[kept], (position - before)[kept], counted[kept])


def first_guess(grid: RecordGrid, waterway: Waterway | None) -> np.ndarray:
    """Return the states at the start of each step, smoothed from the readings alone, (n, 6)."""
    from scipy.ndimage import median_filter
    from scipy.signal import savgol_filter

    seen, wide = dict[str, np.ndarray](), min(NODES, len(grid.times) // 2 * 2 - 1)
    for name, read in grid.readings.items():
        if len(read.values):  # Means of a few nodes, spikes cut off
            column = np.interp(grid.times, grid.times_of(read), median_filter(read.values, SPIKES, mode="nearest"))
            seen[name] = savgol_filter(column, wide, 1)
    x, y = (seen.get(name, np.zeros(len(grid.times))) for name in ("x", "y"))
    along, across = np.gradient(x, grid.times), np.gradient(y, grid.times)
    # Curvature of the waterway's line, to which the heading is relative
    bend = 0.0 if waterway is None else waterway.section(np.clip(x, 0.0, waterway.line.length)).curvature
    psi = seen["psi"] if "psi" in seen else np.unwrap(np.arctan2(across, along))
    cosine, sine = np.cos(psi), np.sin(psi)
    guessed = {
        "u": along * cosine + across * sine,
        "v": across * cosine - along * sine,
        "r": np.gradient(psi, grid.times) + along * bend,
    }
    for name, others in (("u", ("u", "u_ground", "speed_over_ground")), ("v", ("v", "v_ground")), ("r", ("r",))):
        guessed[name] = next((seen[other] for other in others if other in seen), guessed[name])
    return np.stack([x, y, psi, *guessed.values()], axis=1)[:-1]
