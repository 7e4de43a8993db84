"""A bank as it is drawn on a map, and how far off it is along the normals of a centreline."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.errors import InputError
from narrows.waterway.centreline import FARTHEST, Centreline
from narrows.waterway.crossings import with_crossings
from narrows.waterway.normals import Normals

# Share of the centreline at either end beside which a bank need not be drawn.
SLACK = 0.01
# Places between two corners at which distances are checked.
BETWEEN = 8
# Places along a bank at which its side of the line is checked.
ALONG = 4000


@dataclass(frozen=True)
class BankLine:
    """A bank's own line: at each place as far off as the centreline's normal there meets it first."""

    side: str  # ``starboard`` or ``port``, as one sails along the centreline
    points: np.ndarray  # (n, 2) East and north, in either direction; at least two [m]
    line: Centreline  # The centreline

    def __post_init__(self) -> None:
        shape = np.shape(self.points)
        if len(shape) != 2 or shape[1] != 2 or not (np.abs(self.points) < FARTHEST).all() or len(self._distinct) < 2:
            raise InputError(f"the {self.side} bank needs two points or more on earth, each east and north; mend it")
        self._check_side()
        self._check_whole()
        self._check_distance()

    @property
    def corners(self) -> np.ndarray:
        """Places at which normals pass from one piece of the bank to another, and the ends of what they see [m]."""
        return self._pieces[0]

    def distance(self, s: np.ndarray | float) -> np.ndarray:
        """Return how far off the bank is [m]; beyond what is drawn it stays."""
        # s [m]
        corners, pieces = self._pieces
        s = np.clip(s, corners[0], corners[-1])
        return self._normals.met(s, pieces[np.clip(np.searchsorted(corners, s, "right") - 1, 0, len(pieces) - 1)])

    @cached_property
    def _distinct(self) -> np.ndarray:
        points = np.asarray(self.points, float)
        return np.asarray(points[np.append(True, np.diff(points, axis=0).any(axis=1))])

    @cached_property
    def _normals(self) -> Normals:
        return Normals(self.line, with_crossings(self._distinct), 1 if self.side == "starboard" else -1)

    @cached_property
    def _pieces(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners, and the piece of the bank seen between each two, -1 for none; unseen ends are cut off."""
        corners = self._normals.corners()
        pieces = self._normals.first((corners[1:] + corners[:-1]) / 2)[1]
        other = np.append(True, np.diff(pieces) != 0)
        corners, pieces = np.append(corners[:-1][other], corners[-1]), pieces[other]
        seen = np.flatnonzero(pieces >= 0)
        if not seen.size:
            raise InputError(f"no normal of the centreline meets the {self.side} bank; draw it along the whole of it")
        return corners[seen[0] : seen[-1] + 2], pieces[seen[0] : seen[-1] + 1]

    def _check_side(self) -> None:
        ends, gaps = self._distinct, np.hypot(*np.diff(self._distinct, axis=0).T)
        along = np.linspace(0, 1, ALONG) * gaps.sum()
        known = np.concatenate([[0.0], np.cumsum(gaps)])
        places = np.stack([np.interp(np.union1d(along, known), known, column) for column in ends.T], axis=1)
        s, n = self.line.locate(places)
        self._refuse_crossing(s, n * self._normals.sign, (s > 0) & (s < self.line.length))

    def _check_whole(self) -> None:
        corners, pieces = self._pieces
        length = self.line.length
        if corners[0] > SLACK * length or corners[-1] < (1 - SLACK) * length:
            raise InputError(
                f"the {self.side} bank is known from {corners[0]:.0f} to {corners[-1]:.0f} m along a centreline of "
                f"{length:.0f} m; draw it along the whole of it"
            )
        if (pieces < 0).any():
            s = corners[int((pieces < 0).argmax())]
            raise InputError(f"the normal of the centreline at {s:.0f} m meets no {self.side} bank; draw it there")

    def _check_distance(self) -> None:
        """Beside every corner, between them, and between the points of the line."""
        corners, fine = self.corners, self.line.fine
        between = (corners[:-1] + np.linspace(1e-6, 1 - 1e-6, BETWEEN)[:, None] * np.diff(corners)).ravel()
        within = fine[(fine > corners[0]) & (fine < corners[-1])]
        s = np.concatenate([between, within])
        distance = np.concatenate([self.distance(between), self._normals.first(within)[0]])
        self._refuse_crossing(s, distance, np.full(len(s), True))
        bend = self._normals.sign * self.line.curvature(s)
        beyond = bend * distance >= 1
        if beyond.any():
            first = int(beyond.argmax())
            raise InputError(
                f"the normal of the centreline at {s[first]:.0f} m meets the {self.side} bank beyond the centre of the "
                f"bend there, whose radius is {1 / bend[first]:.0f} m; smooth the centreline, or mend the bank"
            )

    def _refuse_crossing(self, s: np.ndarray, out: np.ndarray, beside: np.ndarray) -> None:
        wrong = beside & ~(out > 0)
        if wrong.any():
            along = float(s[int(wrong.argmax())])
            raise InputError(f"the {self.side} bank crosses the centreline at {along:.0f} m along it; mend it there")
