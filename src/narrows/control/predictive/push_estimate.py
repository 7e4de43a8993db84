"""The push that a model does not explain: a force and a moment of any kind, and a bank stronger or weaker than thought.

Two filters, one of the force and one of the moment, part what is missing between the two: what a bank may well be off
by, as the covariance of the coefficients has it, grows and turns its side with the offset; the rest stays as it is.
"""

import math
from dataclasses import dataclass

import numpy as np

Variances = tuple[float, float, float]

# Times of the estimate beyond which a gap between two orders counts as no longer [1]: its gain stays below 1.
LONGEST_GAP = 5.0


@dataclass(frozen=True)
class BankSpread:
    """How far the bank's force and moment may be off, by the place between the banks."""

    # Towards a bank, of the way from the middle, 0, to the wall, 1; beyond it they stay as they are there
    furthest: float
    # (n, 2) One standard deviation, with the sign of a stronger suction, at equal steps from port to starboard [N, N
    # m]
    forces: np.ndarray

    def at(self, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return force and moment at places between the banks, and their derivatives, (places, 2) each."""
        last, step = len(self.forces) - 1, 2 * self.furthest / (len(self.forces) - 1)
        position = np.minimum(np.maximum((share + self.furthest) / step, 0.0), last)
        cell = np.minimum(position.astype(int), last - 1)
        start = self.forces[cell]
        rise = self.forces[cell + 1] - start
        within = (np.abs(share) < self.furthest)[:, None]
        return start + (position - cell)[:, None] * rise, rise * within / step


@dataclass(frozen=True)
class Push:
    steady: np.ndarray  # (2,) Sway force and yaw moment of any kind [N, N m]
    strength: np.ndarray  # (2,) Of the bank's force and moment beyond the model's, in standard deviations [1]
    spread: BankSpread  # What a standard deviation is
    # Of force and of moment: the variance of the steady part, that of the strength, and their covariance
    uncertainty: tuple[Variances, Variances]
    noise: tuple[float, float]  # Variance of what is missing from one moment to the next [N2, N2 m2]

    def at(self, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the push at places between the banks, and its derivative, (places, 2) each [N, N m]."""
        forces, slopes = self.spread.at(share)
        return self.steady + self.strength * forces, self.strength * slopes


def no_push(spread: BankSpread) -> Push:
    """Return the push before anything is seen."""
    unseen = (0.0, 1.0, 0.0)
    return Push(np.zeros(2), np.zeros(2), spread, (unseen, unseen), (0.0, 0.0))


def updated_push(push: Push, missing: np.ndarray, share: float, elapsed: float, time: float) -> Push:
    """Return the push that explains better what was seen."""
    # Muske and Badgwell (2002), Disturbance modeling for offset-free linear model predictive control, Journal of
    # Process Control 12(5), 617-632.
    if not np.isfinite(missing).all():
        return push
    gain = -math.expm1(-min(elapsed / time, LONGEST_GAP))
    felt = push.spread.at(np.array([share]))[0][0]
    (force, of_force, noise), (moment, of_moment, moment_noise) = (
        _filtered(*push.uncertainty[axis], push.noise[axis], float(missing[axis]), float(felt[axis]), gain)
        for axis in (0, 1)
    )
    steady, strength = np.array([force, moment]).T
    return Push(
        push.steady + steady, push.strength + strength, push.spread, (of_force, of_moment), (noise, moment_noise)
    )


def _filtered(
    walk: float, constant: float, both: float, noise: float, missing: float, felt: float, gain: float
) -> tuple[tuple[float, float], Variances, float]:
    """Return changes of the steady part and of the strength, their variances, and the noise."""
    # A Kalman filter of a random walk and a constant. The noise is taken from what is missing itself; the walk is such
    # that the filter of it alone has the gain that is asked for, q = R gain^2 / (1 - gain).
    noise = noise + gain * (missing**2 - noise) if noise else missing**2
    if not noise:
        return (0.0, 0.0), (walk, constant, both), noise
    walk += noise * gain**2 / (1.0 - gain)
    seen = walk + felt * both, both + felt * constant
    total = seen[0] + felt * seen[1] + noise
    weights = seen[0] / total, seen[1] / total
    left = (walk - weights[0] * seen[0], constant - weights[1] * seen[1], both - weights[0] * seen[1])
    return (weights[0] * missing, weights[1] * missing), left, noise
