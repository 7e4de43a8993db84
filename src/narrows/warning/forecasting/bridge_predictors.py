"""What bridges foretell without a model: the distance to the bank, the track straight on, the track curved by the turn.

The banks are taken to go on as they are beside the ship; along a bend by the line's curvature there.
"""

from typing import Any, NamedTuple

import numpy as np

from narrows.ship.particulars import Ship
from narrows.ship.swept_width import half_swept

# Between the places of a track [s].
STEP = 2.0


class Beside(NamedTuple):
    """Ships beside banks."""

    hull: Ship  # Length and beam
    half_width: float  # Of the water [m]
    y: np.ndarray  # (n,) To starboard of the middle [m]
    psi: np.ndarray  # (n,) Heading, to the line [rad]
    u: np.ndarray  # (n,) Surge and sway velocity [m/s]
    v: np.ndarray  # (n,) Surge and sway velocity [m/s]
    r: np.ndarray  # (n,) Yaw rate [rad/s]
    bend: float = 0.0  # Curvature of the line [1/m]

    def clearance(self, y: np.ndarray, psi: np.ndarray) -> Any:
        """Return the water beside the corners of the hull [m]."""
        # y, psi [m, rad]
        return self.half_width - np.abs(y) - half_swept(self.hull, psi)

    @property
    def now(self) -> Any:
        """The clearance as it is, (n,) [m]."""
        return self.clearance(self.y, self.psi)

    def straight_contact(self, until: float) -> np.ndarray:
        """Return when a ship that goes straight on meets a bank, (n,) [s]; infinite where it does not by then."""
        # until [s]
        return self._contact(np.zeros_like(self.r), until)

    def curved_contact(self, until: float) -> np.ndarray:
        """Return the same of a ship that goes on turning as fast as it does."""
        # until [s]
        return self._contact(self.r, until)

    def _contact(self, turn: np.ndarray, until: float) -> np.ndarray:
        t = np.arange(0.0, until + STEP / 2, STEP)
        psi = self.psi[:, None] + (turn - self.bend * self.u)[:, None] * t
        across = self.u[:, None] * np.sin(psi) + self.v[:, None] * np.cos(psi)
        gone = np.cumsum((across[:, 1:] + across[:, :-1]) / 2 * STEP, axis=1)
        y = self.y[:, None] + np.concatenate([np.zeros((len(self.y), 1)), gone], axis=1)
        met = self.clearance(y, psi) <= 0.0
        return np.where(met.any(axis=1), t[met.argmax(axis=1)], np.inf)
