"""A centreline that bends, a cubic spline through points; the nearest place to any position; currents along it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.errors import InputError, shown
from narrows.waterway.bank_clearance import GAUSS

if TYPE_CHECKING:  # SciPy's splines are slow to load: they do where a line is used, not where a command starts
    from scipy.interpolate import PPoly
    from scipy.spatial import KDTree


# Samples between two points of the line, as starting values of the search for the nearest place.
SAMPLES_A_PIECE = 32
ROUNDS = 12
# Tolerance of the search, relative to the length of the line.
STEP = 1e-10
# Samples of the heading over the length of a bend.
BEND_SAMPLES = 32
# Root mean squares by which a track is smoothed, in shares of half the width of its waterway, as positions of a ship
# scatter by metres; that half over the radius of a smoothed bend, at most.
SMOOTHING, MOST_BENT = (0.01, 0.02, 0.05, 0.1, 0.2), 0.5
# Distance greater than any on earth [m].
FARTHEST = 1e8


@dataclass(frozen=True, eq=False)
class Centreline:
    """A smooth line through points, and places along it.

    A cubic spline over the chords with "not a knot" ends: three points make a parabola, two a straight line. Points h
    apart on a bend of radius R give its curvature to 0.71 (h / R)^2 of it at the ends and to 0.14 (h / R)^2 between,
    its heading to 0.2 (h / R)^3. Beyond its ends the line is straight.

    Raises an InputError if there are fewer than two points, two successive points coincide, or one is not finite.
    """

    points: np.ndarray  #: (n, 2) East and north, in the order of the voyage; at least two [m]

    def __post_init__(self) -> None:
        try:
            points = np.asarray(self.points, float)
        except (TypeError, ValueError, OverflowError):
            points = np.empty(0)
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
            raise InputError("a centreline needs two points or more, each east and north in metres; add some")
        object.__setattr__(self, "points", points)
        known = (np.abs(points) < FARTHEST).all(axis=1)
        if not known.all():
            raise InputError(f"point {int(known.argmin())} of the centreline is not finite, or not on earth")
        gaps = np.hypot(*np.diff(points, axis=0).T)
        if not gaps.all():
            raise InputError(
                f"points {int(gaps.argmin())} and {int(gaps.argmin()) + 1} of the centreline are one place"
            )

    @cached_property
    def _knots(self) -> np.ndarray:
        return chords(self.points)

    @cached_property
    def _spline(self) -> "PPoly":
        return _spline_through(self._knots, self.points)

    @cached_property
    def _samples(self) -> tuple[np.ndarray, np.ndarray]:
        """Parameters along the line, and the arc length to each."""
        pieces = [np.linspace(a, b, SAMPLES_A_PIECE, endpoint=False) for a, b in pairwise(self._knots)]
        t = np.append(np.concatenate(pieces), self._knots[-1])
        # Gauss-Legendre between samples: exact for the length of a cubic to rounding.
        nodes, weights = np.polynomial.legendre.leggauss(5)
        middle, half = (t[1:] + t[:-1]) / 2, np.diff(t) / 2
        speed = np.linalg.norm(self._spline(middle[:, None] + half[:, None] * nodes, 1), axis=-1)
        return t, np.concatenate([[0.0], np.cumsum((speed * weights).sum(axis=1) * half)])

    @cached_property
    def _tree(self) -> "KDTree":
        from scipy.spatial import KDTree

        return KDTree(self._spline(self._samples[0]))

    @cached_property
    def _from_distance(self) -> "PPoly":
        return _spline_through(*self._samples[::-1])

    @cached_property
    def _to_distance(self) -> "PPoly":
        return _spline_through(*self._samples)

    @property
    def length(self) -> float:
        """Length from the first point to the last along the line [m]."""
        return float(self._samples[1][-1])

    @property
    def fine(self) -> np.ndarray:
        """Places along the line, many between each two of its points [m]."""
        return self._samples[1]

    def curvature(self, s: np.ndarray | float) -> np.ndarray:
        """Return the curvature at places [m], positive to starboard [1/m]; constant beyond the ends."""
        t = np.clip(self._from_distance(s), self._knots[0], np.nextafter(self._knots[-1], 0.0))
        rate, bend = self._spline(t, 1), self._spline(t, 2)
        cross = rate[..., 0] * bend[..., 1] - rate[..., 1] * bend[..., 0]
        return np.asarray(-cross / np.linalg.norm(rate, axis=-1) ** 3)

    def sharpest_bend(self, length: float) -> tuple[float, float]:
        """Return the largest curvature of a bend of a length [m], and its place: [1/m], [m]."""
        # The curvature is the slope of the heading over the length, by least squares: a spline overshoots by an eighth
        # where a straight line meets an arc, and more where the points scatter.
        count = max(int(BEND_SAMPLES * self.length / length), BEND_SAMPLES)
        s = np.linspace(0.0, self.length, count + 1)
        offsets = s[: BEND_SAMPLES + 1] - s[BEND_SAMPLES // 2]
        slopes = np.abs(np.correlate(np.unwrap(self.heading(s)), offsets, "valid")) / (offsets @ offsets)
        return float(slopes.max()), float(s[int(slopes.argmax()) + BEND_SAMPLES // 2])

    def heading(self, s: np.ndarray | float) -> np.ndarray:
        """Return the line's heading at places [m], clockwise from north [rad]."""
        ahead = self.frame(s)[1]
        return np.asarray(np.arctan2(ahead[..., 0], ahead[..., 1]))

    def frame(self, s: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        """Return positions at places [m], (..., 2): east and north [m], and unit vectors along the line."""
        t = self._from_distance(s)
        rate = self._spline(t, 1)
        return self._spline(t), rate / np.linalg.norm(rate, axis=-1, keepdims=True)

    def at(self, s: np.ndarray | float, n: np.ndarray | float = 0.0) -> np.ndarray:
        """Return positions, (..., 2): east and north [m], at places and offsets to starboard [m]."""
        s, n = np.broadcast_arrays(np.asarray(s, float), np.asarray(n, float))
        position, ahead = self.frame(s)
        return np.asarray(position + n[..., None] * to_starboard(ahead))

    def locate(
        self, positions: np.ndarray | Sequence[float], near: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the nearest places on the line, straight beyond its ends, to positions: along and off it [m].

        With places ``near`` [m] return the feet of perpendiculars near them.
        """
        positions = np.asarray(positions, float)
        flat = positions.reshape(-1, 2)
        t = self._samples[0][self._tree.query(flat)[1]] if near is None else self._from_distance(near)
        for _ in range(ROUNDS):  # Newton's method towards the foot of the perpendicular
            apart, rate = flat - self._spline(t), self._spline(t, 1)
            speed = (rate * rate).sum(axis=1)
            steep = speed - (apart * self._spline(t, 2)).sum(axis=1)
            step = (apart * rate).sum(axis=1) / np.where(steep > 0, steep, speed)
            t = t + step
            if not (np.abs(step) > STEP * self._knots[-1]).any():
                break
        s = self._to_distance(t)
        place, ahead = self.frame(s)
        n = ((flat - place) * to_starboard(ahead)).sum(axis=1)
        return s.reshape(positions.shape[:-1]), n.reshape(positions.shape[:-1])


def line_with_room(points: np.ndarray, half_width: float) -> Centreline:
    """Return the line through points, or if it bends inside its banks, as a track does, the nearest that does not."""
    from scipy.interpolate import splev, splprep
    from scipy.spatial import KDTree

    line, most = Centreline(points), 1.0
    for share in SMOOTHING if len(points) > 3 else ():
        if np.abs(line.curvature(line.fine)).max() * half_width < most:
            break
        most = MOST_BENT
        # Scatter of fixes closer than it would lengthen the way: means of pairs, until they stand apart.
        while np.median(np.diff(chords(points))) < half_width / 4 and len(points) > 8:
            pairs = points[1:-1][: (len(points) - 2) // 2 * 2].reshape(-1, 2, 2)
            points = np.concatenate([points[:1], pairs.mean(axis=1), points[-1:]])
        # The sum of squares that a smoothing spline may leave (FITPACK), for a root mean square of this share.
        s = chords(points)
        spline: Any = splprep(points.T, u=s, s=len(points) * (share * half_width) ** 2)[0]
        places = np.linspace(0, s[-1], max(3, round(s[-1] / half_width)) + 1)
        line = Centreline(np.transpose(splev(places, spline)))
    # Banks overlap where the line crosses itself, closes, or returns within a width.
    width = 2 * half_width
    s = np.linspace(0, line.length, round(4 * line.length / width) + 2)
    pairs = KDTree(line.at(s)).query_pairs(0.99 * width, output_type="ndarray")
    far = pairs[np.abs(np.diff(s[pairs], axis=1))[:, 0] > 2 * width]
    if len(far):
        first, second = np.sort(s[far[far.max(axis=1).argmin()]])
        raise InputError(
            f"the centreline comes back to itself: its places at {first:.0f} and {second:.0f} m lie within its width; "
            f"end it at {second - width / 2:.0f} m, and give the rest as another waterway"
        )
    return line


def chords(points: np.ndarray) -> np.ndarray:
    """Return the distance of each point of a polyline along it, (n,) [m]."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])


def along_chords(points: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return places at shares of the length of a polyline, (m, 2) [m]."""
    known = chords(points)
    return np.stack([np.interp(share * known[-1], known, column) for column in points.T], axis=1)


def _spline_through(parameters: np.ndarray, values: np.ndarray) -> "PPoly":
    """Return the cubic spline through values, with straight pieces beyond both ends."""
    from scipy.interpolate import CubicSpline, PPoly

    spline = CubicSpline(parameters, values)
    first, last = spline.x[[0, -1]]
    start, slope, stop, leaving = spline(first), spline(first, 1), spline(last), spline(last, 1)
    none, span = np.zeros_like(slope), last - first
    before, after = (
        np.stack([none, none, *line])[:, None] for line in ((slope, start - span * slope), (leaving, stop))
    )
    return PPoly(np.concatenate([before, spline.c, after], axis=1), np.array([first - span, *spline.x, last + span]))


def to_starboard(ahead: np.ndarray) -> np.ndarray:
    """Unit vectors to the right of others, east and north."""
    return np.stack([ahead[..., 1], -ahead[..., 0]], axis=-1)


# A number, or pairs of a place along the line [m] and the number there, linear between places.
Profile = float | Sequence[Sequence[float]]
# Speed greater than any current [m/s], and shear greater than any [1/s].
FASTEST, STEEPEST = 100.0, 100.0


def checked_profile(waterway: str, name: str, value: Any) -> float | tuple[tuple[float, float], ...]:
    """Return a current as a float, or as pairs of place and speed that rise."""
    try:
        # Rows of different length make no float array; text and booleans would be converted to floats.
        kind, values = np.asarray(value).dtype.kind, np.asarray(value, float)
    except (TypeError, ValueError, OverflowError):
        kind, values = "O", np.array(np.nan)
    rows = values.ndim == 2 and values.shape[1] == 2 and bool((np.diff(values[:, 0]) > 0).all())
    speeds = values[:, 1] if rows else values
    largest = STEEPEST if name == "current_shear" else FASTEST
    if kind not in "iuf" or not (values.ndim == 0 or rows) or not (np.abs(speeds) < largest).all():
        what, one = name.replace("_", " "), "rise in 1/s" if name == "current_shear" else "speed in m/s"
        raise InputError(f"{waterway}: the {what} {shown(value)} is invalid; give one {one}, or (place, number) pairs")
    return tuple((float(place), float(speed)) for place, speed in values) if rows else float(values)


def check_along_only(waterway: Any, user: str) -> None:
    """Raise if the current of a waterway has a component across, or a shear, which its user does not take."""
    if waterway.has_current_field:
        remedy = "give one along the line: with_water(current_across=0, current_shear=0)"
        raise InputError(f"{waterway.name} has a current across or a shear, which {user} does not take; {remedy}")


def profile_at(profile: Profile, s: np.ndarray | float) -> np.ndarray:
    if np.ndim(profile):
        return np.asarray(np.interp(s, *np.transpose(profile)))
    return np.full(np.shape(s), profile)


def extent(values: np.ndarray) -> str:
    """Return the lowest and highest, once if they are equal."""
    return " to ".join(dict.fromkeys(f"{end:.4g}" for end in (float(np.nanmin(values)), float(np.nanmax(values)))))


def nodes_of(curvature: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return nodes and headings of a line of linear curvature between nodes: three-point Gauss-Legendre per cell."""
    heading = np.concatenate([[0.0], np.cumsum((curvature[1:] + curvature[:-1]) / 2 * step)])
    part = step * np.array([1 - GAUSS, 1, 1 + GAUSS]) / 2
    change = np.diff(curvature)[:, None] / step
    turned = heading[:-1, None] + part * (curvature[:-1, None] + part * change / 2)
    weights = step * np.array([5, 8, 5]) / 18
    x, y = (np.concatenate([[0.0], np.cumsum(f(turned) @ weights)]) for f in (np.cos, np.sin))
    return x, y, heading
