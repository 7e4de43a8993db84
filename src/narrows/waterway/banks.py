"""A bank along a centreline: its distance at every place, from its own line on a map or from distances."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from narrows.base.errors import InputError
from narrows.ship.particulars import PROFILE_REACH, Point, check_profile, keel_wall, wall_of
from narrows.waterway.centreline import FARTHEST, Centreline, along_chords, chords, to_starboard

# Share of the centreline at either end where a bank may be missing: its distance is assumed constant, with a note.
SLACK = 0.06
# Sign of an offset from the centreline to either side.
SIGNS = {"starboard": 1, "port": -1}
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
        across = self.sign * to_starboard(ahead)
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
            s, n = self.line.locate(self.points[point], near=(fine[cell] + fine[cell + 1]) / 2)
            # A bank beyond the centre of a bend is refused, so it needs no corners.
            places.append(s[(self.sign * n > 0) & (self.line.curvature(s) * n < 1)])
        return np.unique(np.clip(np.concatenate(places), 0, self.line.length))

    def _parts(self, count: int) -> Iterator[slice]:
        many = max(1, AT_ONCE // max(len(self.points), 1))
        return (slice(start, min(start + many, count)) for start in range(0, count, many))

    def _behind(self, s: np.ndarray) -> np.ndarray:
        """Return which points are behind the normals at places, (places, points)."""
        position, ahead = self.line.frame(s)
        return np.asarray(ahead @ self.points.T <= (position * ahead).sum(axis=1, keepdims=True))


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
    #: Its own line on a map, if known: it gives the distance at every place, where the normals first meet it
    drawn: Normals | None = None
    #: (n - 1,) Piece of that line that the normals between each two places of ``s`` meet
    pieces: np.ndarray | None = None

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
        if self.drawn is None or self.pieces is None:
            return np.asarray(np.interp(s, self.s, self.distance))
        s = np.clip(s, self.s[0], self.s[-1])
        piece = np.searchsorted(self.s, s, "right") - 1
        return self.drawn.met(s, self.pieces[np.clip(piece, 0, len(self.pieces) - 1)])


def bank_from_points(side: str, points: np.ndarray, line: Centreline, profile: tuple[Point, ...] = ()) -> Bank:
    """Return a bank from its own line, drawn in either direction along the whole centreline."""
    # points (n, 2) East and north [m]; profile (m, m)
    if points.ndim != 2 or points.shape[1] != 2 or not (np.abs(points) < FARTHEST).all() or not np.ptp(points, 0).any():
        raise InputError(f"the {side} bank needs two points or more on earth, each east and north; mend it")
    distinct = points[np.append(True, np.diff(points, axis=0).any(axis=1))]
    normals = Normals(line, distinct, SIGNS[side])
    known = chords(distinct)
    s, n = line.locate(along_chords(distinct, np.union1d(np.linspace(0, 1, ALONG), known / known[-1])))
    refuse_crossing(side, s, (s > 0) & (s < line.length) & ~(n * normals.sign > 0))
    corners, pieces = seen_pieces(normals, side)
    return Bank(side, corners, normals.met(corners, np.append(pieces, pieces[-1])), profile, normals, pieces)


def seen_pieces(normals: Normals, side: str, reach: float = np.inf) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a bank within reach [m], and its piece between each two; short ends without a bank are cut off."""
    # Where a bank crosses itself another piece comes first between two corners: found to the samples of the line.
    line, corners = normals.line, np.union1d(normals.corners(), normals.line.fine)
    distance, pieces = normals.first((corners[1:] + corners[:-1]) / 2)
    pieces[~(distance < reach)] = -1
    other = np.append(True, np.diff(pieces) != 0)
    corners, pieces = np.append(corners[:-1][other], corners[-1]), pieces[other]
    seen = np.flatnonzero(pieces >= 0)
    if seen.size and max(corners[seen[0]], line.length - corners[seen[-1] + 1]) <= SLACK * line.length:
        corners, pieces = corners[seen[0] : seen[-1] + 2], pieces[seen[0] : seen[-1] + 1]
    if (pieces < 0).any():
        along, within = corners[int((pieces < 0).argmax())], f" within {reach:g} m" if np.isfinite(reach) else ""
        raise InputError(
            f"no {side} bank{within} at {along:.0f} m along a centreline of {line.length:.0f} m; draw it along the "
            "whole of it" + ", or look farther" * bool(within)
        )
    return corners, pieces
