"""A bank along a centreline: its distance at every place, from its own line on a map or from distances."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from narrows.base.errors import InputError
from narrows.ship.particulars import PROFILE_REACH, Point, check_profile, keel_wall, wall_of
from narrows.waterway.centreline import FARTHEST, Centreline, chords

# Share of the centreline at either end where a bank may be missing: its distance is assumed constant, with a
# note.
SLACK = 0.06
# Places along a bank at which its side of the line is checked.
ALONG = 4000


@dataclass(frozen=True)
class Normals:
    """Normals of a centreline to one side, and one or several polylines on that side."""

    line: Centreline  # The centreline
    points: np.ndarray  # (n, 2) East and north of the polyline's points, successive ones distinct [m]
    sign: int  # 1 for normals to starboard, -1 to port
    # Pieces between two points that are not drawn, between the end of one polyline and the start of the next
    gaps: np.ndarray = field(default_factory=lambda: np.empty(0, int))

    def met(self, s: np.ndarray | float, piece: np.ndarray) -> np.ndarray:
        """Return the distance along normals of pieces of the polyline [m], from end to end of each piece."""
        position, ahead = self.line.frame(s)
        across = self.sign * np.stack([ahead[..., 1], -ahead[..., 0]], axis=-1)
        start, stop = self.points[piece] - position, self.points[piece + 1] - position
        before, after = (start * ahead).sum(axis=-1), (stop * ahead).sum(axis=-1)
        share = np.clip(before / np.where(before == after, 1.0, before - after), 0, 1)
        return np.asarray((1 - share) * (start * across).sum(axis=-1) + share * (stop * across).sum(axis=-1))

    def first(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return how far off the normals at places meet the polyline first [m], and which piece of it."""
        # s (n,) [m]; infinite and -1 if they meet none.
        distance, first = np.full(len(s), np.inf), np.full(len(s), -1)
        for part in self._parts(len(s)):
            crossed = np.diff(self._behind(s[part]), axis=1)
            crossed[:, self.gaps] = False
            normal, piece = np.nonzero(crossed)
            met = self.met(s[part][normal], piece)
            normal, piece, met = normal[met > 0], piece[met > 0], met[met > 0]
            order = np.lexsort((met, normal))
            normals, at = np.unique(normal[order], return_index=True)
            distance[part.start + normals], first[part.start + normals] = met[order][at], piece[order][at]
        return distance, first

    def corners(self) -> np.ndarray:
        """Return places whose normals pass a visible point of the polyline, and the line's ends [m]."""
        # Between two of them the normals meet the same piece first, or none.
        fine, places = self.line.fine, [np.array([0.0, self.line.length])]
        for part in self._parts(len(fine) - 1):
            cell, point = np.nonzero(np.diff(self._behind(fine[part.start : part.stop + 1]), axis=0))
            cell += part.start
            s, n = self.line.foot((fine[cell] + fine[cell + 1]) / 2, self.points[point])
            # A bank beyond the centre of a bend is refused, so it needs no corners.
            places.append(s[(self.sign * n > 0) & (self.line.curvature(s) * n < 1)])
        return np.unique(np.clip(np.concatenate(places), 0, self.line.length))

    def _parts(self, count: int) -> Iterator[slice]:
        many = max(1, AT_ONCE // len(self.points))
        return (slice(start, min(start + many, count)) for start in range(0, count, many))

    def _behind(self, s: np.ndarray) -> np.ndarray:
        """Return which points are behind the normals at places, (places, points)."""
        position, ahead = self.line.frame(s)
        return np.asarray(ahead @ self.points.T <= (position * ahead).sum(axis=1, keepdims=True))


@dataclass(frozen=True)
class BankLine:
    """A bank from its own line: at each place its distance is where the centreline's normal first meets it."""

    side: str  # ``starboard`` or ``port``, looking along the centreline
    points: np.ndarray  # (n, 2) East and north, in either direction; at least two [m]
    line: Centreline  # The centreline

    def __post_init__(self) -> None:
        shape = np.shape(self.points)
        if len(shape) != 2 or shape[1] != 2 or not (np.abs(self.points) < FARTHEST).all() or len(self._distinct) < 2:
            raise InputError(f"the {self.side} bank needs two points or more on earth, each east and north; mend it")
        known = chords(self._distinct)
        along = np.union1d(np.linspace(0, 1, ALONG) * known[-1], known)
        s, n = self.line.locate(np.stack([np.interp(along, known, column) for column in self._distinct.T], axis=1))
        refuse_crossing(self.side, s, (s > 0) & (s < self.line.length) & ~(n * self._normals.sign > 0))
        (corners, pieces), length = self._pieces, self.line.length
        if corners[0] > SLACK * length or corners[-1] < (1 - SLACK) * length:
            raise InputError(
                f"the {self.side} bank is known from {corners[0]:.0f} to {corners[-1]:.0f} m along a centreline of "
                f"{length:.0f} m; draw it along the whole of it"
            )
        if (pieces < 0).any():
            place = corners[int((pieces < 0).argmax())]
            raise InputError(f"the normal of the centreline at {place:.0f} m meets no {self.side} bank; draw it there")

    @property
    def corners(self) -> np.ndarray:
        """Places at which normals pass from one piece of the bank to another, and the ends of the visible part [m]."""
        return self._pieces[0]

    def distance(self, s: np.ndarray | float) -> np.ndarray:
        """Return the distance of the bank [m]; constant beyond the drawn part."""
        corners, pieces = self._pieces
        s = np.clip(s, corners[0], corners[-1])
        return self._normals.met(s, pieces[np.clip(np.searchsorted(corners, s, "right") - 1, 0, len(pieces) - 1)])

    @cached_property
    def _distinct(self) -> np.ndarray:
        points = np.asarray(self.points, float)
        return np.asarray(points[np.append(True, np.diff(points, axis=0).any(axis=1))])

    @cached_property
    def _normals(self) -> Normals:
        return Normals(self.line, self._distinct, 1 if self.side == "starboard" else -1)

    @cached_property
    def _pieces(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners, and the piece of the bank between each two, -1 for none; unseen ends are cut off."""
        # Where a bank crosses itself another piece comes first between two corners: found to the samples of the line.
        corners = np.union1d(self._normals.corners(), self.line.fine)
        pieces = self._normals.first((corners[1:] + corners[:-1]) / 2)[1]
        other = np.append(True, np.diff(pieces) != 0)
        corners, pieces = np.append(corners[:-1][other], corners[-1]), pieces[other]
        seen = np.flatnonzero(pieces >= 0)
        if not seen.size:
            raise InputError(f"no normal of the centreline meets the {self.side} bank; draw it along the whole of it")
        return corners[seen[0] : seen[-1] + 2], pieces[seen[0] : seen[-1] + 1]


def refuse_crossing(side: str, s: np.ndarray, wrong: np.ndarray) -> None:
    if wrong.any():
        along = float(s[int(wrong.argmax())])
        raise InputError(f"the {side} bank crosses the centreline at {along:.0f} m along it; mend it there")


# Largest number of normal-point pairs that are processed together.
AT_ONCE = 4_000_000


Wall = Callable[[Sequence[Point], float], float]


@dataclass(frozen=True)
class Bank:
    """Distance of a bank from the centreline, and its shape.

    Raises an InputError if the bank crosses the line, is too far away, or its places do not rise; if its profile is
    invalid.
    """

    side: str  #: ``starboard`` or ``port``, looking along the line
    s: np.ndarray  #: (n,) Along the line, rising [m]
    #: (n,) Distance from the line to the bank, perpendicular to it: to its wall, or to the origin of its profile [m]
    distance: np.ndarray
    #: Points of a slope or of steps: distance beyond the bank's line, and height above the bottom, outward from the
    #: toe [m]; default: a vertical wall
    profile: tuple[Point, ...] = ()
    #: Its own line on a map, if known: it gives the distance at every place, and ``s`` and ``distance`` are its
    #: corners
    drawn: BankLine | None = None

    def __post_init__(self) -> None:
        refuse_crossing(self.side, np.asarray(self.s), ~(np.asarray(self.distance) > 0))
        if not np.max(self.distance) < FARTHEST:
            raise InputError(f"the {self.side} bank is {np.max(self.distance):g} m off, farther than any; give metres")
        back = np.diff(self.s) <= 0
        if back.any():
            along = float(self.s[int(back.argmax())])
            raise InputError(f"the {self.side} bank doubles back at {along:.0f} m along the centreline; mend it there")
        if not (isinstance(self.profile, tuple) and not self.profile):
            check_profile(self.profile, f"profile of the {self.side} bank")

    def wall(self, s: np.ndarray | float, depth: np.ndarray | float) -> np.ndarray:
        """Return the distance of a vertical wall with the same section of water [m], at places [m] and depths [m]."""
        return self._set_back(s, depth, wall_of)

    def keel(self, s: np.ndarray | float, clearance: np.ndarray | float) -> np.ndarray:
        """Return the distance at which a keel so far above the bottom [m] meets the bank at places [m]."""
        return self._set_back(s, clearance, keel_wall)

    def _set_back(self, s: np.ndarray | float, height: np.ndarray | float, where: Wall) -> np.ndarray:
        line = self.at(s)
        if not self.profile:
            return line
        # Measured from far away, since a profile may begin before its line.
        away = [(PROFILE_REACH + out, up) for out, up in self.profile]
        heights, index = np.unique(np.broadcast_to(height, line.shape), return_inverse=True)
        back = np.array([where(away, up) - PROFILE_REACH if up > 0 else np.nan for up in heights.tolist()])
        return np.asarray(line + back[index].reshape(line.shape))

    def at(self, s: np.ndarray | float) -> np.ndarray:
        """Return the distance [m] at places [m]; constant beyond the ends of the bank."""
        if self.drawn is not None:
            return self.drawn.distance(s)
        return np.asarray(np.interp(s, self.s, self.distance))


def bank_from_points(side: str, points: np.ndarray, line: Centreline, profile: tuple[Point, ...] = ()) -> Bank:
    """Return a bank from its own line: its distance is where the normal of the centreline first meets it."""
    # points (n, 2) [m]; profile (m, m)
    drawn = BankLine(side, points, line)
    return Bank(side, drawn.corners, drawn.distance(drawn.corners), profile, drawn)
