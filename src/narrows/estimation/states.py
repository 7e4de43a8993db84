"""The estimated states: pose, velocities and disturbances, with units; the estimate at a moment and over time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.results import BaseSummary, Tabulated, with_error
from narrows.estimation.settings import REFERENCE_LENGTH
from narrows.ship.checks import check_sizes

if TYPE_CHECKING:
    import pandas as pd
    import xarray

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


class Gaussian(NamedTuple):
    mean: np.ndarray  # (n,) Mean
    root: np.ndarray  # (n, k) Root of the covariance, lower triangular

    @property
    def covariance(self) -> np.ndarray:
        return np.asarray(self.root @ self.root.T)


MOTIONS = {"surge": "u", "sway": "v", "yaw": "r"}  # States of the motions whose walks are given
RESTING = {**dict.fromkeys(STATES, 0.0), "bank": 1.0}  # Values of states that are omitted or unknown


@dataclass(frozen=True)
class StateNames:
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
    """States at many points, one column each, for sensors; the default of a state that is omitted."""

    def __init__(self, points: np.ndarray, names: StateNames, curvature: float = 0.0) -> None:
        self.__dict__.update(RESTING, curvature=curvature)
        self.__dict__.update(zip(names.names, points.T, strict=False))

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


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

    def after(self, values: np.ndarray, duration: float, random: np.random.Generator) -> np.ndarray:  # (..., n)
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


@accept_aliases
@dataclass(frozen=True)
class ProcessNoise(ScaledNoise):
    """Random walks added to the model: standard deviations after one second."""

    surge: float = 0.005  #: Walk of the surge velocity: gusts, waves, squat, effects that the terms ignore [m/s]
    sway: float = 0.003  #: Walk of the sway velocity [m/s]
    yaw: float = 1.5e-5  #: Walk of the yaw rate [rad/s]
    bank: float = 0.01  #: Walk of the bank's strength: real banks differ from the drawn ones [1]
    current: float = 0.002  #: Walk of the current along [m/s]
    current_across: float = 0.003  #: Walk of that across; 0 with a prior of 0 omits that state [m/s]
    rudder_bias: float = 1e-5  #: Walk of the bias of the rudder's indicator [rad]
    POWERS: ClassVar = {
        "surge": 0.25, "sway": 0.25, "yaw": -0.75, "bank": -0.25, "current": 0.25, "current_across": 0.25,
        "rudder_bias": -0.25,
    }  # fmt: skip

    def by_state(self) -> dict[str, float]:
        walks = {MOTIONS.get(name, name): walk for name, walk in vars(self).items()}
        return {"x": 0.0, "y": 0.0, "psi": 0.0, **walks}


@accept_aliases
@dataclass(frozen=True)
class Prior(ScaledNoise):
    """Uncertainty before any measurement: standard deviations about the defaults and the model.

    Position, heading and speed come from the first readings; biases of sensors are defined with the sensors.
    """

    sway: float = 0.15  #: Sway velocity about 0 [m/s]
    yaw_rate: float = 5e-4  #: Yaw rate about 0, if no sensor measures it [rad/s]
    bank: float = 0.2  #: The bank's strength about 1, the model's [1]
    current: float = 0.3  #: Current along, about the waterway's [m/s]
    current_across: float = 0.05  #: Current across, about 0 [m/s]
    POWERS: ClassVar = {"sway": 0.5, "yaw_rate": -0.5, "bank": 0.0, "current": 0.5, "current_across": 0.5}


@dataclass(frozen=True, repr=False, eq=False)
class Estimate(BaseSummary):
    """The state of a ship at a moment."""

    t: float  # Time [s]
    states: StateNames
    # Mean and root of the covariance, with corrections of the coefficients after the states; none before the start
    joint: Gaussian | None
    ready: bool  # True while it follows the readings: false before the start, and from a reset to the next start
    nis: dict[str, float]  # Normalised innovation squared of each reading [1]
    refused: tuple[str, ...] = ()  # Sensors with a reading too far from the prediction
    suspects: tuple[str, ...] = ()  # Sensors whose innovations are biased, or that are left out
    notes: tuple[str, ...] = ()  # Notes, one sentence each
    faults: tuple[str, ...] = ()  # Sensors, ``rudder`` or ``model`` that contradict the others and are left out

    @property
    def normal(self) -> Gaussian | None:
        """Mean and root of the covariance of the states; none before the start."""
        size = len(self.states)
        return Gaussian(self.joint.mean[:size], self.joint.root[:size]) if self.joint else None

    @property
    def values(self) -> dict[str, float]:
        """The state by name, SI units; empty before the start. The heading lies within half a turn."""
        if self.normal is None:
            return {}
        values = dict(zip(self.states.names, self.normal.mean.tolist(), strict=True))
        return {**values, "psi": math.remainder(values["psi"], 2.0 * math.pi)}

    @property
    def std(self) -> dict[str, float]:
        """Standard deviations by name."""
        if self.normal is None:
            return {}
        sizes = np.sqrt((self.normal.root**2).sum(axis=1))
        return dict(zip(self.states.names, sizes.tolist(), strict=True))

    @property
    def covariance(self) -> np.ndarray:
        """The covariance, (states, states); empty before the start."""
        return np.zeros((0, 0)) if self.normal is None else self.normal.covariance

    def __getitem__(self, name: str) -> float:
        """A state by its name."""
        return self.values[name]

    def summary(self) -> str:
        if self.normal is None:
            return f"t = {self.t:g} s: nothing to start from yet."
        values, std = self.values, self.std
        shown = {name: with_error(values[name], 1.96 * std[name]) for name in ("x", "y", "psi", "u")}
        parts = [f"{name} = {value} {described(name)[0]}" for name, value in shown.items()]
        return "\n".join([f"t = {self.t:g} s: {', '.join(parts)} (95 %).", *self.notes])


@dataclass(frozen=True, repr=False, eq=False)
class EstimatedTrack(Tabulated):
    """States of a ship over time."""

    t: np.ndarray  # (times,) Time [s]
    mean: np.ndarray  # (times, states) Estimates
    covariance: np.ndarray  # (times, states, states) Covariances of their errors
    states: tuple[str, ...]
    ready: np.ndarray  # (times,) True if the estimate followed the readings
    refused: dict[str, np.ndarray]  # (times,) True if a reading of the sensor was refused
    suspected: dict[str, np.ndarray]  # (times,) True if the innovations of the sensor were biased
    smoothed: bool  # True if later readings are used too
    notes: tuple[str, ...]  # Notes on validity

    @property
    def std(self) -> np.ndarray:
        """Standard deviations, (times, states)."""
        return np.asarray(np.sqrt(np.maximum(np.diagonal(self.covariance, axis1=1, axis2=2), 0.0)))

    def __getitem__(self, name: str) -> np.ndarray:
        """The estimates of a state."""
        return np.asarray(self.mean[:, self.states.index(name)])

    @property
    def _median_std(self) -> dict[str, float]:
        return dict(zip(self.states, np.median(self.std, axis=0).tolist(), strict=True))

    def summary(self) -> str:
        std, by = self._median_std, "all readings" if self.smoothed else "the readings until then"
        lines = [
            f"{len(self.t)} times from {self.t[0]:g} to {self.t[-1]:g} s, each by {by}; the offset is known to "
            f"{1.96 * std['y']:.2g} m (95 %), the heading to {np.degrees(1.96 * std['psi']):.2g} deg."
        ]
        for what, flags in (("refused", self.refused), ("suspected of drifting", self.suspected)):
            counts = {name: int(flag.sum()) for name, flag in flags.items() if flag.any()}
            lines += [f"{name} was {what} at {count} of them." for name, count in counts.items()]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        counts = {"times": len(self.t), "ready": int(self.ready.sum()), "smoothed": self.smoothed}
        flags = {"refused": self.refused, "suspected": self.suspected}
        flagged = {what: {name: int(flag.sum()) for name, flag in by.items()} for what, by in flags.items()}
        words = {"summary": self.summary(), "notes": list(self.notes)}
        return {"median_std": self._median_std, **counts, **flagged, **words}

    def to_dataframe(self) -> "pd.DataFrame":
        """Return one row per time: states and their standard deviations."""
        frame: pd.DataFrame = self.dataset().drop_dims("other").drop_vars("state").to_dataframe()
        return frame

    def dataset(self) -> "xarray.Dataset":
        """Return states, standard deviations, the covariance and the verdict on the sensors, with units."""
        import xarray

        std = self.std
        data: dict[str, Any] = {}
        for place, name in enumerate(self.states):
            unit, meaning = described(name)
            data[name] = ("t", self.mean[:, place], {"units": unit, "long_name": meaning})
            data[f"{name}_std"] = ("t", std[:, place], {"units": unit, "long_name": f"standard deviation of {meaning}"})
        data["ready"] = ("t", self.ready.astype(np.int8), {"units": "1", "long_name": "follows the readings"})
        for what, flags in (("refused", self.refused), ("suspected", self.suspected)):
            data |= {f"{name}_{what}": ("t", flag.astype(np.int8), {"units": "1"}) for name, flag in flags.items()}
        data["covariance"] = (("t", "state", "other"), self.covariance, {"units": "product of those of the states"})
        coordinates: dict[str, Any] = {name: list(self.states) for name in ("state", "other")}
        coordinates["t"] = "t", self.t, {"units": "s", "long_name": "time"}
        return xarray.Dataset(data, coordinates, {"summary": self.summary(), "notes": "\n".join(self.notes)})
