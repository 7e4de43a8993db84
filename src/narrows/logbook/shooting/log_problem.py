"""What a fit to records solves for, and what is known before: coefficients, pushes with a memory, errors of sensors."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from narrows.logbook.shooting.push_chain import WindowChain
from narrows.logbook.shooting.recorded_motion import RecordedMotion

# What a push that is the same all through a record is called.
STEADY = "steady_{}".format


@dataclass(frozen=True)
class CoefficientPrior:
    """What is known of the coefficients before: normal, in units of their standard deviations."""

    groups: tuple[tuple[str, ...], ...]  # Coefficients that are solved for; those of a group are one
    mean: np.ndarray  # (p,) Of each group, in its own unit
    scale: np.ndarray  # (p,) Its standard deviation
    precision: np.ndarray  # (p, p) Inverse of the correlation [1]
    bounds: np.ndarray  # (p, 2) Lowest and highest value, in its own unit
    moves: np.ndarray  # (p,) Which may move; that the others may be wrong is allowed for

    @property
    def members(self) -> tuple[str, ...]:
        """Every coefficient of every group."""
        return tuple(name for group in self.groups for name in group)

    @property
    def names(self) -> tuple[str, ...]:
        """The first of each group."""
        return tuple(group[0] for group in self.groups)

    def values(self, scaled: np.ndarray) -> dict[str, float]:
        """Return every coefficient by name."""
        # scaled (p,)
        numbers = (self.mean + self.scale * scaled).tolist()
        return {name: value for group, value in zip(self.groups, numbers, strict=True) for name in group}

    @property
    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest in units of the standard deviations."""
        low, high = ((end - self.mean) / self.scale for end in self.bounds.T)
        return low, high


@dataclass(frozen=True)
class PushInertia:
    """What resists accelerations of surge, sway and yaw: pushes are unknown as accelerations."""

    # Motion tells of forces over inertia, so that with a push in newtons the strength of gusts would fix what only
    # mass can.

    held: np.ndarray  # (3,) The part of it that does not move [kg, kg, kg m2]
    by_coefficient: np.ndarray  # (3, p) How it moves with the coefficients, each in its own unit

    def at(self, values: np.ndarray) -> np.ndarray:
        """Return it at values of the coefficients, (3,)."""
        # values (p,)
        return np.asarray(self.held + self.by_coefficient @ values)


@dataclass(frozen=True)
class LogProblem:
    """What is solved for, with what is known before."""

    motion: RecordedMotion  # How the ship answers
    prior: CoefficientPrior  # Of the coefficients
    inertia: PushInertia  # What pushes are over
    # What changes from window to window: gusts, what the rudder's reading misses, wander of sensors; empty where
    # windows stand alone
    chain: WindowChain = field(default_factory=WindowChain)
    # Instead, while another ship passes: what she does has nothing to do with how strong gusts are
    in_meetings: WindowChain = field(default_factory=WindowChain)
    # Standard deviations of what is the same all through a record: ``rudder_offset``, ``y_error``..., ``current_x``,
    # ``steady_Y``
    zeros: Mapping[str, float] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)  # Standard deviation of a reading of each signal
    linked: bool = False  # Whether a window begins where the one before ends
    outlier: float = 4.0  # Residual over its noise beyond which a reading counts less (Huber) [1]

    @property
    def local(self) -> int:
        """Unknowns of a window: its start, and what of the chain it has."""
        return 6 + len(self.chain.names)

    @cached_property
    def zero_spread(self) -> np.ndarray:
        """Standard deviations of what is the same all through a record, (q,)."""
        return np.array(list(self.zeros.values()))

    def with_noise(self, noise: Mapping[str, float]) -> "LogProblem":
        """Return the problem with other noise of sensors."""
        return replace(self, noise={**self.noise, **noise})

    def at(self, scaled: np.ndarray) -> RecordedMotion:
        """Return the motion at coefficients."""
        # scaled (p,)
        return self.motion.with_coefficients(self.prior.values(scaled))
