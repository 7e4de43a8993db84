"""A waterway: a centreline, two banks, depths, a current and a level; a straight canal is its simplest case."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import narrows
from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.results import BaseSummary
from narrows.ship.particulars import Canal, Ship
from narrows.waterway.banks import Bank
from narrows.waterway.centreline import Centreline, Profile, checked_profile, extent, nodes_of, profile_at

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STATIONS = 2000
# Depth greater than any sea's [m].
DEEPEST = 12_000.0
# Length over radius below which a line counts as straight, due to rounding.
STRAIGHT = 1e-6
# Length of a bend whose radius is given, over the width: shorter ones hardly turn a ship, and show scattered points.
BEND_WIDTHS = 2.0


class Section(NamedTuple):
    """A waterway at some places, as the local straight canal."""

    width: np.ndarray  # Width from bank to bank [m]
    middle: np.ndarray  # Middle of the two banks, to starboard of the centreline [m]
    depth: np.ndarray  # Depth of the water; NaN if unknown [m]
    curvature: np.ndarray  # Curvature of the centreline, to starboard [1/m]


@accept_aliases
@dataclass(frozen=True, repr=False, init=False)
class Waterway(BaseSummary):
    """A waterway: a line, or its points east and north [m], with banks and depths.

    Raises an InputError if a sloped bank has no depth, the line's radius is smaller than the banks' distance, or a
    depth is missing or not positive; the sentence names the place.

    Parameters
    ----------
    width, depth : float or sequence [m], optional
        In place of banks and depths, with vertical banks: one number, or one for each point of the line.

    Examples
    --------
    >>> bend = nw.Waterway([(0, 0), (0, 2000), (500, 4000)], width=[300, 280, 320], depth=16)
    >>> round(bend.canal(0.0).width)
    300
    """

    line: Centreline  #: The centreline
    starboard: Bank  #: The bank to starboard
    port: Bank  #: The bank to port
    depths: tuple[np.ndarray, np.ndarray] | None = None  #: Places along the line [m], and the depth at each
    #: Speed of the water along the line at its beginning, from where the same discharge passes every section; or (place
    #: [m], speed [m/s]) pairs, linear between places
    current: Profile = 0.0
    level: float = 0.0  #: Water level above the datum of the depths [m]
    name: str = "waterway"  #: Name
    origin: tuple[float, float] | None = None  #: Longitude and latitude [deg] of east 0, north 0
    #: Spacing of the nodes of the simulation's table [m], which is linear between them; default: a quarter of the
    #: ship's beam, which locates a contact within a hundredth of the beam
    step: float | None = None
    current_across: Profile = 0.0  #: Speed of the water to starboard of the line [m/s], everywhere or as pairs
    current_shear: Profile = 0.0  #: Rise of the speed along the line for each metre to starboard of it [1/s], likewise

    def __init__(
        self, line: Any, starboard: Bank | None = None, port: Bank | None = None,
        depths: tuple[np.ndarray, np.ndarray] | None = None, current: Profile = 0.0, level: float = 0.0,
        name: str = "waterway", origin: tuple[float, float] | None = None, step: float | None = None,
        current_across: Profile = 0.0, current_shear: Profile = 0.0, *, width: Any = None, depth: Any = None,
    ) -> None:  # fmt: skip
        own = {name: value for name, value in locals().items() if name not in ("self", "width", "depth")}
        if not isinstance(line, Centreline):
            own["line"] = line = Centreline(line)
        if width is not None:
            own |= {side: Bank(side, *_along(line, np.divide(width, 2))) for side in ("starboard", "port")}
        if depth is not None:
            own["depths"] = _along(line, depth)
        if own["starboard"] is None or own["port"] is None:
            raise InputError(f"{name}: a line alone is no waterway; give its width, or the bank on both sides")
        vars(self).update(own)
        self._check()

    def _check(self) -> None:
        for name in ("current", "current_across", "current_shear"):
            checked_profile(self.name, name, getattr(self, name))
        is_number = isinstance(self.level, int | float | np.number) and not isinstance(self.level, bool)
        if not is_number or not abs(self.level) < DEEPEST:
            raise InputError(f"{self.name}: the level of {shown(self.level)} m is not one number; give metres")
        if self.depths is None and (self.starboard.profile or self.port.profile):
            raise InputError(f"{self.name}: a bank with a profile needs depths of the water; give them")
        s = self._stations
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
                remedy = "give metres over 0 everywhere" if not self.level else f"raise the level of {self.level:g} m"
                raise InputError(f"{self.name}: no depth of water at {along:.0f} m along it; {remedy}")
            if wet.max() > DEEPEST:
                raise InputError(f"{self.name}: a depth of {wet.max():.6g} m is deeper than any sea; give it in metres")

    def plot(self, ax: "Axes | None" = None) -> "Figure":
        """Draw its banks on a map, on Matplotlib axes ``ax`` or in a new figure."""
        return narrows.report.figure_of(self, ax)

    @property
    def place(self) -> str:
        """Its place on earth; empty if unknown."""
        if self.origin is None:
            return ""
        east, north = self.origin
        return f"about {abs(north):.2f} {'NS'[north < 0]}, {abs(east):.2f} {'EW'[east < 0]}"

    @property
    def place_check(self) -> str:
        """Its place on earth, for the reader to check: a map with latitude first is elsewhere; empty if unknown."""
        return self.place and f"{self.place}: if that is the wrong place, latitude and longitude are swapped"

    @property
    def _stations(self) -> np.ndarray:
        return np.linspace(0, self.line.length, STATIONS)

    @cached_property
    def current_pairs(self) -> tuple[tuple[float, float], ...]:
        """Pairs of place [m] and speed [m/s] of the current; empty if continuity gives it."""
        current = checked_profile(self.name, "current", self.current)
        return current if isinstance(current, tuple) else ()

    @property
    def reference_current(self) -> float:
        """The speed that ``flow`` multiplies: that at the beginning, or the largest of the pairs [m/s]."""
        pairs: Any = self.current_pairs or ((0.0, self.current),)
        return float(max((speed for _, speed in pairs), key=abs))

    def flow(self, s: np.ndarray | float) -> np.ndarray:
        """Return the current at places ``s`` [m] over ``reference_current`` [1].

        By continuity it is inverse to the section.
        """
        if self.current_pairs:
            return np.asarray(np.interp(s, *np.transpose(self.current_pairs)) / (self.reference_current or 1.0))
        begin, there = self.section(0.0), self.section(s)
        deeper = 1.0 if self.depths is None else begin.depth / there.depth
        return np.asarray(begin.width / there.width * deeper)

    @property
    def has_current_field(self) -> bool:
        """True if its current has a component across, or a shear."""
        return bool(np.any(self.current_across) or np.any(self.current_shear))

    def current_at(self, s: np.ndarray | float, y: np.ndarray | float = 0.0) -> np.ndarray:
        """Return the speed of the water along the line [m/s] at places ``s``, and ``y`` to starboard of it [m]."""
        return np.asarray(self.reference_current * self.flow(s) + profile_at(self.current_shear, s) * y)

    def summary(self) -> str:
        there, sharpest, s = self.section(self._stations), self.sharpest_bend, self._stations
        length = self.line.length
        parts = [
            f"{length:{'.4g' if length < 1e3 else '.0f'}} m long", f"{extent(there.width)} m wide",
            "without a depth" if np.isnan(there.depth).all() else f"{extent(there.depth)} m deep",
            "straight" if sharpest is None else
            "sharpest bend of {0:.3g} m radius over {2:.3g} m at {1:.0f} m".format(*sharpest),
        ]  # fmt: skip
        columns = {
            "current {} m/s": self.current_at(s), "current across {} m/s": profile_at(self.current_across, s),
            "shear of the current {} 1/s": profile_at(self.current_shear, s),
        }  # fmt: skip
        parts += [words.format(extent(column)) for words, column in columns.items() if column.any()]
        return f"{self.name}{self.place and f' ({self.place})'}: {', '.join(parts)}"

    @property
    def sharpest_bend(self) -> tuple[float, float, float] | None:
        """Radius of the sharpest bend, its place and the length that the radius is of [m]; none if straight."""
        length = min(BEND_WIDTHS * float(np.median(self.section(self._stations).width)), self.line.length)
        bend, at = self.line.sharpest_bend(length)
        return (1 / bend, at, length) if bend * self.line.length > STRAIGHT else None

    def section(self, s: np.ndarray | float, draft: float | None = None) -> Section:
        """Return the waterway at places ``s`` along its line [m].

        With a ``draft`` [m] the width is that available to its keel; it is the same between vertical banks.
        """
        starboard, port = self._walls(s, depth := self.depth(s), draft)
        return Section(starboard + port, (starboard - port) / 2, depth, self.line.curvature(s))

    def _walls(
        self, s: np.ndarray | float, depth: np.ndarray, draft: float | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return distances to starboard and port [m], with a draft [m] those of the contact of its keel."""

        def wall(bank: Bank) -> np.ndarray:
            there = bank.wall(s, depth)
            return there if draft is None or not bank.profile else np.fmin(there, bank.keel(s, depth - draft))

        return wall(self.starboard), wall(self.port)

    def depth(self, s: np.ndarray | float) -> np.ndarray:
        """Return the depth of the water at places ``s`` along the line [m], NaN if unknown."""
        if self.depths is None:
            return np.full(np.shape(s), np.nan)
        return np.asarray(np.interp(s, *self.depths) + self.level)

    def canal(self, s: float) -> Canal:
        """Return the local straight canal at a place ``s`` along the line [m]."""
        here = self.section(s)
        depth = float(here.depth)
        return Canal(float(here.width), None if np.isnan(depth) else depth)

    def to_channel(
        self, positions: np.ndarray, heading: np.ndarray | float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Convert ``positions`` (..., 2), east and north [m], and a ``heading`` from north [rad] of a map.

        Return the place along and off the line [m], and the heading to it [rad].
        """
        s, n = self.line.locate(positions)
        return s, n, _turned(np.asarray(heading) - self.line.heading(s))

    def to_map(
        self, s: np.ndarray | float, n: np.ndarray | float, psi: np.ndarray | float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Convert places ``s``, offsets to starboard ``n`` [m] and headings ``psi`` to the line [rad].

        Return east and north (..., 2) [m], and the heading [rad].
        """
        return self.line.at(s, n), _turned(np.asarray(psi) + self.line.heading(s))

    def check_fits(self, ship: Ship, at: float | None = None) -> None:
        """Raise an InputError that names the place if the waterway is narrower or shallower than a ``ship``.

        Only the place ``at`` [m] along the line is checked if it is given.
        """
        s = self._stations if at is None else np.array([at])
        here = self.section(s, ship.draft)
        for what, size, need in (("wide", here.width, ship.beam), ("deep", here.depth, ship.draft)):
            short = size <= need
            if short.any():
                worst = int(np.nanargmin(size))
                raise InputError(
                    f"{self.name}: {size[worst]:.4g} m {what} at {s[worst]:.0f} m along it, where {ship.name} needs "
                    f"more than {need:g} m"
                )

    def with_water(
        self, current: Profile | None = None, level: float | None = None, current_across: Profile | None = None,
        current_shear: Profile | None = None,
    ) -> "Waterway":  # fmt: skip
        """Return the waterway with another ``current``, ``level``, ``current_across`` or ``current_shear``.

        Units and forms are those of the waterway; what is not given stays.
        """
        own = {"current": current, "level": level, "current_across": current_across, "current_shear": current_shear}
        return replace(self, **{name: value for name, value in own.items() if value is not None})  # type: ignore[arg-type]


def _turned(angle: np.ndarray) -> np.ndarray:
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


@accept_aliases
def straight_waterway(canal: Canal, length: float = 10_000.0, heading: float = 0.0) -> Waterway:
    """Return a straight canal as a waterway.

    Raises an InputError if the length is not positive.

    Parameters
    ----------
    canal : Canal
        Its width and depth.
    length : float [m]
        Length from end to end; 10 km unless given.
    heading : float [rad]
        Clockwise from north.

    Examples
    --------
    >>> canal = nw.straight_waterway(nw.Canal(300.0, 16.0), 5000.0)
    >>> print(canal.summary())
    canal: 5000 m long, 300 m wide, 16 m deep, straight
    """
    if not isinstance(canal, Canal):
        raise InputError(f"canal = {shown(canal)} is no canal; give nw.Canal(width, depth) in metres, then the length")
    if not length > 0:
        raise InputError(f"the length of a waterway must be positive, not {length} m")
    ends = [[0.0, 0.0], [length * np.sin(heading), length * np.cos(heading)]]
    return Waterway(ends, name="canal", width=canal.width, depth=canal.depth)


def _along(line: Centreline, sizes: Any) -> tuple[np.ndarray, np.ndarray]:
    """Places along a line [m], its ends or its points, and the size at each."""
    places = line.locate(line.points)[0] if np.ndim(sizes) else np.array([0.0, line.length])
    if np.ndim(sizes) and len(sizes) != len(places):
        raise InputError(f"{len(sizes)} sizes for {len(places)} points of a line; give one for each, or one number")
    return places, np.full(len(places), sizes, float)


@dataclass(frozen=True)
class WaterwayTable:
    """A waterway in equal cells; between nodes its columns and its banks on the map are linear."""

    s: np.ndarray  # (n,) Along the line, from 0 to its length [m]
    starboard: np.ndarray  # (n,) Distance from the line to a vertical wall with the same section of water [m]
    port: np.ndarray  # (n,) Distance from the line to a vertical wall with the same section of water [m]
    # (n,) Distance from the line to contact of keel and bank, or to the wall if that is nearer [m]
    keel_starboard: np.ndarray
    keel_port: np.ndarray  # (n,) Distance from line to contact of keel and bank, or nearer wall [m]
    depth: np.ndarray  # (n,) Depth; NaN if unknown [m]
    curvature: np.ndarray  # (n,) Curvature of the line, to starboard [1/m]
    flow: np.ndarray  # (n,) Current along the line over that of the waterway [1]
    across: np.ndarray | float = 0.0  # (n,) Current to starboard of the line [m/s]
    shear: np.ndarray | float = 0.0  # (n,) Rise of the current along the line to starboard [1/s]

    @property
    def step(self) -> float:
        return float(self.s[-1]) / (len(self.s) - 1)

    @cached_property
    def track(self) -> np.ndarray:
        """Nodes of line and banks in the table's own frame, (n + 2) * 9: ``narrows.waterway.bank_clearance.ROW``."""
        # The origin and forward axis are those of the first node. The first row and the last are far beyond the ends,
        # where line and banks are straight.
        far = self.s[-1] + 100 * max(self.keel_starboard.max(), self.keel_port.max())
        x, y, heading = nodes_of(self.curvature, self.step)
        c, si = np.cos(heading), np.sin(heading)
        line = np.stack([x, y, c, si, self.curvature], axis=1)
        beyond = line[[0, -1]]
        beyond[:, :2] += np.array([[-far], [far]]) * beyond[:, 2:4]
        line = np.concatenate([beyond[:1], line, beyond[1:]])
        walls = np.pad(np.stack([self.keel_starboard, -self.keel_port], axis=1), ((1, 1), (0, 0)), mode="edge")
        banks = [line[:, :2] + wall[:, None] * line[:, [3, 2]] * [-1, 1] for wall in walls.T]
        return np.concatenate([line, *banks], axis=1).reshape(-1)


def least_walls(table: WaterwayTable, outline: np.ndarray) -> np.ndarray:
    """Return lower bounds of the distance at which a hull meets the bank to starboard and to port, for any heading."""
    # (2, nodes) [m], linear between nodes; outline (points, 2) [m].
    # With midship at s and n, let w be the bound at s, linear between nodes, and r the extent
    # of the hull's outline to that side: then w - n - r (to port w + n - r) is at most the distance that the hull can
    # move perpendicular to the line before it meets that bank. If it is positive the hull is clear.
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    radius, step = float(np.hypot(*np.reshape(outline, (-1, 2)).T).max()), table.step
    reach = 2 * (radius + step)
    size = 2 * int(np.ceil(reach / step)) + 1
    bend, bounds = maximum_filter1d(np.abs(table.curvature), size, mode="nearest"), []
    for wall, curvature in ((table.keel_starboard, table.curvature), (table.keel_port, -table.curvature)):
        inside, outside, widest = (
            maximum_filter1d(one, size, mode="nearest") for one in (curvature.clip(0.0), (-curvature).clip(0.0), wall)
        )
        narrowest = minimum_filter1d(wall, size, mode="nearest")
        # A point of the bank at a distance d along the line is ahead by d (1 - (bend d)^2/6 - w inside) at least. The
        # farthest one beside the hull, with an edge of the bank more, and for midship anywhere in the cells next to it:
        share = 1 - (bend * reach) ** 2 / 6 - widest * inside
        far = radius / np.maximum(share, 1e-9) + 2 * step
        # The line turns away from a bank outside its bend, and the normals turn.
        least = narrowest - far**2 / 2 * (outside + widest * bend**2)
        bounds.append(np.where(far <= reach, least, -widest))
    return np.array(bounds)


# Largest number of cells in a table.
MOST_CELLS = 1_000_000
# Cells per beam of the ship that keep contact within 0.01 of the beam. A kink of a bank by a slope m between nodes errs
# by m step / 4 (1:10: 0.006 of the beam), a sudden start of a bend by 0.005 of it, the chord of a bank in a bend by
# curvature step^2 / 8 (radius of 30 beams: 0.0003).
STEPS_A_BEAM = 4


def tabulate(waterway: Waterway, draft: float, step: float) -> WaterwayTable:
    length = waterway.line.length
    if not (0 < step < np.inf and 0 < draft < np.inf):
        raise InputError(f"{waterway.name}: a step of {step} m and a draft of {draft} m; give lengths over 0")
    if length / step > MOST_CELLS:
        raise InputError(f"{waterway.name}: {step} m between nodes is too fine for {length:.6g} m; give a longer step")
    s = np.linspace(0, length, int(np.ceil(length / step)) + 1)
    depth = waterway.depth(s)
    return WaterwayTable(
        s, *waterway._walls(s, depth), *waterway._walls(s, depth, draft), depth, waterway.line.curvature(s),
        waterway.flow(s), profile_at(waterway.current_across, s), profile_at(waterway.current_shear, s),
    )  # fmt: skip
