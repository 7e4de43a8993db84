"""A bank along a centreline: how far off it is at every place, from its own line."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError
from narrows.ship.cross_section import Point, equivalent_wall, keel_wall
from narrows.waterway.bank_line import BankLine
from narrows.waterway.centreline import FARTHEST, Centreline

Wall = Callable[[Sequence[Point], float], float]
# More than any bank's profile reaches [m].
FAR = 1e4


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
    drawn : BankLine, optional
        Its own line on a map, where it is known: it then says the distance at every place, and ``s`` and ``distance``
        are its corners.

    Raises
    ------
    InputError
        Where the bank crosses the line, is farther off than any, or its places do not rise; where its profile is none.
    """

    side: str
    s: np.ndarray
    distance: np.ndarray
    profile: tuple[Point, ...] = ()
    drawn: BankLine | None = None

    def __post_init__(self) -> None:
        wrong = ~(np.asarray(self.distance) > 0)
        if wrong.any():
            along = float(self.s[int(wrong.argmax())])
            raise InputError(f"the {self.side} bank crosses the centreline at {along:.0f} m along it; mend it there")
        if not np.max(self.distance) < FARTHEST:
            raise InputError(f"the {self.side} bank is {np.max(self.distance):g} m off, farther than any; give metres")
        back = np.diff(self.s) <= 0
        if back.any():
            along = float(self.s[int(back.argmax())])
            raise InputError(f"the {self.side} bank doubles back at {along:.0f} m along the centreline; mend it there")
        if self.profile:
            _check_profile(self.profile, self.side)

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
        heights, index = np.unique(np.broadcast_to(height, line.shape), return_inverse=True)
        back = np.array(
            [where(away, one_height) - FAR if one_height > 0 else np.nan for one_height in heights.tolist()]
        )
        return np.asarray(line + back[index].reshape(line.shape))

    def at(self, s: np.ndarray | float) -> np.ndarray:
        """Return the distance [m] at places; beyond the ends of the bank it stays.

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        """
        if self.drawn is not None:
            return self.drawn.distance(s)
        return np.asarray(np.interp(s, self.s, self.distance))


def _check_profile(profile: tuple[Point, ...], side: str) -> None:
    try:
        points = np.array(profile, float)
    except (TypeError, ValueError, OverflowError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"the profile of the {side} bank is not pairs of distance and height; mend it")
    if len(points) < 2:
        raise InputError(f"the profile of the {side} bank has one point; give it two points or more")
    wrong = ~((np.abs(points[:, 0]) < FAR) & (points[:, 1] >= 0) & (points[:, 1] < FAR))
    if wrong.any():
        out, up = points[int(wrong.argmax())]
        raise InputError(
            f"the profile of the {side} bank has the point {out:g}, {up:g}: give metres, none below the bottom"
        )
    back = np.diff(points[:, 0]) < 0
    if back.any():
        distance = points[int(back.argmax()), 0]
        raise InputError(
            f"the profile of the {side} bank turns back at {distance:g} m; give its points outward from the toe"
        )


def bank_from_points(side: str, points: np.ndarray, line: Centreline, profile: tuple[Point, ...] = ()) -> Bank:
    """Return a bank by its own line: at each place as far off as the normal of the centreline meets it first."""
    # points (n, 2) [m]; profile (m, m)
    drawn = BankLine(side, points, line)
    return Bank(side, drawn.corners, drawn.distance(drawn.corners), profile, drawn)
