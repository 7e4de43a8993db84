"""The ship, the canal and the water: frozen, in SI, checked when made."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

from narrows.errors import InputError
from narrows.ship.actuators import Propeller, Rudder, SteeringGear
from narrows.ship.checks import check_number, check_positive


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
        check_positive(self, ("length", "beam", "draft", "block_coefficient", "mass", "inertia", "flow_straightening"))
        if self.x_g is not None:
            check_number("[ship] x_g", self.x_g)
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
        check_positive(self, ("width", "depth"))


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
        check_positive(self, ("density",))


@dataclass(frozen=True)
class Configuration:
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
    propeller : Propeller, optional
        For terms of the MMG standard method.
    rudder : Rudder, optional
        Likewise.

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
    propeller: Propeller | None = None
    rudder: Rudder | None = None

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
            check_number(name, depth)
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
        plain = (self.ship, self.canal, self.water)
        named = {name: value for part in plain for name, value in asdict(part).items()}
        for prefix, part in (("propeller", self.propeller), ("rudder", self.rudder)):
            named |= {f"{prefix}_{name}": value for name, value in (asdict(part) if part else {}).items()}
        if self.propeller:
            named["revolutions"] = named.pop("propeller_revolutions")
        return {name: value for name, value in named.items() if value is not None}
