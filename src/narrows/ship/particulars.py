"""The ship, the canal and the water: frozen, in SI, checked when made."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields

from narrows.ship.actuators import Propeller, Rudder, SteeringGear
from narrows.ship.checks import check_particulars, flat


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
        check_particulars(flat(self, (own.name for own in fields(self) if own.name != "name")))


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
        check_particulars(flat(self, ("width", "depth")))


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
        check_particulars(flat(self, ("density",)))


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
        draft, beam = self.ship.draft, self.ship.beam
        check_particulars({"beam": beam, "draft": draft, "width": self.canal.width, "depth": self.canal.depth})
        for label, depth in self.depths.items():
            check_particulars({"draft": draft, "depth": depth}, {"depth": f"[depths] {label}"})

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
