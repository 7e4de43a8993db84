"""The helmsman's control law, identified as the ship sails, and the probability that nobody steers.

The law is linear in offset, heading and yaw rate, with a delay; a Kalman filter for each of some delays learns its
gains. The helm is attended or not: a hidden Markov model of two states. The rudder of a hand scatters about its law, as
widely as is learned; a rudder that nobody holds has any angle, and moves less often.

References
----------
Rabiner (1989), Proceedings of the IEEE 77, A tutorial on hidden Markov models.
"""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from narrows.quantities.arithmetic import choice, clip
from narrows.results import BaseSummary
from narrows.simulation.controllers import ORDER_TOLERANCE, Named
from narrows.warning.settings import (
    DEVIATION_TIME,
    ENGINE_KICK,
    ESCAPE_ANGLE,
    ESCAPE_HEADING_GAIN,
    ESCAPE_TURN_GAIN,
    HELM_DELAYS,
    HELM_FREEDOM,
    HELM_GAINS,
    HELM_GAINS_SIGMA,
    HELM_MEMORY,
    LAPSE_INTERVAL,
    LEAST_HELM_LIMIT,
    LEAST_HELM_SCATTER,
    ORDER_INTERVAL,
    REACH_LENGTHS,
    RETURN_TIME,
    RUDDER_MOVES,
    UNATTENDED_BOUNDS,
    UNATTENDED_MOVES,
    UNATTENDED_SCATTER,
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
        self._held: np.ndarray | None = None  # Angle of the rudder since it last moved [rad]

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
        step = rudder - self._held
        moved = np.abs(step) > RUDDER_MOVES
        # Only a move that brings the rudder nearer to the law shows a hand at work: a wrong order does not.
        steered = moved & (np.abs(self.off) < np.abs(self.off - step))
        self._held = np.where(moved, rudder, self._held)
        before = self.unattended + (1.0 - self.unattended) / LAPSE_INTERVAL - self.unattended / RETURN_TIME
        scatter = np.sqrt(self._squares[np.arange(self.count), self._best])
        evidence = (log_student(self.off, UNATTENDED_SCATTER) - log_student(self.off, scatter)) / DEVIATION_TIME
        odds = np.log(before / (1.0 - before)) + evidence + steered * math.log(UNATTENDED_MOVES * ORDER_INTERVAL)
        self.unattended = np.clip(1.0 / (1.0 + np.exp(-odds)), *UNATTENDED_BOUNDS)

    def _learn(self, seen: np.ndarray, off: np.ndarray, weight: np.ndarray) -> None:
        """One step of the Kalman filters; steps without a helmsman change nothing."""
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
            "since": self.delay + 0.5 * ORDER_INTERVAL, "trim": trim, "line": np.zeros(self.count),
            "reach": by_y / self.length / heading, "by_psi": heading,
            "by_r": by_r * self.length / np.maximum(u, 0.1), "most": self.limit,
        }  # fmt: skip


def log_student(off: np.ndarray, scale: float | np.ndarray) -> np.ndarray:
    """Log density of Student's t with ``HELM_FREEDOM`` degrees of freedom, less its constant."""
    return np.asarray(-np.log(scale) - 0.5 * (HELM_FREEDOM + 1.0) * np.log1p((off / scale) ** 2 / HELM_FREEDOM))


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

    Its heading to the line is less by ``crab``, the angle that a current across needs.

    References
    ----------
    Fossen (2011), Handbook of Marine Craft Hydrodynamics and Motion Control, for guidance by line of sight.
    """

    driven: bool = False  # True where it also orders revolutions

    def parameters(self) -> Mapping[str, Any]:
        """Return its numbers as they are before they are loaded: all of them differ from lane to lane."""
        names = ("since", "ordered", "line", "reach", "approach", "crab", "by_psi", "by_r", "trim", "most")
        return dict.fromkeys(names, 1.0) | (dict.fromkeys(("turns", "kicked"), 0.0) if self.driven else {})

    def memory(self, start: Named) -> Named:
        """Return nothing: it looks at the present alone."""
        return {}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the rudder that is held before a time, and that of the law from then on."""
        pace = at.u + at.current
        off = at.psi + at.crab - clip((at.line - at.y) * at.reach, at.approach)
        turn = at.r - at.water("curvature", at.x) * pace
        law = clip(at.trim - at.by_psi * off - at.by_r * turn, at.most)
        on = at.t - at.since + ORDER_TOLERANCE * at.dt
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
