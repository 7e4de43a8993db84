"""Estimate of an unexplained external force: a constant force and moment, and an error of the bank's strength.

Two filters, one for the force and one for the moment, split the residual. The error of the bank, scaled by the
covariance of the coefficients, grows with the offset and changes sign with it; the constant part does not.
"""

import math
from dataclasses import dataclass

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.control.predictive import plan_loops

Variances = tuple[float, float, float]

# Longest gap between two orders [time constants of the estimate]: keeps its gain below 1.
LONGEST_GAP = 5.0


@dataclass(frozen=True)
class BankSpread:
    """Uncertainty of the bank's force and moment, by the place between the banks."""

    # Range of the table, from the middle, 0, to the wall, 1; constant beyond it
    furthest: float
    # (n, 2) One standard deviation, positive for a stronger suction, at equal steps from port to starboard [N, N m]
    forces: np.ndarray

    def at(self, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return force and moment at places between the banks, and their derivatives, (places, 2) each."""
        step = 2 * self.furthest / (len(self.forces) - 1)
        forces, slopes = compiled_loops(plan_loops).interpolate(self.forces, -self.furthest, step, share)
        return forces, slopes


@dataclass(frozen=True)
class Push:
    steady: np.ndarray  # (2,) Constant sway force and yaw moment [N, N m]
    strength: np.ndarray  # (2,) Excess of the bank's force and moment over the model's [standard deviations]
    spread: BankSpread  # The standard deviations
    # For force and moment: variance of the constant part, of the strength, and their covariance
    uncertainty: tuple[Variances, Variances]
    noise: tuple[float, float]  # Variance of the residual between two steps [N2, N2 m2]

    def at(self, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the force and moment at places between the banks, and their derivative, (places, 2) each [N, N m]."""
        forces, slopes = self.spread.at(share)
        return self.steady + self.strength * forces, self.strength * slopes


def no_push(spread: BankSpread) -> Push:
    """Return the estimate before the first reading."""
    unseen = (0.0, 1.0, 0.0)
    return Push(np.zeros(2), np.zeros(2), spread, (unseen, unseen), (0.0, 0.0))


def updated_push(push: Push, residual: np.ndarray, share: float, elapsed: float, time: float) -> Push:
    """Return the estimate after another residual."""
    # Muske and Badgwell (2002), Disturbance modeling for offset-free linear model predictive control, Journal of
    # Process Control 12(5), 617-632.
    if not np.isfinite(residual).all():
        return push
    gain = -math.expm1(-min(elapsed / time, LONGEST_GAP))
    slope = push.spread.at(np.array([share]))[0][0]
    (force, of_force, noise), (moment, of_moment, moment_noise) = (
        _filtered(*push.uncertainty[axis], push.noise[axis], float(residual[axis]), float(slope[axis]), gain)
        for axis in (0, 1)
    )
    steady, strength = np.array([force, moment]).T
    return Push(
        push.steady + steady, push.strength + strength, push.spread, (of_force, of_moment), (noise, moment_noise)
    )


def _filtered(
    walk: float, constant: float, both: float, noise: float, residual: float, slope: float, gain: float
) -> tuple[tuple[float, float], Variances, float]:
    """Return changes of the constant part and of the strength, their variances, and the noise."""
    # A Kalman filter of a random walk and a constant. The noise is estimated from the residual; the random walk alone
    # would give the filter the requested gain, q = R gain^2 / (1 - gain).
    noise = noise + gain * (residual**2 - noise) if noise else residual**2
    if not noise:
        return (0.0, 0.0), (walk, constant, both), noise
    walk += noise * gain**2 / (1.0 - gain)
    seen = walk + slope * both, both + slope * constant
    total = seen[0] + slope * seen[1] + noise
    weights = seen[0] / total, seen[1] / total
    left = (walk - weights[0] * seen[0], constant - weights[1] * seen[1], both - weights[0] * seen[1])
    return (weights[0] * residual, weights[1] * residual), left, noise
