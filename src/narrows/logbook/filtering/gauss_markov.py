"""Disturbances and sensor errors as first-order Gauss-Markov processes, and what of them is estimated."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

SWAY, YAW = "Y", "N"
MOST_CORRELATION = 0.995


class Process(NamedTuple):
    """A first-order Gauss-Markov process."""

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
    gusts: tuple[str, ...] = field(default=())  # Processes that are stronger in meetings

    @property
    def spreads(self) -> np.ndarray:
        """Standard deviations of the estimated numbers before records."""
        return np.array([one.spread for one in self.estimated])

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
        """Return what of each process is kept over a step, (m,) [1]."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(-step / np.array([one.memory for one in self.processes])))
