"""Runs that a towing tank can make, as motions: harmonic sway and yaw, and straight runs off the centreline."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from narrows.errors import InputError

Columns = dict[str, np.ndarray]


class Run(Protocol):
    """What a twin and a design ask of a run."""

    @property
    def name(self) -> str:
        """Of the test."""

    @property
    def depth(self) -> float | None:
        """Of the water [m]; the canal's own where None."""

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""

    @property
    def length(self) -> float:
        """How much of the tank it takes, about [m]."""

    def columns(self, rate: float) -> Columns:
        """Return time, motion and accelerations at each sample.

        rate [Hz]
        """


def _check_positive(run: "HarmonicRun | StraightRun", names: tuple[str, ...]) -> None:
    for name in names:
        if not getattr(run, name) > 0:
            raise InputError(f"run {run.name}: {name} = {getattr(run, name)} must be positive")


@dataclass(frozen=True)
class HarmonicRun:
    """A harmonic captive test at constant speed.

    Parameters
    ----------
    name : str
        Of the test.
    kind : str
        ``yaw``: along a sinusoidal path without drift; ``sway``: sideways without yaw.
    amplitude : float [m]
        Of y.
    period : float [s]
        Of one cycle.
    speed : float [m/s]
        Surge velocity.
    cycles : int
        How many.
    offset : float [m]
        Of the path's mean line, to starboard of the centreline.
    depth : float [m], optional
        Of the water; the canal's own unless given.

    Raises
    ------
    InputError
        Where the kind is unknown, a number is not positive, or a yaw path is steeper than the speed allows.
    """

    name: str
    kind: str
    amplitude: float
    period: float
    speed: float = 1.0
    cycles: int = 6
    offset: float = 0.0
    depth: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in ("yaw", "sway"):
            raise InputError(f"run {self.name}: kind {self.kind!r} is unknown; choose yaw or sway")
        _check_positive(self, ("amplitude", "period", "speed", "cycles"))
        if self.kind == "yaw" and self.amplitude * 2 * np.pi / self.period >= self.speed:
            raise InputError(f"run {self.name}: too steep for {self.speed} m/s; lengthen the period")

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.cycles * self.period

    @property
    def length(self) -> float:
        """How much of the tank it takes, about [m]."""
        return self.duration * self.speed

    def columns(self, rate: float) -> Columns:
        """Return time, motion and accelerations at each sample.

        Parameters
        ----------
        rate : float [Hz]
            Of sampling.
        """
        t = np.arange(round(self.duration * rate)) / rate
        columns = self._yaw(t) if self.kind == "yaw" else self._sway(t)
        return columns | {"y": self.offset + columns["y"], "heave": np.zeros(len(t))}

    def _yaw(self, t: np.ndarray) -> Columns:
        """y = A sin wt along the ship's own path: sin psi = y'/U, so that v = 0 exactly."""
        w, a, speed = 2 * np.pi / self.period, self.amplitude, np.full(len(t), self.speed)
        slope, bend, jerk = (a * w**n / self.speed * _wave(w * t, n) for n in (1, 2, 3))
        cosine = np.sqrt(1 - slope**2)
        psi, r = np.arcsin(slope), bend / cosine
        rdot = jerk / cosine + slope * bend**2 / cosine**3
        x = np.concatenate([[0.0], np.cumsum(self.speed * (cosine[1:] + cosine[:-1]) / 2 * np.diff(t))])
        zero = np.zeros(len(t))
        return {
            "t": t, "x": x, "y": a * np.sin(w * t), "psi": psi, "u": speed, "v": zero, "r": r,
            "udot": zero, "vdot": zero, "rdot": rdot,
        }  # fmt: skip

    def _sway(self, t: np.ndarray) -> Columns:
        w, a, zero = 2 * np.pi / self.period, self.amplitude, np.zeros(len(t))
        return {
            "t": t, "x": self.speed * t, "y": a * np.sin(w * t), "psi": zero, "u": np.full(len(t), self.speed),
            "v": a * w * np.cos(w * t), "r": zero, "udot": zero, "vdot": -a * w * w * np.sin(w * t), "rdot": zero,
        }  # fmt: skip


def _wave(phase: np.ndarray, derivative: int) -> np.ndarray:
    """The n-th derivative of the sine."""
    return np.asarray(np.sin(phase + derivative * np.pi / 2))


@dataclass(frozen=True)
class StraightRun:
    """A straight captive test at constant speed, parallel to the banks.

    Parameters
    ----------
    name : str
        Of the test.
    offset : float [m]
        To starboard of the centreline.
    speed : float [m/s]
        Along the canal.
    duration : float [s]
        How long it lasts.
    drift : float [rad]
        Angle from the path to the bow, positive to starboard; the heading, as the path is along the canal.
    depth : float [m], optional
        Of the water; the canal's own unless given.

    Raises
    ------
    InputError
        Where speed or duration are not positive, or it is towed sideways.
    """

    name: str
    offset: float
    speed: float = 1.0
    duration: float = 40.0
    drift: float = 0.0
    depth: float | None = None

    def __post_init__(self) -> None:
        _check_positive(self, ("speed", "duration"))
        if not abs(self.drift) < np.pi / 2:
            raise InputError(f"run {self.name}: drift = {self.drift} is not an angle below pi/2; give it in radians")

    @property
    def length(self) -> float:
        """How much of the tank it takes, about [m]."""
        return self.duration * self.speed

    def columns(self, rate: float) -> Columns:
        """Return time, motion and accelerations at each sample.

        Parameters
        ----------
        rate : float [Hz]
            Of sampling.
        """
        t = np.arange(round(self.duration * rate)) / rate
        zero, one = np.zeros(len(t)), np.ones(len(t))
        return {
            "t": t, "x": self.speed * t, "y": self.offset * one, "psi": self.drift * one,
            "u": self.speed * np.cos(self.drift) * one, "v": -self.speed * np.sin(self.drift) * one, "r": zero,
            "udot": zero, "vdot": zero, "rdot": zero, "heave": zero,
        }  # fmt: skip
