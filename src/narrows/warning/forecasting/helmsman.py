"""The helmsman's control law, identified as the ship sails, and the probability that nobody steers.

The law is linear in offset, heading and yaw rate, with a delay; a Kalman filter for each of some delays learns its
gains. The helm is attended or not: a hidden semi-Markov model of two states. A hand moves the rudder after log-normal
times, whose mean and variance are learned; without a hand it stays still.

References
----------
Yu (2010), Artificial Intelligence 174, Hidden semi-Markov models.
"""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.special import log_ndtr

from narrows.quantities.arithmetic import choice, clip
from narrows.results import BaseSummary
from narrows.simulation.controllers import EARLY, Named
from narrows.warning.settings import (
    ENGINE_KICK,
    ESCAPE_ANGLE,
    ESCAPE_HEADING_GAIN,
    ESCAPE_TURN_GAIN,
    HELM_DELAYS,
    HELM_GAINS,
    HELM_GAINS_SIGMA,
    HELM_MEMORY,
    HELM_MOVES,
    LAPSE_INTERVAL,
    LEAST_HELM_LIMIT,
    LEAST_HELM_SCATTER,
    MOST_EVIDENCE,
    ORDER_INTERVAL,
    ORDER_INTERVAL_SPREAD,
    REACH_LENGTHS,
    RETURN_TIME,
    RUDDER_MOVES,
    UNATTENDED_MOVES,
)


class Helmsmen:
    """Helmsmen of one ship, or of many ships abreast."""

    def __init__(self, count: int, length: float) -> None:
        self.count, self.length = count, length
        shape = count, len(HELM_DELAYS), 4
        self.gains = np.broadcast_to(np.array(HELM_GAINS), shape).copy()  # Gains of 1, offset, heading, yaw rate
        self._walk = np.diag(np.array(HELM_GAINS_SIGMA) ** 2) / HELM_MEMORY
        self._covariance = np.broadcast_to(np.diag(np.array(HELM_GAINS_SIGMA) ** 2), (*shape, 4)).copy()
        self._squares = np.full(shape[:2], (2 * LEAST_HELM_SCATTER) ** 2)  # Squared deviations from the law
        self._past: deque[np.ndarray] = deque(maxlen=max(HELM_DELAYS) + 1)
        self.unattended = np.full(count, 0.02)  # Chance that nobody steers [1]
        self.off = np.zeros(count)  # The rudder from the law's [rad]
        self.limit = np.full(count, LEAST_HELM_LIMIT)  # The largest angle that is used [rad]
        # Times for which the rudder stays still: mean and variance of their logarithms.
        self._still_mean = np.full(count, math.log(ORDER_INTERVAL))
        self._still_variance = np.full(count, ORDER_INTERVAL_SPREAD**2)
        self._still = np.zeros(count)  # Since the rudder last moved [s]
        self._held: np.ndarray | None = None  # Its angle since then [rad]

    @property
    def delay(self) -> np.ndarray:
        """Reaction time of the helmsman, (count,) [s]."""
        return np.asarray(np.array(HELM_DELAYS)[self._best])

    @property
    def _best(self) -> np.ndarray:
        return np.asarray(self._squares.argmin(axis=1))

    def update(self, y: np.ndarray, psi: np.ndarray, turn: np.ndarray, u: np.ndarray, rudder: np.ndarray) -> None:
        """Take in a second: offset [m], heading [rad] and yaw rate [rad/s] to the waterway, speed [m/s], rudder."""
        pace = self.length / np.maximum(u, 0.1)
        self._past.append(np.stack([np.ones_like(y), -y / self.length, -psi, -turn * pace], axis=-1))
        seen = np.stack([self._past[max(len(self._past) - 1 - delay, 0)] for delay in HELM_DELAYS], axis=1)
        off = rudder[:, None] - (self.gains * seen).sum(axis=-1)
        here = np.arange(self.count), self._best
        self.off = off[here]
        self._judge(rudder)
        self._learn(seen, off, 1.0 - self.unattended)
        self.limit = np.maximum.reduce(
            [self.limit * math.exp(-1.0 / HELM_MEMORY), np.abs(rudder), np.full(self.count, LEAST_HELM_LIMIT)]
        )

    def _judge(self, rudder: np.ndarray) -> None:
        """One step of the filter of the hidden state."""
        self._held = rudder.copy() if self._held is None else self._held
        moved = np.abs(rudder - self._held) > RUDDER_MOVES
        before = self.unattended + (1.0 - self.unattended) / LAPSE_INTERVAL - self.unattended / RETURN_TIME
        stays = self._log_survival(self._still + 1.0) - self._log_survival(self._still)
        moves = np.log(UNATTENDED_MOVES / np.clip(-np.expm1(stays), UNATTENDED_MOVES, 1.0))
        odds = np.log(before / (1.0 - before)) + np.where(moved, moves, np.minimum(-stays, MOST_EVIDENCE))
        self.unattended = np.clip(1.0 / (1.0 + np.exp(-odds)), 2e-3, 0.999)
        ended = moved & (self._still > 1.0)
        off = np.log(np.maximum(self._still, 1.0)) - self._still_mean
        share = np.where(ended, (1.0 - self.unattended) / HELM_MOVES, 0.0)
        self._still_mean += share * off
        self._still_variance += share * (off**2 - self._still_variance)
        self._still = np.where(moved, 0.0, self._still + 1.0)
        self._held = np.where(moved, rudder, self._held)

    def _log_survival(self, still: np.ndarray) -> np.ndarray:
        """Logarithm of the chance that a hand leaves the rudder still for a time [s]."""
        off = np.log(np.maximum(still, 0.5)) - self._still_mean
        return np.asarray(log_ndtr(-off / np.sqrt(self._still_variance)))

    def _learn(self, seen: np.ndarray, off: np.ndarray, weight: np.ndarray) -> None:
        """One step of the Kalman filters; what is done while nobody steers teaches nothing."""
        self._covariance += self._walk
        noise = self._squares * ORDER_INTERVAL / np.maximum(weight, 1e-3)[:, None]
        shared = (self._covariance @ seen[..., None])[..., 0]
        gain = shared / ((shared * seen).sum(axis=-1) + noise)[..., None]
        self.gains += gain * off[..., None]
        self.gains[..., 1:] = np.maximum(self.gains[..., 1:], 0.0)
        self._covariance -= gain[..., None] * shared[..., None, :]
        share = weight[:, None] / HELM_MEMORY
        self._squares += share * (np.maximum(off**2, LEAST_HELM_SCATTER**2) - self._squares)

    def law(self, u: np.ndarray) -> dict[str, np.ndarray]:
        """Return the numbers of the law for a lane of each ship (``LineOfSight``)."""
        trim, by_y, by_psi, by_r = np.moveaxis(self.gains[np.arange(self.count), self._best], -1, 0)
        heading = np.maximum(by_psi, 0.05)
        return {
            "since": self.delay + 0.5 * np.exp(self._still_mean), "trim": trim, "line": np.zeros(self.count),
            "reach": by_y / self.length / heading, "by_psi": heading,
            "by_r": by_r * self.length / np.maximum(u, 0.1), "most": self.limit,
        }  # fmt: skip


REVOLUTIONS = "revolutions"


class Manoeuvre(NamedTuple):
    words: str  # Order after the first one
    kick: float = 1.0  # Revolutions over those of now [1]


# The best of 37 manoeuvres (angles back to the line, gains, counter rudder alone) in each case saves less than half a
# percent of the contacts more than the first one here: decisions/warning_scores.py.
STEADY = Manoeuvre("then steady parallel to the bank")
KICK = Manoeuvre("kick ahead, then steady parallel to the bank", ENGINE_KICK)


@dataclass(frozen=True, repr=False)
class LineOfSight(BaseSummary):
    """Line-of-sight guidance with a proportional-derivative autopilot, after a time for which the rudder is held.

    References
    ----------
    Fossen (2011), Handbook of Marine Craft Hydrodynamics and Motion Control, for guidance by line of sight.
    """

    driven: bool = False  # True where it also orders revolutions

    def parameters(self) -> Mapping[str, Any]:
        """Return its numbers as they are before they are loaded: all of them differ from lane to lane."""
        names = ("since", "ordered", "line", "reach", "approach", "by_psi", "by_r", "trim", "most")
        return dict.fromkeys(names, 1.0) | (dict.fromkeys(("turns", "kicked"), 0.0) if self.driven else {})

    def memory(self, start: Named) -> Named:
        """Return nothing: it looks at the present alone."""
        return {}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the rudder that is held before a time, and that of the law from then on."""
        pace = at.u + at.current
        off = at.psi - clip((at.line - at.y) * at.reach, at.approach)
        turn = at.r - at.water("curvature", at.x) * pace
        law = clip(at.trim - at.by_psi * off - at.by_r * turn, at.most)
        on = at.t - at.since + EARLY * at.dt
        orders: dict[str, Any] = {"rudder": choice(on, law, at.ordered)}
        if self.driven:
            orders[REVOLUTIONS] = choice(on, at.kicked, at.turns)
        return orders, {}


def escape_numbers(line: float, length: float, limit: float) -> dict[str, float]:
    """Return the law's numbers of an escape: hard over, and checked in time; ``by_r`` is divided by the speed [m/s]."""
    return {
        "line": line, "reach": 1.0 / (REACH_LENGTHS * length), "approach": ESCAPE_ANGLE, "trim": 0.0, "most": limit,
        "by_psi": ESCAPE_HEADING_GAIN, "by_r": ESCAPE_TURN_GAIN * length,
    }  # fmt: skip
