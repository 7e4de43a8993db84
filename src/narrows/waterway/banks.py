"""A bank along a centreline: how far off it is at every place, from its own line."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from narrows.errors import InputError
from narrows.waterway.centreline import Centreline

BETWEEN = 8
"""Places taken between two points of a bank's line."""


@dataclass(frozen=True)
class Bank:
    """How far a bank is from the centreline.

    Parameters
    ----------
    side : str
        ``starboard`` or ``port``, as one sails along the line.
    s : array (n,) [m]
        Along the line, rising.
    distance : array (n,) [m]
        From the line to the bank, square to the line.

    Raises
    ------
    InputError
        Where the bank crosses the line or doubles back, with the place.
    """

    side: str
    s: np.ndarray
    distance: np.ndarray

    def __post_init__(self) -> None:
        wrong = ~(np.asarray(self.distance) > 0)
        if wrong.any():
            place = float(self.s[int(wrong.argmax())])
            raise InputError(f"the {self.side} bank crosses the centreline at {place:.0f} m along it; mend it there")
        back = np.diff(self.s) <= 0
        if back.any():
            place = float(self.s[int(back.argmax())])
            raise InputError(f"the {self.side} bank doubles back at {place:.0f} m along the centreline; mend it there")

    def at(self, s: np.ndarray | float) -> np.ndarray:
        """Return the distance [m] at places; beyond the ends of the bank it stays.

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        """
        return np.asarray(np.interp(s, self.s, self.distance))


def bank_from_points(side: str, points: np.ndarray, line: Centreline) -> Bank:
    """Measure a bank's own line against the centreline (ours).

    Parameters
    ----------
    side : str
        ``starboard`` or ``port``.
    points : array (n, 2) [m]
        East and north, in either direction.
    line : Centreline
        The line.

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
    bank = Bank(side, s, n if side == "starboard" else -n)
    slack = 0.01 * line.length
    if bank.s[0] > slack or bank.s[-1] < line.length - slack:
        raise InputError(
            f"the {side} bank is known from {bank.s[0]:.0f} to {bank.s[-1]:.0f} m along a centreline of "
            f"{line.length:.0f} m; draw it along the whole of it"
        )
    return bank
