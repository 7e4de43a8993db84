"""The ship, the canal with its section, and the water: frozen, in SI, checked at creation."""

import math
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.results import Aliased, BaseSummary
from narrows.ship.actuators import STANDARD, Part, Propeller, Rudder, SteeringGear
from narrows.ship.checks import check_fields, check_particulars


@accept_aliases
@dataclass(frozen=True, repr=False)
class Ship(BaseSummary):
    """A hull's main particulars.

    Raises an InputError if a particular is not a positive number or the block coefficient is over 1.

    Examples
    --------
    >>> nw.Ship(length=230.0, beam=32.2, draft=10.8, block_coefficient=0.65).length
    230.0
    """

    length: float  #: Length between perpendiculars [m]
    beam: float  #: Moulded beam [m]
    draft: float  #: Draft at rest [m], T0
    block_coefficient: float  #: Displaced volume over length x beam x draft [1]
    mass: float | None = None  #: Displacement [kg]
    inertia: float | None = None  #: Yaw moment of inertia about midship [kg m2]
    x_g: float | None = None  #: Position of the centre of gravity [m], forward of midship
    #: Ratio of the flow across the rudder to that across the stern [1], over the rudder's flow along; for terms of the
    #: rudder
    flow_straightening: float | None = None
    name: str = "ship"  #: Name in reports

    def __post_init__(self) -> None:
        check_fields(self, {entry.name: entry.name for entry in fields(self) if entry.name != "name"}, "ship")
        if not isinstance(self.name, str):
            raise InputError(f"[ship] name = {shown(self.name)} must be a word; put it in quotes")

    def summary(self) -> str:
        return f"{self.in_words}, block coefficient {self.block_coefficient:.4g}"

    def to_dict(self) -> dict[str, Any]:
        """Return the known values by name, as in a ship file."""
        return given_values(self)

    @property
    def in_words(self) -> str:
        """Name and size for titles and messages."""
        return f"{self.name}, {self.length:.4g} x {self.beam:.4g} x {self.draft:.4g} m"


@accept_aliases
@dataclass(frozen=True)
class Canal(Aliased):
    """A straight canal between two vertical walls.

    Raises an InputError if a value is not a positive number.

    Examples
    --------
    >>> nw.Canal(width=300.0, depth=16.0).in_words
    'a canal 300 m wide, 16 m deep'
    """

    width: float  #: Distance from wall to wall [m]
    depth: float | None = None  #: Water depth [m]

    def __post_init__(self) -> None:
        check_fields(self, {"width": "width", "depth": "depth"}, "canal")

    @property
    def in_words(self) -> str:
        """Width and depth for titles and messages."""
        deep = "of unknown depth" if self.depth is None else f"{_metres(self.depth)} deep"
        return f"a canal {_metres(self.width)} wide, {deep}"


def _metres(length: float) -> str:
    return f"{length:.{max(4, len(str(int(length))))}g} m"  # At least four digits, and no power of ten


@accept_aliases
@dataclass(frozen=True)
class Water(Aliased):
    """The water; the default is fresh.

    Raises an InputError if the density is not a number near that of water.

    Examples
    --------
    >>> nw.Water(density=1025.0).density
    1025.0
    """

    density: float = 1000.0  #: Mass density [kg/m3]

    def __post_init__(self) -> None:
        check_fields(self, {"density": "density"}, "water")
        if self.density is not None and not 900 <= self.density <= 1300:  # From hot and fresh water to the Dead Sea
            raise InputError(
                f"[water] density = {self.density:g} is of no water; give kg/m3: 1000 is fresh, 1025 the sea's"
            )


# Default gear: as slow as the rules allow.
RULE_GEAR = SteeringGear()


@accept_aliases
@dataclass(frozen=True, repr=False)
class Configuration(BaseSummary):
    """A ship in its canal and water: all data of a test except the motion.

    Raises an InputError if the ship is wider than the canal or draws more than the depth, or a section is given twice.

    Examples
    --------
    >>> configuration = nw.Configuration(nw.Ship(200.0, 30.0, 10.0, 0.65), nw.Canal(300.0, 15.0))
    >>> configuration.canal.width
    300.0
    """

    ship: Ship  #: The hull
    canal: Canal  #: The banks, and the depth if it is constant
    water: Water = Water()  #: The water
    #: Water depth of each condition of a table with several [m]
    depths: Mapping[str, float] = field(default_factory=dict)
    steering: SteeringGear | None = None  #: Steering gear; the default ``gear`` is that of the rules
    propeller: Propeller | None = None  #: Propeller for terms of the MMG standard method
    rudder: Rudder | None = None  #: Rudder for terms of the MMG standard method
    others: tuple[Part, ...] = ()  #: The user's own actuator sections
    notes: tuple[str, ...] = field(default=(), compare=False)  #: Values that a file did not give, and what is assumed

    def __post_init__(self) -> None:
        sections = [part.SECTION for part in (self.steering, self.propeller, self.rudder, *self.others) if part]
        for name in sections:
            if sections.count(name) > 1:
                raise InputError(f"[{name}] is given twice; keep one")
        draft, beam = self.ship.draft, self.ship.beam
        check_particulars({"beam": beam, "draft": draft, "width": self.canal.width, "depth": self.canal.depth})
        for label, depth in self.depths.items():
            check_particulars({"draft": draft, "depth": depth}, {"depth": f"[depths] {label}"})

    def summary(self) -> str:
        driven = f"; with {', '.join(self.parts)}" if self.parts else ""
        return f"{self.ship.in_words}, in {self.canal.in_words}{driven}"

    def to_dict(self) -> dict[str, Any]:
        """Return the known values by section and name, as in a ship file."""
        depths = {"depths": dict(self.depths)} if self.depths else {}
        sections = {"ship": self.ship, "canal": self.canal, "water": self.water, **self.parts}
        return {name: given_values(part) for name, part in sections.items()} | depths

    @property
    def gear(self) -> SteeringGear:
        """The steering gear: as given, or as slow as the rules allow."""
        return self.steering or RULE_GEAR

    @property
    def parts(self) -> dict[str, Part]:
        """Sections of the actuators."""
        given = (self.steering, self.propeller, self.rudder, *self.others)
        return {part.SECTION: part for part in given if part is not None}

    def with_parts(self, parts: Iterable[Part]) -> "Configuration":
        """Return the configuration with other sections of actuators, ``parts``; those of other names stay."""
        new = {**self.parts, **{part.SECTION: part for part in parts}}
        fixed: dict[str, Any] = {name: new.pop(name, None) for name in ("steering", "propeller", "rudder")}
        return replace(self, **fixed, others=tuple(new.values()))

    def values(self) -> dict[str, float]:
        """Every particular by its name, for the arguments of terms.

        For every actuator this includes ``<name>_limit`` and ``<name>_rate``, infinite if unknown, and the position
        from its section.
        """
        return dict(self._values)

    @cached_property
    def _values(self) -> dict[str, float]:
        named = asdict(self.ship) | asdict(self.canal) | asdict(self.water)
        actuated = (self.gear, *self.parts.values())
        for name in (*(actuator.name for actuator in STANDARD), *(part.POSITION for part in actuated)):
            named |= {f"{name}_limit": math.inf, f"{name}_rate": math.inf}
        for part in actuated:
            named |= part.values()
        return {name: value for name, value in named.items() if value is not None}


def given_values(part: Any) -> dict[str, Any]:
    return {name: value for name, value in asdict(part).items() if value is not None}


class Configured:
    """An object with a configuration, and shortcuts to its parts."""

    configuration: Configuration

    @property
    def ship(self) -> Ship:
        """The hull, which is accepted where its canal is needed too."""
        ship = copy(self.configuration.ship)
        vars(ship)["_configuration"] = self.configuration
        return ship

    @property
    def canal(self) -> Canal:
        """The banks, and the depth if it is constant."""
        return self.configuration.canal

    @property
    def water(self) -> Water:
        """The water."""
        return self.configuration.water


Point = tuple[float, float]


def equivalent_wall(profile: Sequence[Point], depth: float) -> float:
    """Return the distance of a vertical wall that gives the same cross-section of water [m].

    The water from the origin to the last point keeps its area; the bank's area in it reduces the width.

    Raises an InputError if the points do not go outward, or no water is left.

    Parameters
    ----------
    profile : sequence of (m, m)
        Points of the bank: distance from the origin and height above the bottom, outward from the toe. The last point
        is a wall or the end of the slope at the water surface.
    depth : float [m]
        Depth of the water.

    Examples
    --------
    >>> round(nw.equivalent_wall([(10.0, 0.0), (20.0, 8.0)], depth=5.0), 2)
    13.12
    """
    check_profile(profile, "bank")
    return wall_of(profile, depth)


def wall_of(profile: Sequence[Point], depth: float) -> float:
    """Return the equivalent wall of a checked profile [m]."""
    if not depth > 0:
        raise InputError(f"a depth of {depth} m is no water; give it in metres")
    wall = profile[-1][0]
    for (start, low), (stop, high) in pairwise(profile):
        # Mean depth of the water above a straight piece of bank
        wet, end = max(depth - low, 0.0), max(depth - high, 0.0)
        above = wet if high == low else (wet - end) * (wet + end) / (2 * (high - low))
        wall -= (stop - start) * (1 - above / depth)
    if not wall > 0:
        raise InputError(f"the bank {list(profile)} leaves no water {depth} m deep; check both")
    return wall


def keel_wall(profile: Sequence[Point], clearance: float) -> float:
    # profile (m, m); clearance [m]
    for (start, low), (stop, high) in pairwise(profile):
        if high >= clearance:
            return start if low >= clearance else start + (stop - start) * (clearance - low) / (high - low)
    return profile[-1][0]


# Distance and height beyond those of any bank [m].
PROFILE_REACH = 1e4


def check_profile(profile: Any, what: str) -> None:
    """Raise if the points of a bank are not pairs of distance and height, outward and above the bottom."""
    try:
        points = np.array(profile, float)
    except (TypeError, ValueError, OverflowError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise InputError(f"the {what} {shown(profile)} needs two points or more, each distance and height; mend it")
    for out, up in points:
        if not (abs(out) < PROFILE_REACH and 0 <= up < PROFILE_REACH):
            raise InputError(f"the {what} has the point {out:g}, {up:g}: give metres, none below the bottom")
    if (back := np.diff(points[:, 0]) < 0).any():
        raise InputError(
            f"the {what} turns back at {points[int(back.argmax()), 0]:g} m; give its points outward from the toe"
        )


def half_swept(ship: Ship, heading: np.ndarray | float) -> np.ndarray:
    """Return the distance of a hull's corners to either side of midship [m]."""
    return np.asarray(ship.length / 2 * np.abs(np.sin(heading)) + ship.beam / 2 * np.cos(heading))
