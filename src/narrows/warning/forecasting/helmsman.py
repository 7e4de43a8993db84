"""How the rudder is being used: the helmsman's law, learned as the ship sails, and the chance that nobody steers.

The law is linear in offset, heading and yaw rate, with a delay; a Kalman filter for each of some delays learns its
gains. The helm is attended or not: a hidden Markov model of two states, by how long the rudder stays still for a hand
that moves it as often, and by how far it is from that law meanwhile.

References
----------
Hamilton (1989), Econometrica 57, for the filter of the hidden states.
"""

import math
from collections import deque

import numpy as np

from narrows.warning.settings import (
    HELM_DELAYS,
    HELM_GAINS,
    HELM_GAINS_SIGMA,
    HELM_MEMORY,
    LAPSE_INTERVAL,
    LEAST_HELM_LIMIT,
    LEAST_HELM_SCATTER,
    ORDER_INTERVAL,
    RETURN_TIME,
    RUDDER_MOVES,
)


class Helmsmen:
    """Helmsmen of one ship, or of many ships abreast."""

    def __init__(self, count: int, length: float) -> None:
        self.count, self.length = count, length
        shape = count, len(HELM_DELAYS), 4
        self.gains = np.broadcast_to(np.array(HELM_GAINS), shape).copy()  # Of 1, offset, heading, yaw rate
        self._walk = np.diag(np.array(HELM_GAINS_SIGMA) ** 2) / HELM_MEMORY
        self._covariance = np.broadcast_to(np.diag(np.array(HELM_GAINS_SIGMA) ** 2), (*shape, 4)).copy()
        self._squares = np.full(shape[:2], (2 * LEAST_HELM_SCATTER) ** 2)  # Of what the rudder was off the law
        self._past: deque[np.ndarray] = deque(maxlen=max(HELM_DELAYS) + 1)
        self.unattended = np.full(count, 0.02)  # Chance that nobody steers [1]
        self.off = np.zeros(count)  # The rudder from the law's [rad]
        self.limit = np.full(count, LEAST_HELM_LIMIT)  # The largest angle that is used [rad]
        self._moves = np.full(count, 1.0 / ORDER_INTERVAL)  # Of the rudder, a second
        self._rudder: np.ndarray | None = None

    @property
    def delay(self) -> np.ndarray:
        """Time from what is seen to the rudder, (count,) [s]."""
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
        moved = self._moved(rudder)
        self._judge(np.sqrt(self._squares[here]), moved)
        self._learn(seen, off, 1.0 - self.unattended)
        self.limit = np.maximum.reduce(
            [self.limit * math.exp(-1.0 / HELM_MEMORY), np.abs(rudder), np.full(self.count, LEAST_HELM_LIMIT)]
        )

    def _moved(self, rudder: np.ndarray) -> np.ndarray:
        before = rudder if self._rudder is None else self._rudder
        self._rudder = rudder.copy()
        return np.asarray(np.abs(rudder - before) > RUDDER_MOVES)

    def _judge(self, scatter: np.ndarray, moved: np.ndarray) -> None:
        """One step of the filter of the hidden state."""
        before = self.unattended + (1.0 - self.unattended) / LAPSE_INTERVAL - self.unattended / RETURN_TIME
        # A hand moves the rudder at its usual rate, and sooner the farther the rudder is from its law.
        rate = np.clip(self._moves * (1.0 + (self.off / scatter) ** 2), 0.02, 0.5)
        by_moves = np.where(moved, np.log(0.02 / rate), -np.log1p(-rate))
        odds = np.log(before / (1.0 - before)) + np.clip(by_moves, -3.0, 3.0)
        self.unattended = np.clip(1.0 / (1.0 + np.exp(-odds)), 2e-3, 0.999)
        self._moves += (1.0 - self.unattended) * (moved - self._moves) / HELM_MEMORY

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
            "since": self.delay + 0.5 / np.clip(self._moves, 0.02, 0.5), "trim": trim, "line": np.zeros(self.count),
            "reach": by_y / self.length / heading, "by_psi": heading,
            "by_r": by_r * self.length / np.maximum(u, 0.1), "most": self.limit,
        }  # fmt: skip
