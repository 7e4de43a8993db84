"""Predict each signal of a record from the state of a ship, with its slopes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from narrows.results.base_results import BaseSummary
from narrows.simulation.controllers import Named

# The current along the axes [m/s], which enters what is told over ground.
CURRENT_X, CURRENT_Y = "current_x", "current_y"

# The actuator that is read with a zero of its own, and how much farther to starboard it truly is [rad].
RUDDER, RUDDER_OFFSET = "rudder", "rudder_offset"

# Name of the constant error of a signal.
ERROR = "{}_error".format


class PredictedSignal(NamedTuple):
    """A signal as the state predicts it."""

    value: np.ndarray  # (n,) In the unit of the signal
    by_state: Mapping[int, np.ndarray]  # (n,) Slopes by those of x, y, psi, u, v, r that it depends on
    by_error: Mapping[str, np.ndarray]  # (n,) Slopes by errors of the sensors and by the current


@dataclass(frozen=True)
class SeenStates:
    """States at the times of the readings of a signal."""

    states: np.ndarray  # (n, 6) x, y, psi, u, v, r
    errors: Mapping[str, np.ndarray | float]  # (n,) Errors of the sensors, and the current; 0 where nothing is said
    antenna: tuple[float, float]  # Forward and to starboard of midship [m]
    rudder: np.ndarray  # (n,) At the start of the step [rad]

    def error(self, name: str) -> np.ndarray | float:
        """Return an error, 0 where nothing is said of it."""
        return self.errors.get(name, 0.0)


ONE = np.ones(1)

Predicting = Callable[[SeenStates], PredictedSignal]


def _x(at: SeenStates) -> PredictedSignal:
    cosine, sine = np.cos(at.states[:, 2]), np.sin(at.states[:, 2])
    forward, starboard = at.antenna
    value = at.states[:, 0] + forward * cosine - starboard * sine
    by_state = {0: ONE, 2: -forward * sine - starboard * cosine}
    return PredictedSignal(value + at.error(ERROR("x")), by_state, {ERROR("x"): ONE})


def _y(at: SeenStates) -> PredictedSignal:
    cosine, sine = np.cos(at.states[:, 2]), np.sin(at.states[:, 2])
    forward, starboard = at.antenna
    value = at.states[:, 1] + forward * sine + starboard * cosine
    by_state = {1: ONE, 2: forward * cosine - starboard * sine}
    return PredictedSignal(value + at.error(ERROR("y")), by_state, {ERROR("y"): ONE})


def _state(name: str, column: int) -> Predicting:
    """A signal that is a state."""
    error = ERROR(name)
    return lambda at: PredictedSignal(at.states[:, column] + at.error(error), {column: ONE}, {error: ONE})


def _over_ground(at: SeenStates) -> tuple[PredictedSignal, PredictedSignal]:
    """Velocities over ground along and across the ship."""
    psi, u, v = at.states[:, 2], at.states[:, 3], at.states[:, 4]
    cosine, sine = np.cos(psi), np.sin(psi)
    x, y = at.error(CURRENT_X), at.error(CURRENT_Y)
    along, across = cosine * x + sine * y, cosine * y - sine * x
    return (
        PredictedSignal(u + along, {2: across, 3: ONE}, {CURRENT_X: cosine, CURRENT_Y: sine}),
        PredictedSignal(v + across, {2: -along, 4: ONE}, {CURRENT_X: -sine, CURRENT_Y: cosine}),
    )


def _of_velocity(place: int, name: str) -> Predicting:
    def predicted(at: SeenStates) -> PredictedSignal:
        return _with_error(_over_ground(at)[place], at, name)

    return predicted


def _speed(at: SeenStates) -> PredictedSignal:
    along, across = _over_ground(at)
    speed = np.maximum(np.hypot(along.value, across.value), 1e-9)
    seen = _combined(speed, along.value / speed, along, across.value / speed, across)
    return _with_error(seen, at, "speed_over_ground")


def _course(at: SeenStates) -> PredictedSignal:
    along, across = _over_ground(at)
    square = np.maximum(along.value**2 + across.value**2, 1e-12)
    value = at.states[:, 2] + np.arctan2(across.value, along.value)
    seen = _combined(value, -across.value / square, along, along.value / square, across)
    turned = PredictedSignal(seen.value, {**seen.by_state, 2: seen.by_state[2] + 1.0}, seen.by_error)
    return _with_error(turned, at, "course")


def _with_error(seen: PredictedSignal, at: SeenStates, name: str) -> PredictedSignal:
    error = ERROR(name)
    return PredictedSignal(seen.value + at.error(error), seen.by_state, {**seen.by_error, error: ONE})


def _combined(
    value: np.ndarray, by_one: np.ndarray, one: PredictedSignal, by_other: np.ndarray, other: PredictedSignal
) -> PredictedSignal:
    """Combine the slopes of a quantity that depends on two signals."""
    none = np.zeros(1)
    state = {i: by_one * one.by_state.get(i, none) + by_other * other.by_state.get(i, none) for i in (2, 3, 4)}
    error = {name: by_one * slope + by_other * other.by_error[name] for name, slope in one.by_error.items()}
    return PredictedSignal(value, state, error)


# A pilot looks out of the window, so that the rudder holds information on the motion that no sensor has: it is one more
# signal. Ljung (1999), System Identification, chapter 13: joint input-output identification of a closed loop.
HELM = "helm"
# What a pilot sees, by its place among the states; and the gain of each, a state of the filter.
SEEN = {"y": 1, "psi": 2, "v": 4, "r": 5}
HELM_GAIN = "helm_by_{}".format


def _helm(at: SeenStates) -> PredictedSignal:
    """The rudder at the end of a step, from where it was and what is seen; the law has a memory, as pilots have."""
    seen = {name: at.states[:, place] for name, place in SEEN.items()} | {RUDDER: at.rudder}
    gains = {name: at.error(HELM_GAIN(name)) for name in seen}
    value = at.rudder + at.error(ERROR(HELM)) + sum(gains[name] * column for name, column in seen.items())
    by_state = {place: np.asarray(gains[name]) for name, place in SEEN.items()}
    return PredictedSignal(
        value, by_state, {HELM_GAIN(name): column for name, column in seen.items()} | {ERROR(HELM): ONE}
    )


# Prediction of each signal of the motion.
PREDICTED: Mapping[str, Predicting] = {
    "x": _x, "y": _y, "psi": _state("psi", 2), "r": _state("r", 5), "u": _state("u", 3), "v": _state("v", 4),
    "u_ground": _of_velocity(0, "u_ground"), "v_ground": _of_velocity(1, "v_ground"),
    "speed_over_ground": _speed, "course": _course, HELM: _helm,
}  # fmt: skip

# A helm that does again what was recorded: actuators go from one recorded position to the next within each step.
# Name in the law of an actuator's position at the end of the step.
RECORDED = "recorded_{}".format

# Limit and rate of what was recorded: it went where it went.
UNLIMITED = 1e9


@dataclass(frozen=True, repr=False)
class RecordedHelm(BaseSummary):
    """A control law that follows recorded positions, straight between the ends of the steps."""

    positions: Mapping[str, float]  # Positions of the recorded actuators, at the start

    def summary(self) -> str:
        """Recorded signals."""
        return f"as recorded: {', '.join(self.positions)}"

    def parameters(self) -> Mapping[str, float]:
        """Return the positions at the end of the step, and how far the rudder's zero is off."""
        offset = {RUDDER_OFFSET: 0.0} if RUDDER in self.positions else {}
        return {RECORDED(name): position for name, position in self.positions.items()} | offset

    def memory(self, start: Named) -> Named:
        """Return nothing: all that it follows is told."""
        return {}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return where the actuators are at the end of the step."""
        orders = {name: getattr(at, RECORDED(name)) for name in self.positions}
        if RUDDER in orders:
            orders[RUDDER] = orders[RUDDER] + at.rudder_offset
        return orders, {}


def unlimited(names: tuple[str, ...]) -> dict[str, float]:
    """Return limits and rates that no record meets, by the names of the lines."""
    return {f"{name}_{end}": UNLIMITED for name in names for end in ("limit", "rate")}
