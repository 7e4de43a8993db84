"""A bank along a centreline: how far off it is at every place, from its own line."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from narrows.errors import InputError
from narrows.ship.cross_section import Point, equivalent_wall, keel_wall
from narrows.waterway.centreline import Centreline

Wall = Callable[[Sequence[Point], float], float]
FAR = 1e4
"""More than any bank's profile reaches [m]."""
BETWEEN = 8
"""Places taken between two points of a bank's line."""


@dataclass(frozen=True)
class Bank:
    """How far a bank is from the centreline, and what shape it has.

    Parameters
    ----------
    side : str
        ``starboard`` or ``port``, as one sails along the line.
    s : array (n,) [m]
        Along the line, rising.
    distance : array (n,) [m]
        From the line to the bank, square to the line: to its wall, or to the origin of its profile.
    profile : sequence of (m, m)
        Points of a slope or of steps: distance beyond the bank's line, and height above the bottom, outward from the
        toe. A vertical wall unless given.

    Raises
    ------
    InputError
        Where the bank crosses the line or doubles back, with the place.
    """

    side: str
    s: np.ndarray
    distance: np.ndarray
    profile: tuple[Point, ...] = ()

    def __post_init__(self) -> None:
        wrong = ~(np.asarray(self.distance) > 0)
        if wrong.any():
            place = float(self.s[int(wrong.argmax())])
            raise InputError(f"the {self.side} bank crosses the centreline at {place:.0f} m along it; mend it there")
        back = np.diff(self.s) <= 0
        if back.any():
            place = float(self.s[int(back.argmax())])
            raise InputError(f"the {self.side} bank doubles back at {place:.0f} m along the centreline; mend it there")

    def wall(self, s: np.ndarray | float, depth: np.ndarray | float) -> np.ndarray:
        """Return how far off a vertical wall is that leaves the same section of water [m].

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        depth : array or float [m]
            Of the water there.
        """
        return self._set_back(s, depth, equivalent_wall)

    def keel(self, s: np.ndarray | float, clearance: np.ndarray | float) -> np.ndarray:
        """Return how far off a keel meets the bank [m].

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        clearance : array or float [m]
            Of the keel above the bottom there.
        """
        return self._set_back(s, clearance, keel_wall)

    def _set_back(self, s: np.ndarray | float, height: np.ndarray | float, where: Wall) -> np.ndarray:
        line = self.at(s)
        if not self.profile:
            return line
        # Seen from far off, so that a profile that begins before its line leaves water too.
        away = [(FAR + out, up) for out, up in self.profile]
        heights, place = np.unique(np.broadcast_to(height, line.shape), return_inverse=True)
        back = np.array([where(away, own) - FAR if own > 0 else np.nan for own in heights.tolist()])
        return np.asarray(line + back[place].reshape(line.shape))

    def at(self, s: np.ndarray | float) -> np.ndarray:
        """Return the distance [m] at places; beyond the ends of the bank it stays.

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        """
        return np.asarray(np.interp(s, self.s, self.distance))


def bank_from_points(side: str, points: np.ndarray, line: Centreline, profile: tuple[Point, ...] = ()) -> Bank:
    """Measure a bank's own line against the centreline (ours).

    Parameters
    ----------
    side : str
        ``starboard`` or ``port``.
    points : array (n, 2) [m]
        East and north, in either direction.
    line : Centreline
        The line.
    profile : sequence of (m, m)
        Its shape, as in ``Bank``.

    Raises
    ------
    InputError
        Where the bank crosses the line, doubles back, or does not reach along the whole of it.
    """
    points = np.asarray(points, float)
    shares = np.linspace(0, 1, BETWEEN, endpoint=False)[:, None]
    dense = np.concatenate([a + shares * (b - a) for a, b in pairwise(points)] + [points[-1:]])
    s, n = line.place(dense)
    if s[0] > s[-1]:
        s, n = s[::-1], n[::-1]
    bank = Bank(side, s, n if side == "starboard" else -n, profile)
    slack = 0.01 * line.length
    if bank.s[0] > slack or bank.s[-1] < line.length - slack:
        raise InputError(
            f"the {side} bank is known from {bank.s[0]:.0f} to {bank.s[-1]:.0f} m along a centreline of "
            f"{line.length:.0f} m; draw it along the whole of it"
        )
    return bank
