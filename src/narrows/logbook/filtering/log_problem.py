"""Unknowns of a fit to records, with their priors: coefficients, disturbances, errors of sensors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from narrows.logbook.filtering.recorded_motion import RecordedMotion

SWAY, YAW = "Y", "N"
MOST_CORRELATION = 0.995


class Process(NamedTuple):
    """A disturbance or a sensor's error as a first-order Gauss-Markov process."""

    name: str
    adds_to: str  # X, Y, N as accelerations, ``rudder_offset``, ``current_x``, ``psi_error``...
    std: float  # In the unit of what it adds to
    memory: float  # [s]; 0 for white from step to step, infinite for a constant of the record


class Estimated(NamedTuple):
    """A number of the stochastic model that records determine, as a logarithm over its usual value."""

    of: str  # std, memory, noise; or correlation, by its inverse hyperbolic tangent
    names: tuple[str, ...]  # Processes or signals that it belongs to
    spread: float  # Standard deviation before records


@dataclass(frozen=True)
class StochasticModel:
    """Processes, and the white noise of readings."""

    processes: tuple[Process, ...]
    noise: Mapping[str, float]  # Standard deviation of a reading of each signal
    estimated: tuple[Estimated, ...] = ()
    correlation: float = 0.0  # Correlation of gusts in sway and yaw [1]
    gusts: tuple[str, ...] = ()  # Processes that are stronger in meetings

    def at(self, numbers: Sequence[float] | np.ndarray) -> "StochasticModel":
        """Return the model at estimated numbers, each 0 for its usual value."""
        processes, noise, correlation = {one.name: one for one in self.processes}, dict(self.noise), self.correlation
        for (of, names, _), number in zip(self.estimated, np.asarray(numbers).tolist(), strict=True):
            if of == "correlation":
                correlation = MOST_CORRELATION * math.tanh(number)
            factor = math.exp(np.clip(number, -20.0, 20.0))
            for name in names:
                if of == "noise":
                    noise[name] *= factor
                elif of in ("std", "memory"):
                    processes[name] = processes[name]._replace(**{of: getattr(processes[name], of) * factor})
        return replace(self, processes=tuple(processes.values()), noise=noise, correlation=correlation)

    def covariance(self, stronger: float = 1.0) -> np.ndarray:
        """Return the stationary covariance of the processes, with stronger gusts, (m, m)."""
        std = np.array([one.std * (stronger if one.name in self.gusts else 1.0) for one in self.processes])
        matrix, names = np.diag(std**2), [one.name for one in self.processes]
        if SWAY in names and YAW in names:
            i, j = names.index(SWAY), names.index(YAW)
            matrix[i, j] = matrix[j, i] = self.correlation * std[i] * std[j]
        return matrix

    def kept(self, step: float) -> np.ndarray:
        """Return the share of each process that remains after a step, (m,) [1]."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(-step / np.array([one.memory for one in self.processes])))


@dataclass(frozen=True)
class CoefficientPrior:
    """Normal prior of the coefficients, in units of their standard deviations."""

    groups: tuple[tuple[str, ...], ...]  # Coefficients that are estimated; those of a group are one
    mean: np.ndarray  # (p,) Mean of each group, in its own unit
    scale: np.ndarray  # (p,) Its standard deviation
    precision: np.ndarray  # (p, p) Inverse of the correlation [1]
    bounds: np.ndarray  # (p, 2) Lowest and highest value, in its own unit
    free: np.ndarray  # (p,) Which may change; the others keep mean and covariance

    @property
    def members(self) -> tuple[str, ...]:
        """Every coefficient of every group."""
        return tuple(name for group in self.groups for name in group)

    @property
    def names(self) -> tuple[str, ...]:
        """The first of each group."""
        return tuple(group[0] for group in self.groups)

    @property
    def free_names(self) -> set[str]:
        """Every coefficient that may change."""
        return {name for group, free in zip(self.groups, self.free, strict=True) if free for name in group}

    def values(self, scaled: np.ndarray) -> dict[str, float]:
        """Return every coefficient by name, from scaled (p,)."""
        numbers = (self.mean + self.scale * scaled).tolist()
        return {name: value for group, value in zip(self.groups, numbers, strict=True) for name in group}

    @property
    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest in units of the standard deviations."""
        low, high = ((end - self.mean) / self.scale for end in self.bounds.T)
        return low, high


class Unknowns:
    """Scaled coefficients with their prior, then numbers with independent normal priors of mean 0."""

    prior: CoefficientPrior

    @property
    def spreads(self) -> np.ndarray:
        """Prior standard deviations of these numbers."""
        raise NotImplementedError

    @property
    def count(self) -> int:
        """Number of coefficients."""
        return len(self.prior.groups)

    @cached_property
    def precision(self) -> np.ndarray:
        """Prior precision, (P, P)."""
        matrix = np.diag(np.concatenate([np.zeros(self.count), self.spreads**-2.0]))
        matrix[: self.count, : self.count] = self.prior.precision
        return matrix


@dataclass(frozen=True)
class LogProblem(Unknowns):
    """Unknowns of a fit to records, and how the ship moves."""

    motion: RecordedMotion  # How the ship moves under its recorded rudder
    prior: CoefficientPrior
    # (3, 1 + p) Inertia in surge, sway and yaw: its constant part [kg, kg, kg m2], then slopes by the coefficients.
    # Disturbances are accelerations: motion determines forces over inertia, so that with a disturbance in newtons the
    # strength of gusts would fix what only mass can.
    inertia: np.ndarray
    model: StochasticModel
    correlated: float = 1.0  # Readings for each independent one
    # Standard deviation of a step over ship lengths and speeds, for rounding alone. At 1e-5 the filter follows a
    # position that is measured to millimetres instead of the model, and the estimated noise vanishes.
    walk: float = 1e-7

    @property
    def spreads(self) -> np.ndarray:
        """Prior standard deviations of the estimated numbers of the stochastic model."""
        return np.array([one.spread for one in self.model.estimated])

    @cached_property
    def scales(self) -> np.ndarray:
        """Scales of the ship's states: length, length, radian, speed, speed, speed over length, (6,)."""
        length, u = self.motion.model.configuration.ship.length, float(self.motion.choices["u"])
        return np.array([length, length, 1.0, u, u, u / length])

    @property
    def speed_is_held(self) -> bool:
        """Whether the motion holds the speed."""
        return self.motion.integrator.ship.surge == "held"

    def model_at(self, unknowns: np.ndarray) -> StochasticModel:
        """Return the stochastic model at unknowns (P,)."""
        return self.model.at(unknowns[self.count :])

    def at(self, scaled: np.ndarray) -> tuple[RecordedMotion, np.ndarray]:
        """Return the motion and the inertia at scaled coefficients (p,)."""
        key = scaled.tobytes()
        if key not in self._last:  # A motion is prepared once for all passes at the same coefficients.
            self._last.clear()
            motion = self.motion.with_coefficients(self.prior.values(scaled))
            self._last[key] = motion, self.inertia @ [1.0, *(self.prior.mean + self.prior.scale * scaled)]
        return self._last[key]

    @cached_property
    def _last(self) -> dict[bytes, tuple[RecordedMotion, np.ndarray]]:
        return {}
