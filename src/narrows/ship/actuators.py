"""Propeller, rudder, steering gear, and the actuators that they form."""

import math
from collections.abc import Callable, Iterable
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any, ClassVar, Self

import numpy as np

from narrows.base.errors import InputError
from narrows.base.named_values import by_name
from narrows.base.results import Aliased
from narrows.quantities.names import FORCES, PARTICULARS, REGRESSOR_INPUTS, Dimension, Number, Quantity, dimension_of
from narrows.ship.checks import check_fields

# Sections of ship files and of model files that belong to no actuator.
SHIP_SECTIONS = ("ship", "canal", "water", "depths")
MODEL_SECTIONS = ("terms", "coefficients", "covariance", "data_range", "source", "verdicts")


def number_in(unit: str, meaning: str, default: Any = MISSING) -> Any:
    """Return a field of a section: a number with its unit and meaning."""
    return field(default=default, metadata={"quantity": Quantity(unit, meaning)})


@dataclass(frozen=True)
class Part(Aliased):
    """A section of a ship file for an actuator; subclasses are frozen dataclasses of numbers (``number_in``)."""

    # Name of the section, and prefix of the names of its numbers but ``limit`` and ``rate``.
    SECTION: ClassVar[str] = ""
    # Name of the actuator's position; a number of that name is its position unless it is moved.
    POSITION: ClassVar[str] = ""
    # True if terms may use its numbers.
    ASKED: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_fields(self, {entry.name: self.known_as(entry.name) for entry in fields(self)}, self.SECTION)

    @classmethod
    def numbers(cls) -> dict[str, Quantity]:
        return {entry.name: entry.metadata["quantity"] for entry in fields(cls)}

    @classmethod
    def known_as(cls, number: str) -> str:
        """Return the name in the terms of a number of the section; ``limit`` and ``rate`` are of the position."""
        if number == cls.POSITION:
            return number
        return f"{cls.POSITION if number in ('limit', 'rate') else cls.SECTION}_{number}"

    def values(self) -> dict[str, float]:
        """Every number by its name in the terms and the equations of motion."""
        return {self.known_as(entry.name): getattr(self, entry.name) for entry in fields(self)}

    def scaled(self, factor: Callable[[Dimension], float]) -> Self:
        """Return the section at another size: each number scales by the dimension of its unit."""
        changed: dict[str, Any] = {
            name: getattr(self, name) * factor(dimension)
            for name, quantity in self.numbers().items()
            if (dimension := dimension_of(quantity.unit)) != Dimension()
        }
        return replace(self, **changed)


@dataclass(frozen=True)
class Propeller(Part):
    """A propeller of the MMG standard method.

    Ahead K_T = k_0 + k_1 J + k_2 J^2, astern a_0 + a_1 J + a_2 (J^2 + 0.49)^(1/2) + k_2 J^2; with zeros the thrust
    astern is unknown, and revolutions astern are refused. ``with_astern_thrust`` gives those of a series.

    Raises an InputError if a number is not finite, a size is not positive, the wake is not a fraction, or revolutions
    are astern and the thrust is known ahead only.

    Examples
    --------
    >>> nw.Propeller(6.0, 1.5, 0.3, 0.4, -0.4, 0.0).diameter
    6.0
    """

    SECTION: ClassVar[str] = "propeller"
    POSITION: ClassVar[str] = "revolutions"

    diameter: float = number_in("m", "propeller diameter D_P")
    revolutions: float = number_in("1/s", "propeller revolutions n")
    wake: float = number_in("1", "wake fraction at the propeller straight ahead w_P0")
    thrust_0: float = number_in("1", "K_T at no advance k_0")
    thrust_1: float = number_in("1", "slope of K_T by the advance k_1")
    thrust_2: float = number_in("1", "curvature of K_T by the advance k_2")
    position: float = number_in("1", "propeller forward of midship over L, x_P'", -0.5)
    wake_rate: float = number_in("1", "rate of the wake's decrease in a turn C_1", 0.0)
    wake_starboard: float = number_in("1", "inflow turning to starboard (beta_P > 0) over inflow straight C_2", 1.0)
    wake_port: float = number_in("1", "inflow turning to port over inflow straight C_2", 1.0)
    astern_0: float = number_in("1", "K_T astern a_0", 0.0)
    astern_1: float = number_in("1", "slope of K_T astern by the advance a_1", 0.0)
    astern_2: float = number_in("1", "rise of K_T astern beyond an advance of 0.7 a_2", 0.0)

    @property
    def turns_astern(self) -> bool:
        """True if the thrust astern is known."""
        return any((self.astern_0, self.astern_1, self.astern_2))


@dataclass(frozen=True)
class Rudder(Part):
    """A rudder of the MMG standard method.

    Raises an InputError if a number is not finite, or a size is not positive.

    Examples
    --------
    >>> nw.Rudder(40.0, 2.7, 1.0, 0.5, 0.7, -0.9, 0.4, 0.4).area
    40.0
    """

    SECTION: ClassVar[str] = "rudder"
    POSITION: ClassVar[str] = "rudder"

    area: float = number_in("m2", "rudder area A_R")
    lift: float = number_in("1", "slope of the rudder's lift f_alpha")
    wake_ratio: float = number_in("1", "inflow at the rudder over that at the propeller epsilon")
    slipstream: float = number_in("1", "acceleration of the slipstream at the rudder kappa")
    in_slipstream: float = number_in("1", "propeller diameter over rudder height eta")
    position: float = number_in("1", "effective place of the rudder over L, l_R'")
    straightening_starboard: float = number_in("1", "flow straightening in a turn to starboard (beta_R > 0) gamma_R")
    straightening_port: float = number_in("1", "flow straightening in a turn to port gamma_R")


@dataclass(frozen=True)
class SteeringGear(Part):
    """A steering gear; the default is as slow as the rules allow.

    The gear executes an order after the dead time, moves the rudder towards it by a first-order lag no faster than its
    rate, and stays still while the rudder is within the dead band of the order.

    Raises an InputError if the limit or rate is not a positive number, the limit is beyond 90 degrees, a time or the
    dead band is negative, or there are other than 1 or 2 pumps.

    References
    ----------
    SOLAS regulation II-1/29.3.2: from 35 degrees on one side to 30 on the other in 28 s.

    Examples
    --------
    >>> nw.SteeringGear(35.0, 2.3).limit_deg
    35.0
    """

    SECTION: ClassVar[str] = "steering"
    POSITION: ClassVar[str] = "rudder"
    ASKED: ClassVar[bool] = False

    limit_deg: float = number_in("deg", "largest rudder angle", 35.0)
    rate_deg: float = number_in("deg/s", "rate of the rudder with both pumps", 65 / 28)
    dead_time: float = number_in("s", "from an order to the first motion of the rudder", 0.0)
    lag: float = number_in("s", "time constant of the servo: the rudder's rate is the remaining angle over it", 0.0)
    dead_band_deg: float = number_in("deg", "largest difference of order and rudder that moves nothing", 0.0)
    pumps: int = number_in("1", "running pumps, 1 or 2: one alone turns the rudder half as fast", 2)

    @classmethod
    def known_as(cls, number: str) -> str:
        """Return the key unchanged: terms do not use the numbers of the gear."""
        return number

    @property
    def limit(self) -> float:
        """Largest rudder angle [rad]."""
        return math.radians(self.limit_deg)

    @property
    def rate(self) -> float:
        """Rate of the rudder with the running pumps [rad/s]."""
        return math.radians(self.rate_deg) * self.pumps / 2

    @property
    def delay(self) -> float:
        """Dead time and lag together [s]: the delay of a slow order."""
        return self.dead_time + self.lag

    def values(self) -> dict[str, float]:
        """Limit [rad], rate [rad/s], dead time, lag [s] and dead band [rad] of the rudder."""
        slow = {"dead_time": self.dead_time, "lag": self.lag, "dead_band": math.radians(self.dead_band_deg)}
        return {"rudder_limit": self.limit, "rudder_rate": self.rate, **{f"rudder_{n}": v for n, v in slow.items()}}


@dataclass(frozen=True)
class Actuator:
    """An actuator moves at a command; here is what tables of tests, terms, files and scaling need of it.

    Its position is a quantity of its name. It enters the terms directly, or as cosine and sine if it is an angle.
    """

    name: str  # Name of its position: the column of a table of tests, the argument of ``forces`` and ``simulate``
    unit: str  # SI unit of its position
    meaning: str  # Meaning of its position
    angle: bool = False  # True if it enters the terms by its cosine and sine, ``cos_<name>`` and ``sin_<name>``
    rest: float | None = None  # Default position; None if it must be given
    parts: tuple[type[Part], ...] = ()  # Its sections of a ship file, each a subclass of ``Part``

    def __post_init__(self) -> None:
        taken = {**REGRESSOR_INPUTS, **FORCES, "psi": None, "t": None}
        if not (self.name.isascii() and self.name.isidentifier()) or self.name in taken:
            raise InputError(f"an actuator cannot be called {self.name!r}; give it a plain word of its own")
        dimension_of(self.unit)
        if self.angle and self.unit != "rad":
            raise InputError(f"actuator {self.name}: an angle in {self.unit}; give it in rad")
        for part in self.parts:
            section = f"actuator {self.name}: its section [{part.SECTION}]"
            if part.POSITION != self.name:
                raise InputError(f"{section} is of {part.POSITION!r}; mend it")
            if part.SECTION in ("", *SHIP_SECTIONS, *MODEL_SECTIONS):
                raise InputError(f"{section} has another meaning in ship and model files; call it otherwise")
            if not part.numbers():
                raise InputError(f"{section} has no numbers; make {part.__name__} a frozen dataclass with some")
        by_name(f"numbers of {self.name}", ((p.known_as(number), p) for p in self.parts for number in p.numbers()))

    @property
    def controls(self) -> dict[str, Quantity]:
        """Quantities of the terms for its position, with unit and meaning."""
        if not self.angle:
            return {self.name: Quantity(self.unit, self.meaning)}
        names = {f"cos_{self.name}": "cosine", f"sin_{self.name}": "sine"}
        return {name: Quantity("1", f"{word} of the {self.meaning}") for name, word in names.items()}

    @property
    def particulars(self) -> dict[str, Quantity]:
        return {
            part.known_as(number): quantity
            for part in self.parts
            if part.ASKED
            for number, quantity in part.numbers().items()
            if number != self.name
        }

    @property
    def quantities(self) -> dict[str, Quantity]:
        return self.controls | self.particulars

    def placed(self, position: Number) -> dict[str, Number]:
        if not self.angle:
            return {self.name: position}
        return {f"cos_{self.name}": np.cos(position), f"sin_{self.name}": np.sin(position)}

    def at_rest(self) -> dict[str, Number]:
        """Its default position as quantities of the terms; empty if it must be given."""
        return {} if self.rest is None else self.placed(self.rest)


RUDDER = Actuator(
    "rudder", "rad", "rudder angle, positive where it turns the bow to starboard", angle=True, rest=0.0,
    parts=(Rudder, SteeringGear),
)  # fmt: skip

PROPELLER = Actuator("revolutions", "1/s", "propeller revolutions n", parts=(Propeller,))

# Actuators of the package, in order.
STANDARD = (RUDDER, PROPELLER)


def with_standard(actuators: Iterable[Actuator] = ()) -> tuple[Actuator, ...]:
    """The package's actuators and further ones; raises an InputError if two have one name, or one section."""
    known = tuple(dict.fromkeys((*STANDARD, *actuators)))
    by_name("actuators", ((actuator.name, actuator) for actuator in known))
    by_name("sections", ((part.SECTION, part) for actuator in known for part in actuator.parts))
    return known


def particulars_with(actuators: Iterable[Actuator] = ()) -> dict[str, Quantity]:
    return PARTICULARS | {n: it for actuator in with_standard(actuators) for n, it in actuator.particulars.items()}


def places_of(actuators: Iterable[Actuator]) -> dict[str, str]:
    """Return the section and key of each number of actuators in a file."""
    return {
        part.known_as(number): f"[{part.SECTION}] {number}"
        for actuator in actuators
        for part in actuator.parts
        for number in part.numbers()
    }
