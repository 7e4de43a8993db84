"""Predict each signal of a record from the state of a ship, with its slopes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

# The current along the axes [m/s], which enters signals over ground.
CURRENT_X, CURRENT_Y = "current_x", "current_y"

# How much an actuator's position is truly above what is recorded or usual: [rad] to starboard, [1/s].
OFFSET = "{}_offset".format
RUDDER, REVOLUTIONS = "rudder", "revolutions"
RUDDER_OFFSET, REVOLUTIONS_OFFSET = OFFSET(RUDDER), OFFSET(REVOLUTIONS)

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
    errors: Mapping[str, np.ndarray]  # (n,) Errors of the sensors, and the current; 0 where nothing is said
    antenna: tuple[float, float]  # Forward and to starboard of midship [m]
    rudder: np.ndarray  # (n,) At the start of the step [rad]

    def error(self, name: str) -> np.ndarray | float:
        return self.errors.get(name, 0.0)


ONE = np.ones(1)

Predicting = Callable[[SeenStates], PredictedSignal]


def _read(name: str, predicting: Predicting) -> Predicting:
    """A signal with its constant error."""
    error = ERROR(name)

    def predicted(at: SeenStates) -> PredictedSignal:
        seen = predicting(at)
        return PredictedSignal(seen.value + at.error(error), seen.by_state, {**seen.by_error, error: ONE})

    return predicted


def _position(axis: int) -> Predicting:
    """The antenna along an axis."""

    def predicted(at: SeenStates) -> PredictedSignal:
        cosine, sine = np.cos(at.states[:, 2]), np.sin(at.states[:, 2])
        ahead, aside = (cosine, sine)[axis], (-sine, cosine)[axis]
        forward, starboard = at.antenna
        value = at.states[:, axis] + forward * ahead + starboard * aside
        return PredictedSignal(value, {axis: ONE, 2: forward * aside - starboard * ahead}, {})

    return predicted


def _state(column: int) -> Predicting:
    return lambda at: PredictedSignal(at.states[:, column], {column: ONE}, {})


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


def _speed(at: SeenStates) -> PredictedSignal:
    along, across = _over_ground(at)
    speed = np.maximum(np.hypot(along.value, across.value), 1e-9)
    return _combined(speed, along.value / speed, along, across.value / speed, across)


def _course(at: SeenStates) -> PredictedSignal:
    along, across = _over_ground(at)
    square = np.maximum(along.value**2 + across.value**2, 1e-12)
    value = at.states[:, 2] + np.arctan2(across.value, along.value)
    seen = _combined(value, -across.value / square, along, along.value / square, across)
    return seen._replace(by_state={**seen.by_state, 2: seen.by_state[2] + 1.0})


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
    by_error = {HELM_GAIN(name): column for name, column in seen.items()}
    return PredictedSignal(value, by_state, {**by_error, ERROR(HELM): ONE})


# Prediction of each signal of the motion.
PREDICTED: Mapping[str, Predicting] = {
    name: _read(name, predicting)
    for name, predicting in {
        "x": _position(0), "y": _position(1), "psi": _state(2), "r": _state(5), "u": _state(3), "v": _state(4),
        "u_ground": lambda at: _over_ground(at)[0], "v_ground": lambda at: _over_ground(at)[1],
        "speed_over_ground": _speed, "course": _course,
    }.items()
} | {HELM: _helm}  # fmt: skip
