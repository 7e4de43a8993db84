"""What changes from window to window: first-order processes, constant in each window.

A gust has a memory and the pilot answers it; a reading wanders; what the rudder's indicator misses comes and goes. Each
is a number a window, correlated from window to window by its memory, sway and yaw by one correlation.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

SWAY, YAW = "Y", "N"


@dataclass(frozen=True, eq=False)
class WindowChain:
    """First-order processes, constant in each window."""

    names: tuple[str, ...] = ()  # X, Y or N, as accelerations; ``rudder_offset``; ``y_error``
    # (n,) Standard deviation of each, in the unit of what it adds to
    std: np.ndarray = field(default_factory=lambda: np.zeros(0))
    # (n,) How long each stays; 0 where windows have nothing to do with each other [s]
    memory: np.ndarray = field(default_factory=lambda: np.zeros(0))
    correlation: float = 0.0  # Between the pushes in sway and in yaw [1]

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of one window, (n, n)."""
        matrix = np.diag(self.std**2)
        if SWAY in self.names and YAW in self.names:
            i, j = self.names.index(SWAY), self.names.index(YAW)
            matrix[i, j] = matrix[j, i] = self.correlation * self.std[i] * self.std[j]
        return matrix

    def kept(self, window: float) -> np.ndarray:
        """Return what of each stays from one window to the next, (n,) [1]."""
        # window [s]
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(-window / self.memory))

    def innovations(self, window: float) -> np.ndarray:
        """Return the covariance of what is new in a window, (n, n)."""
        # window [s]
        kept = self.kept(window)
        return np.asarray(self.covariance * (1 - np.outer(kept, kept)))

    def within(self, place: int, steps: int, step: float) -> np.ndarray:
        """Return how a process of unit size strays within a window from its mean there, (steps, steps)."""
        # step [s]
        return _strays(float(self.memory[place]), steps, step)

    def stronger(self, factor: float) -> "WindowChain":
        """Return the chain with stronger pushes."""
        factors = [factor if name in ("X", SWAY, YAW) else 1.0 for name in self.names]
        return WindowChain(self.names, np.array(factors) * self.std, self.memory, self.correlation)

    def with_pushes(self, std: dict[str, float], memory: float, correlation: float) -> "WindowChain":
        """Return the chain with other pushes."""
        # memory [s]
        sizes = np.array([std.get(name, size) for name, size in zip(self.names, self.std, strict=True)])
        stays = np.array([memory if name in std else own for name, own in zip(self.names, self.memory, strict=True)])
        return WindowChain(self.names, sizes, stays, correlation)


@lru_cache(maxsize=64)
def _strays(memory: float, steps: int, step: float) -> np.ndarray:
    """How a process of unit size strays from its mean."""
    about = np.eye(steps) - 1.0 / steps
    if memory == 0:
        return about * steps
    t = step * np.arange(steps)
    return np.asarray(about @ np.exp(-np.abs(t[:, None] - t) / memory) @ about)


MOST_CORRELATION = 0.995


def bounded_correlation(free: float) -> float:
    """Return a correlation of a free number, short of one."""
    return MOST_CORRELATION * math.tanh(free)


def free_correlation(correlation: float) -> float:
    """Return the free number of a correlation."""
    return math.atanh(correlation / MOST_CORRELATION)
