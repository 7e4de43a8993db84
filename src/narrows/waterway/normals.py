"""The normals of a centreline, and where they first meet a polyline on one side of it."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from narrows.waterway.centreline import Centreline

# Pairs of a normal and a point looked at together.
AT_ONCE = 4_000_000


@dataclass(frozen=True)
class Normals:
    """The normals of a centreline to one side, and a polyline beside it, or several end to end."""

    line: Centreline  # The centreline
    points: np.ndarray  # (n, 2) East and north of the polyline's points, no two in a row one place [m]
    sign: int  # 1 for normals to starboard, -1 to port
    # Pieces between two points that are not drawn, where one polyline ends and the next begins
    gaps: np.ndarray = field(default_factory=lambda: np.empty(0, int))

    def met(self, s: np.ndarray | float, piece: np.ndarray) -> np.ndarray:
        """Return how far along normals pieces of the polyline are [m], from end to end of each piece and no farther."""
        # s [m]
        position, ahead = self.line.frame(s)
        across = self.sign * np.stack([ahead[..., 1], -ahead[..., 0]], axis=-1)
        start, stop = self.points[piece] - position, self.points[piece + 1] - position
        before, after = (start * ahead).sum(axis=-1), (stop * ahead).sum(axis=-1)
        share = np.clip(before / np.where(before == after, 1.0, before - after), 0, 1)
        return np.asarray((1 - share) * (start * across).sum(axis=-1) + share * (stop * across).sum(axis=-1))

    def first(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return how far off the normals at places meet the polyline first [m], and which piece of it."""
        # s (n,) [m]
        # Infinite and -1 where they meet none.
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
        """Return where normals pass a point of the polyline that they may see, and the line's ends [m]."""
        # Between two of them the normals meet one and the same piece first, or none.
        fine, places = self.line.fine, [np.array([0.0, self.line.length])]
        for part in self._parts(len(fine) - 1):
            cell, point = np.nonzero(np.diff(self._behind(fine[part.start : part.stop + 1]), axis=0))
            cell += part.start
            s, n = self.line.foot((fine[cell] + fine[cell + 1]) / 2, self.points[point])
            # A bank beyond the centre of a bend is refused: what is there needs no corners.
            places.append(s[(self.sign * n > 0) & (self.line.curvature(s) * n < 1)])
        return np.unique(np.clip(np.concatenate(places), 0, self.line.length))

    def _parts(self, count: int) -> Iterator[slice]:
        many = max(1, AT_ONCE // len(self.points))
        return (slice(start, min(start + many, count)) for start in range(0, count, many))

    def _behind(self, s: np.ndarray) -> np.ndarray:
        """Which points are behind the normals at places, (places, points)."""
        position, ahead = self.line.frame(s)
        return np.asarray(ahead @ self.points.T <= (position * ahead).sum(axis=1, keepdims=True))
