"""Models without dimensions: every factor comes from the dimension of its term."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.quantities.constants import GRAVITY
from narrows.quantities.dimensions import Dimension
from narrows.ship.particulars import Configuration

System = Literal["prime1", "prime2", "bis"]
SYSTEMS = get_args(System)


@dataclass(frozen=True)
class Units:
    """A unit of mass, of length and of time."""

    mass: float  # One unit of mass [kg]
    length: float  # One unit of length [m]
    time: float  # One unit of time [s]

    def factor(self, dimension: Dimension) -> float:
        """Return one unit of a quantity of some dimension, in SI."""
        return float(self.mass**dimension.mass * self.length**dimension.length * self.time**dimension.time)


def units_of(configuration: Configuration, system: System, speed: float | None = None) -> Units:
    """Return the units of a nondimensional system."""
    # speed [m/s]
    # SNAME (1950), Nomenclature for treating the motion of a submerged body through a fluid; Norrbin (1970) for bis.
    ship, density = configuration.ship, configuration.water.density
    if system not in SYSTEMS:
        raise InputError(f"nondimensional system {system!r} is unknown; choose {', '.join(SYSTEMS)}")
    if system == "bis":
        displaced = density * ship.block_coefficient * ship.length * ship.beam * ship.draft
        return Units(ship.mass or displaced, ship.length, float((ship.length / GRAVITY) ** 0.5))
    if not (speed and 0 < speed < float("inf")):
        raise InputError(f"system {system} measures time by the speed; give a positive one")
    depth = ship.length if system == "prime1" else ship.draft
    return Units(density / 2 * ship.length**2 * depth, ship.length, ship.length / speed)


def nondimensional(model: Model, system: System = "prime2", speed: float | None = None) -> dict[str, float]:
    """Return a model's coefficients without dimensions.

    Parameters
    ----------
    model : Model
        The model.
    system : str
        ``prime1``, ``prime2`` or ``bis``.
    speed : float [m/s], optional
        For the prime systems.

    Raises
    ------
    InputError
        Where the system is unknown or lacks a speed.
    """
    units = units_of(model.configuration, system, speed)
    return {n: v / units.factor(model.terms[n].dimension) for n, v in model.coefficients.items()}


def dimensional(
    numbers: Mapping[str, float], model: Model, system: System = "prime2", speed: float | None = None
) -> Model:
    """Return a model with coefficients that are given without dimensions.

    Parameters
    ----------
    numbers : mapping of str to float [1]
        The coefficients.
    model : Model
        Gives the ship, the terms and all else; its own coefficients go.
    system : str
        ``prime1``, ``prime2`` or ``bis``.
    speed : float [m/s], optional
        For the prime systems.

    Raises
    ------
    InputError
        Where the system is unknown, lacks a speed, or a coefficient is missing or unknown.
    """
    units = units_of(model.configuration, system, speed)
    known = {n: v * units.factor(model.terms[n].dimension) for n, v in numbers.items() if n in model.terms.names}
    unknown = {n: v for n, v in numbers.items() if n not in known}
    return replace(model, coefficients=known | unknown, covariance=None)
