"""The estimated states: pose, velocities and disturbances, with units."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from narrows.estimation.settings import REFERENCE_LENGTH
from narrows.ship.checks import check_sizes

MOTION_STATES = ("x", "y", "psi", "u", "v", "r")

# Units and meanings; states after the motion are omitted if nothing makes them deviate from their defaults. Errors
# declared by sensors follow these.
STATES = {
    "x": ("m", "midship along the canal"),
    "y": ("m", "midship to starboard of the line"),
    "psi": ("rad", "heading"),
    "u": ("m/s", "surge velocity through the water"),
    "v": ("m/s", "sway velocity through the water"),
    "r": ("rad/s", "yaw rate"),
    "bank": ("1", "strength of the bank over the model's"),
    "current": ("m/s", "current along the canal"),
    "current_across": ("m/s", "current to starboard of the canal"),
    "rudder_bias": ("rad", "rudder angle over the indicated one"),
}


def described(name: str) -> tuple[str, str]:
    """Return unit and meaning of a state; the error of a sensor has the SI unit of its reading."""
    return STATES.get(name, ("SI", f"error of a sensor, {name.replace('_', ' ')}"))


MOTIONS = {"surge": "u", "sway": "v", "yaw": "r"}  # States of the motions whose walks are given
RESTING = {"bank": 1.0}  # Default values of states that are omitted or unknown; the others are 0


@dataclass(frozen=True)
class StateNames:
    """The states of one estimator, in order."""

    names: tuple[str, ...]  # States of the motion first, then some of ``STATES`` and errors of sensors

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def places(self) -> dict[str, int]:
        return {name: place for place, name in enumerate(self.names)}

    def vector(self, values: dict[str, float]) -> np.ndarray:
        """Return numbers by name as a vector; missing ones have their defaults."""
        return np.array([float(values.get(name, RESTING.get(name, 0.0))) for name in self.names])


class Columns:
    """States at many points, one column each, for sensors."""

    bank: np.ndarray | float = 1.0
    current: np.ndarray | float = 0.0
    current_across: np.ndarray | float = 0.0
    rudder_bias: np.ndarray | float = 0.0
    x: np.ndarray
    y: np.ndarray
    psi: np.ndarray
    u: np.ndarray
    v: np.ndarray
    r: np.ndarray

    def __init__(self, points: np.ndarray, names: StateNames, curvature: float = 0.0) -> None:
        self.__dict__.update(zip(names.names, points.T, strict=False))
        self.curvature = curvature


class MarkovProcess:
    """First-order Gauss-Markov processes; random walks if the time is infinite."""

    def __init__(self, walks: np.ndarray, times: np.ndarray, opposed: Sequence[tuple[int, int]] = ()) -> None:
        self.walks, self.times = walks, times  # (n,) Random walks per root second; correlation times [s]
        self.opposed = opposed  # Pairs of places: the walk of the first enters the second with the other sign
        self._rows = np.flatnonzero(walks > 0.0)
        self._over: dict[float, tuple[np.ndarray, np.ndarray]] = {}

    def over(self, duration: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the remaining share of the states after a time (n,), and a root of the noise, (j, n)."""
        if duration not in self._over:
            if len(self._over) > 64:
                self._over.clear()
            share, slow = duration / self.times, np.isfinite(self.times)
            grown = np.full(len(share), duration)
            grown[slow] = -np.expm1(-2.0 * share[slow]) * self.times[slow] / 2.0
            noise = np.zeros((len(self._rows), len(self.walks)))
            noise[np.arange(len(self._rows)), self._rows] = (self.walks * np.sqrt(grown))[self._rows]
            for one, other in self.opposed:
                noise[self._rows == one, other] = -noise[self._rows == one, one]
            self._over[duration] = np.exp(-share), noise
        return self._over[duration]

    def after(self, values: np.ndarray, duration: float, random: np.random.Generator) -> np.ndarray:
        """Draw the values after a time, (..., n)."""
        left, noise = self.over(duration)
        return np.asarray(values * left + random.standard_normal((*values.shape[:-1], len(noise))) @ noise)


class ScaledNoise:
    """Standard deviations for a ship of 230 m; Froude's law gives those of another length."""

    POWERS: ClassVar[dict[str, float]]  # Powers of the ratio of the lengths

    def __post_init__(self) -> None:
        check_sizes(self)

    @classmethod
    def of_length(cls, length: float) -> Self:
        """Return the defaults for a ship of a length [m], by Froude's law from one of 230 m."""
        scale = length / REFERENCE_LENGTH
        return cls(**{name: getattr(cls, name) * scale**power for name, power in cls.POWERS.items()})


@dataclass(frozen=True)
class ProcessNoise(ScaledNoise):
    """Random walks added to the model: standard deviations after one second.

    Parameters
    ----------
    surge, sway, yaw : float [m/s, m/s, rad/s per root s]
        Walks of the velocities: gusts, waves, squat, effects that the terms ignore.
    bank : float [1 per root s]
        Walk of the bank's strength: real banks differ from the drawn ones.
    current, current_across : float [m/s per root s]
        Walks of the current; across, 0 with a prior of 0 omits that state.
    rudder_bias : float [rad per root s]
        Walk of the bias of the rudder's indicator.
    """

    surge: float = 0.005
    sway: float = 0.003
    yaw: float = 1.5e-5
    bank: float = 0.01
    current: float = 0.002
    current_across: float = 0.003
    rudder_bias: float = 1e-5
    POWERS: ClassVar = {
        "surge": 0.25, "sway": 0.25, "yaw": -0.75, "bank": -0.25, "current": 0.25, "current_across": 0.25,
        "rudder_bias": -0.25,
    }  # fmt: skip

    def by_state(self) -> dict[str, float]:
        walks = {MOTIONS.get(name, name): walk for name, walk in vars(self).items()}
        return {"x": 0.0, "y": 0.0, "psi": 0.0, **walks}


@dataclass(frozen=True)
class Prior(ScaledNoise):
    """Uncertainty before any measurement: standard deviations about the defaults and the model.

    Position, heading and speed come from the first readings; biases of sensors are defined with the sensors.

    Parameters
    ----------
    sway : float [m/s]
        Sway velocity about 0.
    yaw_rate : float [rad/s]
        Yaw rate about 0, if no sensor measures it.
    bank : float [1]
        The bank's strength about 1, the model's.
    current, current_across : float [m/s]
        Current, about the waterway's and about 0.
    """

    sway: float = 0.15
    yaw_rate: float = 5e-4
    bank: float = 0.2
    current: float = 0.3
    current_across: float = 0.05
    POWERS: ClassVar = {"sway": 0.5, "yaw_rate": -0.5, "bank": 0.0, "current": 0.5, "current_across": 0.5}
