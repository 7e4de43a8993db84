"""What bridges foretell without a model: the distance to the bank, the track straight on, the track curved by the turn.

The banks are taken to go on as they are beside the ship; along a bend by the line's curvature there.
"""

from typing import Any, NamedTuple

import numpy as np

from narrows.ship.particulars import Ship
from narrows.ship.swept_width import half_swept

STEP = 2.0
"""Between the places of a track [s]."""


class Beside(NamedTuple):
    """Ships beside banks.

    Parameters
    ----------
    hull : Ship
        Length and beam.
    half_width : float [m]
        Of the water.
    y : array (n,) [m]
        To starboard of the middle.
    psi : array (n,) [rad]
        Heading, to the line.
    u, v : array (n,) [m/s]
        Surge and sway velocity.
    r : array (n,) [rad/s]
        Yaw rate.
    bend : float [1/m]
        Curvature of the line.
    """

    hull: Ship
    half_width: float
    y: np.ndarray
    psi: np.ndarray
    u: np.ndarray
    v: np.ndarray
    r: np.ndarray
    bend: float = 0.0

    def clearance(self, y: np.ndarray, psi: np.ndarray) -> Any:
        """Return the water beside the corners of the hull [m].

        Parameters
        ----------
        y, psi : array [m, rad]
            Where it is.
        """
        return self.half_width - np.abs(y) - half_swept(self.hull, psi)

    @property
    def now(self) -> Any:
        """The clearance as it is, (n,) [m]."""
        return self.clearance(self.y, self.psi)

    def straight_contact(self, until: float) -> np.ndarray:
        """Return when a ship that goes straight on meets a bank, (n,) [s]; infinite where it does not by then.

        Parameters
        ----------
        until : float [s]
            How far it is looked ahead.
        """
        return self._contact(np.zeros_like(self.r), until)

    def curved_contact(self, until: float) -> np.ndarray:
        """Return the same of a ship that goes on turning as fast as it does.

        Parameters
        ----------
        until : float [s]
            How far it is looked ahead.
        """
        return self._contact(self.r, until)

    def _contact(self, turn: np.ndarray, until: float) -> np.ndarray:
        t = np.arange(0.0, until + STEP / 2, STEP)
        psi = self.psi[:, None] + (turn - self.bend * self.u)[:, None] * t
        across = self.u[:, None] * np.sin(psi) + self.v[:, None] * np.cos(psi)
        gone = np.cumsum((across[:, 1:] + across[:, :-1]) / 2 * STEP, axis=1)
        y = self.y[:, None] + np.concatenate([np.zeros((len(self.y), 1)), gone], axis=1)
        met = self.clearance(y, psi) <= 0.0
        return np.where(met.any(axis=1), t[met.argmax(axis=1)], np.inf)
