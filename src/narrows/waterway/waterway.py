"""A waterway: a centreline, two banks, depths, a current and a level; a straight canal is its simplest case."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import narrows
from narrows.aliases import accept_aliases
from narrows.errors import InputError
from narrows.results import BaseSummary
from narrows.ship.particulars import Canal, Ship
from narrows.waterway.banks import Bank
from narrows.waterway.centreline import Centreline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STATIONS = 2000
# Depth greater than any sea's [m].
DEEPEST = 12_000.0
# Speed greater than any current [m/s].
FASTEST = 100.0


# Length over radius below which a line counts as straight, due to rounding.
STRAIGHT = 1e-6


class Section(NamedTuple):
    """A waterway at some places, as the local straight canal."""

    width: np.ndarray  # Width from bank to bank [m]
    middle: np.ndarray  # Middle of the two banks, to starboard of the centreline [m]
    depth: np.ndarray  # Depth of the water; NaN if unknown [m]
    curvature: np.ndarray  # Curvature of the centreline, to starboard [1/m]


@dataclass(frozen=True, repr=False)
class Waterway(BaseSummary):
    """A waterway.

    Parameters
    ----------
    line : Centreline
        The centreline.
    starboard, port : Bank
        The banks.
    depths : pair of arrays [m], optional
        Places along the line, and the depth at each.
    current : float [m/s]
        Speed of the water along the line.
    level : float [m]
        Level of the water above that of the depths.
    name : str
        Name.
    origin : pair of float [deg], optional
        Longitude and latitude of east 0, north 0.
    step : float [m], optional
        Spacing of the nodes of the simulation's table, which is linear between them; default: a quarter of the ship's
        beam, which locates a contact within a hundredth of the beam.

    Raises
    ------
    InputError
        If a sloped bank has no depth, the line's radius is smaller than the banks' distance, or a depth is missing or
        not positive; the sentence names the place.

    Examples
    --------
    >>> nw.straight_waterway(nw.Canal(300.0, 16.0), 5000.0).canal(100.0).width
    300.0
    """

    line: Centreline
    starboard: Bank
    port: Bank
    depths: tuple[np.ndarray, np.ndarray] | None = None
    current: float = 0.0
    level: float = 0.0
    name: str = "waterway"
    origin: tuple[float, float] | None = None
    step: float | None = None

    def __post_init__(self) -> None:
        for what in ("current", "level"):
            if np.ndim(getattr(self, what)) or np.asarray(getattr(self, what)).dtype.kind not in "iuf":
                raise InputError(
                    f"{self.name}: the {what} is one number for the waterway; cut it into reaches where it changes"
                )
        if not (abs(self.current) < FASTEST and abs(self.level) < DEEPEST):
            raise InputError(
                f"{self.name}: a current of {self.current} m/s, a level of {self.level} m; give numbers of a waterway"
            )
        if self.depths is None and (self.starboard.profile or self.port.profile):
            raise InputError(f"{self.name}: a bank with a profile needs depths of the water; give them")
        s = np.linspace(0, self.line.length, STATIONS)
        bend = self.line.curvature(s)
        reach = np.where(bend > 0, self.starboard.at(s), self.port.at(s))
        sharpest = int((np.abs(bend) * reach).argmax())
        if abs(bend[sharpest]) * reach[sharpest] >= 1:
            along, radius = s[sharpest], 1 / abs(bend[sharpest])
            raise InputError(
                f"{self.name}: at {along:.0f} m along it the centreline bends with a radius of {radius:.0f} m, inside "
                "its own bank; give more points there, or smoother ones"
            )
        if self.depths is not None:
            wet = np.asarray(self.depths[1], float) + self.level
            hole = ~(np.isfinite(wet) & (wet > 0))
            if hole.any():
                along = float(np.asarray(self.depths[0])[int(hole.argmax())])
                remedy = "fill the hole in the depths" if not self.level else f"raise the level of {self.level:g} m"
                raise InputError(f"{self.name}: no depth of water at {along:.0f} m along it; {remedy}")
            if wet.max() > DEEPEST:
                raise InputError(f"{self.name}: a depth of {wet.max():.6g} m is in no sea; give it in metres")

    @classmethod
    def from_geojson(cls, path: str | Path) -> "Waterway":
        """Read a waterway from a file, as ``read_waterway`` does.

        Parameters
        ----------
        path : str or Path
            The file.
        """
        return narrows.read_waterway(path)

    def plot(self, ax: "Axes | None" = None) -> "Figure":
        """Draw its banks on a map.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; a new figure unless given.
        """
        return narrows.report.figure_of(self, ax)

    @property
    def place(self) -> str:
        """Its place on earth, by which a map with latitude before longitude is recognised; empty if unknown."""
        if self.origin is None:
            return ""
        east, north = self.origin
        return f"about {abs(north):.2f} {'NS'[north < 0]}, {abs(east):.2f} {'EW'[east < 0]}"

    def summary(self) -> str:
        """Describe its length, width, depth, sharpest bend and current."""
        there = self.section(np.linspace(0, self.line.length, STATIONS))
        bend = float(np.abs(there.curvature).max())
        parts = [
            f"{self.line.length:.4g} m long", f"{_between(there.width)} m wide",
            "without a depth" if np.isnan(there.depth).all() else f"{_between(there.depth)} m deep",
            f"sharpest bend of {1 / bend:.3g} m radius" if bend * self.line.length > STRAIGHT else "straight",
        ]  # fmt: skip
        current = f", current {self.current:g} m/s" if self.current else ""
        return f"{self.name}{self.place and f' ({self.place})'}: {', '.join(parts)}{current}"

    def section(self, s: np.ndarray | float) -> Section:
        """Return the waterway at places along its line.

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        """
        depth = self.depth(s)
        return self._section(s, self.starboard.wall(s, depth), self.port.wall(s, depth), depth)

    def room(self, s: np.ndarray | float, draft: float) -> Section:
        """Return the waterway at places with the width available to a keel; equal to ``section`` at vertical banks.

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        draft : float [m]
            Draft of the ship.
        """
        depth = self.depth(s)
        starboard, port = (
            np.fmin(bank.wall(s, depth), bank.keel(s, depth - draft)) for bank in (self.starboard, self.port)
        )
        return self._section(s, starboard, port, depth)

    def depth(self, s: np.ndarray | float) -> np.ndarray:
        """Return the depth of the water at places [m], NaN if unknown.

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        """
        if self.depths is None:
            return np.full(np.shape(s), np.nan)
        return np.asarray(np.interp(s, *self.depths) + self.level)

    def _section(self, s: np.ndarray | float, starboard: np.ndarray, port: np.ndarray, depth: np.ndarray) -> Section:
        return Section(starboard + port, (starboard - port) / 2, depth, self.line.curvature(s))

    def canal(self, s: float) -> Canal:
        """Return the local straight canal at a place.

        Parameters
        ----------
        s : float [m]
            Along the line.
        """
        here = self.section(s)
        depth = float(here.depth)
        return Canal(float(here.width), None if np.isnan(depth) else depth)

    def to_channel(
        self, positions: np.ndarray, heading: np.ndarray | float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Convert positions and headings from the map: place along and off the line [m], heading to it [rad].

        Parameters
        ----------
        positions : array (..., 2) [m]
            East and north.
        heading : array or float [rad]
            Clockwise from north.
        """
        s, n, along = self.line.placed(positions)
        return s, n, _turned(np.asarray(heading) - along)

    def to_map(
        self, s: np.ndarray | float, n: np.ndarray | float, psi: np.ndarray | float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Convert places and headings to the map: east and north (..., 2) [m], heading [rad].

        Parameters
        ----------
        s : array or float [m]
            Along the line.
        n : array or float [m]
            Offset to starboard of the line.
        psi : array or float [rad]
            Heading to the line, positive to starboard.
        """
        positions, along = self.line.pose(s, n)
        return positions, _turned(np.asarray(psi) + along)

    def check_fits(self, ship: Ship, at: float | None = None) -> None:
        """Raise if a ship does not fit.

        Parameters
        ----------
        ship : Ship
            The ship.
        at : float [m], optional
            Place along the line; the whole of it unless given.

        Raises
        ------
        InputError
            If the waterway is narrower or shallower than the ship; the sentence names the place.
        """
        s = np.linspace(0, self.line.length, STATIONS) if at is None else np.array([at])
        here = self.room(s, ship.draft)
        for what, room, need in (("wide", here.width, ship.beam), ("deep", here.depth, ship.draft)):
            short = room <= need
            if short.any():
                worst = int(np.nanargmin(room))
                raise InputError(
                    f"{self.name}: {room[worst]:.4g} m {what} at {s[worst]:.0f} m along it, where {ship.name} needs "
                    f"more than {need:g} m"
                )

    def with_water(self, current: float = 0.0, level: float = 0.0) -> "Waterway":
        """Return the waterway with another current and level.

        Parameters
        ----------
        current : float [m/s]
            Along the line.
        level : float [m]
            Level above that of the depths.
        """
        return replace(self, current=current, level=level)


def _turned(angle: np.ndarray) -> np.ndarray:
    """Wrap angles to between -pi and pi."""
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


@accept_aliases
def straight_waterway(canal: Canal, length: float, heading: float = 0.0) -> Waterway:
    """Return a straight canal as a waterway.

    Parameters
    ----------
    canal : Canal
        Its width and depth.
    length : float [m]
        Length from end to end.
    heading : float [rad]
        Clockwise from north.

    Raises
    ------
    InputError
        If the length is not positive.

    Examples
    --------
    >>> canal = nw.straight_waterway(nw.Canal(300.0, 16.0), 5000.0)
    >>> print(canal.summary())
    canal: 5000 m long, 300 m wide, 16 m deep, straight
    """
    if not length > 0:
        raise InputError(f"a waterway {length} m long is none; give its length in metres")
    ends = np.array([[0.0, 0.0], [length * np.sin(heading), length * np.cos(heading)]])
    s, half = np.array([0.0, length]), np.full(2, canal.width / 2)
    depths = None if canal.depth is None else (s, np.full(2, canal.depth))
    return Waterway(Centreline(ends), Bank("starboard", s, half), Bank("port", s, half), depths, name="canal")


def _between(values: np.ndarray) -> str:
    """Return the lowest and highest, once if they are equal."""
    return " to ".join(dict.fromkeys(f"{end:.4g}" for end in (float(np.nanmin(values)), float(np.nanmax(values)))))
