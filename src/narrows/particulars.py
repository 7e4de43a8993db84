"""The ship, the canal and the water: frozen, in SI, checked when made."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from narrows.errors import InputError, did_you_mean

PLACES = {"Ship": "ship", "Canal": "canal", "Water": "water", "SteeringGear": "steering"}
"""The section of a file that gives each part."""


def _check_positive(owner: object, names: tuple[str, ...]) -> None:
    for name in names:
        place, value = f"[{PLACES.get(type(owner).__name__, '')}] {name}", getattr(owner, name)
        if value is None:
            continue
        _check_number(place, value)
        if value <= 0:
            raise InputError(f"{place} = {value} must be positive, in SI units")


def _check_number(place: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{place} = {value!r} is not a finite number; give it in SI units")


@dataclass(frozen=True)
class Ship:
    """A hull's main particulars.

    Parameters
    ----------
    length : float [m]
        Between perpendiculars.
    beam : float [m]
        Moulded beam.
    draft : float [m]
        Draft at rest, T0.
    block_coefficient : float [1]
        Displaced volume over length x beam x draft.
    mass : float [kg], optional
        Displacement.
    inertia : float [kg m2], optional
        Yaw moment of inertia about midship.
    x_g : float [m], optional
        Centre of gravity, forward of midship.
    flow_straightening : float [1], optional
        Flow across the rudder over that across the stern, over the rudder's flow along; for terms of the rudder.
    name : str, optional
        What the ship is called in reports.

    Raises
    ------
    InputError
        Where a particular is not a positive number or the block coefficient is over 1.
    """

    length: float
    beam: float
    draft: float
    block_coefficient: float
    mass: float | None = None
    inertia: float | None = None
    x_g: float | None = None
    flow_straightening: float | None = None
    name: str = "ship"

    def __post_init__(self) -> None:
        _check_positive(self, ("length", "beam", "draft", "block_coefficient", "mass", "inertia", "flow_straightening"))
        if self.x_g is not None:
            _check_number("[ship] x_g", self.x_g)
        if self.block_coefficient > 1:
            raise InputError(f"[ship] block_coefficient = {self.block_coefficient} is over 1; it is a fraction")


@dataclass(frozen=True)
class Canal:
    """A straight canal between two vertical walls.

    Parameters
    ----------
    width : float [m]
        From wall to wall.
    depth : float [m], optional
        Water depth.

    Raises
    ------
    InputError
        Where a value is not a positive number.
    """

    width: float
    depth: float | None = None

    def __post_init__(self) -> None:
        _check_positive(self, ("width", "depth"))


@dataclass(frozen=True)
class Water:
    """The water; fresh unless said otherwise.

    Parameters
    ----------
    density : float [kg/m3]
        Mass density.

    Raises
    ------
    InputError
        Where the density is not a positive number.
    """

    density: float = 1000.0

    def __post_init__(self) -> None:
        _check_positive(self, ("density",))


@dataclass(frozen=True)
class SteeringGear:
    """What turns the rudder; unless said otherwise as slow as the rules allow a ship.

    Parameters
    ----------
    limit_deg : float [deg]
        Largest rudder angle.
    rate_deg : float [deg/s]
        Of the rudder.

    Raises
    ------
    InputError
        Where a value is not a positive number, or the limit is beyond 90 degrees.

    References
    ----------
    SOLAS regulation II-1/29.3.2: from 35 degrees on one side to 30 on the other in 28 s.
    """

    limit_deg: float = 35.0
    rate_deg: float = 65 / 28

    def __post_init__(self) -> None:
        _check_positive(self, ("limit_deg", "rate_deg"))
        if self.limit_deg > 90:
            raise InputError(f"[steering] limit_deg = {self.limit_deg} is beyond 90 degrees; check it")

    @property
    def limit(self) -> float:
        """Largest rudder angle [rad]."""
        return math.radians(self.limit_deg)

    @property
    def rate(self) -> float:
        """Rate of the rudder [rad/s]."""
        return math.radians(self.rate_deg)


@dataclass(frozen=True)
class Setting:
    """A ship in her canal and water: everything about a test but the motion.

    Parameters
    ----------
    ship : Ship
        The hull.
    canal : Canal
        The banks, and the depth where it is one number.
    water : Water
        The water.
    depths : mapping of str to float [m], optional
        Water depth of each condition of a table that holds several.
    steering : SteeringGear, optional
        What turns the rudder; ``gear`` is the rules' where it is not given.

    Raises
    ------
    InputError
        Where the ship is wider than the canal or draws more than the depth.
    """

    ship: Ship
    canal: Canal
    water: Water = Water()
    depths: Mapping[str, float] = field(default_factory=dict)
    steering: SteeringGear | None = None

    def __post_init__(self) -> None:
        if self.ship.beam >= self.canal.width:
            raise InputError(
                f"[ship] beam = {self.ship.beam} m does not fit in [canal] width = {self.canal.width} m; "
                "check both, in metres and at one scale"
            )
        named = {f"[depths] {label}": depth for label, depth in self.depths.items()}
        for name, depth in {"[canal] depth": self.canal.depth, **named}.items():
            if depth is None:
                continue
            _check_number(name, depth)
            if depth <= self.ship.draft:
                raise InputError(
                    f"{name} = {depth} m leaves no water under [ship] draft = {self.ship.draft} m; check both"
                )

    @property
    def gear(self) -> SteeringGear:
        """What turns the rudder: as given, or as slow as the rules allow."""
        return self.steering or SteeringGear()

    def values(self) -> dict[str, float]:
        """Every particular by its name, as the arguments that terms ask for."""
        parts = (asdict(part) for part in (self.ship, self.canal, self.water))
        return {name: value for part in parts for name, value in part.items() if value is not None}


SECTIONS = {"ship": Ship, "canal": Canal, "water": Water, "steering": SteeringGear}
NEEDED = ("ship", "canal", "water")
"""Sections that are made of their defaults where they are absent."""


def read_ship(path: str | Path) -> Setting:
    """Read a ship file: TOML with [ship], [canal], and optionally [water] and [depths].

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Setting
        Ship, canal and water.

    Raises
    ------
    InputError
        Where the file is absent, is not TOML, or a key is missing, unknown or out of range.
    """
    return setting_from(load_toml(path), str(path))


def load_toml(path: str | Path) -> dict[str, Any]:
    """Load a TOML file, or say in one sentence why it cannot be (ours).

    Parameters
    ----------
    path : str or Path
        The file.

    Raises
    ------
    InputError
        Where the file is absent or is not TOML.
    """
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the path") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not valid TOML ({error}); mend it there") from None


def setting_from(tables: Mapping[str, Any], place: str) -> Setting:
    """Make a Setting of the [ship], [canal], [water] and [depths] tables of a file (ours).

    Parameters
    ----------
    tables : mapping
        The parsed file.
    place : str
        The file's name, for messages.

    Raises
    ------
    InputError
        Where a key is missing, unknown or out of range.
    """
    known = {*SECTIONS, "depths"}
    for name, table in tables.items():
        if name not in known:
            raise InputError(f"{place}: unknown section [{name}]{did_you_mean(name, known)}")
        check_table(name, table, place)
    try:
        parts = {
            name: _section(cls, name, tables.get(name, {}))
            for name, cls in SECTIONS.items()
            if name in {*tables, *NEEDED}
        }
        return Setting(**parts, depths=dict(tables.get("depths", {})))
    except InputError as error:
        raise InputError(f"{place}: {error}") from None


def check_table(name: str, table: object, place: str) -> None:
    """Raise where what should be a section of a file is a bare value (ours).

    Parameters
    ----------
    name : str
        Of the section.
    table : object
        What stands there.
    place : str
        The file.

    Raises
    ------
    InputError
        Names the section.
    """
    if not isinstance(table, Mapping):
        raise InputError(f"{place}: {name} = {table!r} must be a section; write [{name}] and its keys under it")


def _section(cls: type, name: str, values: Mapping[str, Any]) -> Any:
    known = {f.name: f for f in fields(cls)}
    for key in values:
        if key not in known:
            raise InputError(f"[{name}] has an unknown key {key!r}{did_you_mean(key, known)}")
    try:
        return cls(**values)
    except TypeError:
        required = [key for key in ("length", "beam", "draft", "block_coefficient", "width") if key in known]
        missing = [key for key in required if key not in values]
        raise InputError(f"[{name}] lacks {', '.join(missing)}; add it, in SI units") from None
