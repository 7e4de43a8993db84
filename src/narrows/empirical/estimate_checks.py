"""Checks of what an estimate is made from: types, units and proportions, each with the place and the remedy."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from narrows.empirical.propulsion import ShipType, service_speed
from narrows.errors import InputError, shown
from narrows.quantities.names import GRAVITY, KNOT
from narrows.ship.actuators import Part, Propeller, Rudder, SteeringGear
from narrows.ship.checks import is_finite, speed_hint
from narrows.ship.particulars import Canal, Ship, Water

SHORTEST, LONGEST = 1.0, 500.0  # Length of a ship or a model [m]
# At a block coefficient of 1 some formulas have no value.
SHAPES = {"L/B": (2.5, 15.0), "B/T": (1.2, 15.0), "block coefficient": (0.3, 0.98)}
# Service speed over the usual one: a speed in knots is 1.94 times that in m/s.
FASTEST_OVER_USUAL = 1.8


# A particular, a size of the ship and its words, the widest range of their ratio (a wrong unit is outside), a remedy.
Proportion = tuple[str, float, float, str, tuple[float, float], str]


def check_types(ship: object, canal: object, water: object, **parts: object) -> None:
    """Raise if an argument is of another type; parts may be missing."""
    if not isinstance(ship, Ship | Mapping):
        raise InputError(f"ship = {shown(ship)} is no ship; give nw.Ship(length, beam, draft, block_coefficient)")
    types = {"canal": Canal, "water": Water, "propeller": Propeller, "rudder": Rudder, "steering": SteeringGear}
    given = {"canal": canal, "water": water, **{name: part for name, part in parts.items() if part is not None}}
    for name, value in given.items():
        if not isinstance(value, types[name]):
            raise InputError(f"{name} = {shown(value)} is of another type; give nw.{types[name].__name__}(...)")


def check_shape(ship: Ship) -> None:
    """Raise if the dimensions are no ship's: a wrong unit, or two of them exchanged."""
    if not SHORTEST <= ship.length <= LONGEST:
        raise InputError(
            f"[ship] length = {ship.length:g} m is outside {SHORTEST:g} to {LONGEST:g} m, and no ship's; give metres, "
            "not feet, millimetres or kilometres"
        )
    ratios = (ship.length / ship.beam, ship.beam / ship.draft, ship.block_coefficient)
    places = (f"length {ship.length:g} m, beam {ship.beam:g} m", f"beam {ship.beam:g} m, draft {ship.draft:g} m", "")
    for (name, (low, high)), value, place in zip(SHAPES.items(), ratios, places, strict=True):
        if not low <= value <= high:
            where = f" ({place})" if place else ""
            raise InputError(
                f"{name} = {value:.3g}{where} is outside {low:g} to {high:g}; check the dimensions and units"
            )


def check_speed(speed: Any, ship: Ship, kind: ShipType) -> None:
    """Raise if the service speed is none, or in knots."""
    if not is_finite(speed):
        remedy = speed_hint(speed) or "; give it in m/s"
        raise InputError(f"a service speed of {shown(speed)} is not a finite number{remedy}")
    ordinary = service_speed(ship, kind)
    if speed > FASTEST_OVER_USUAL * ordinary:
        raise InputError(
            f"a service speed of {speed:.4g} m/s is {speed / ordinary:.2g} times that of a usual {kind.words} of this "
            f"length, {ordinary:.3g} m/s; numbers are m/s, and {speed:.4g} knots are {speed * KNOT:.3g} m/s"
        )


def check_proportions(ship: Ship, water: Water, parts: Mapping[str, Part | None]) -> None:
    """Raise if a particular is out of proportion to the ship: another unit, or a share of the ship."""
    for place, value, size, of, (low, high), remedy in (*_of_mass(ship, water), *_of_parts(ship, parts)):
        if not low * size <= value <= high * size:
            raise InputError(
                f"{place} = {value:.4g} is {value / size:.3g} times {of}, outside {low:g} to {high:g}; {remedy}"
            )


def _of_mass(ship: Ship, water: Water) -> Iterator[Proportion]:
    displaced = water.density * ship.block_coefficient * ship.length * ship.beam * ship.draft
    if ship.mass is not None:
        yield "[ship] mass", ship.mass, displaced, "the displaced water", (0.7, 1.4), "give it in kg"
    if ship.inertia is not None:
        square = (ship.mass or displaced) * ship.length**2
        yield "[ship] inertia", ship.inertia, square, "mass x length^2", (0.02, 0.2), "give it in kg m2"
    if ship.x_g is not None:
        yield "[ship] x_g", ship.x_g, ship.length, "the length", (-0.1, 0.1), "give metres forward of midship"


def _of_parts(ship: Ship, parts: Mapping[str, Any]) -> Iterator[Proportion]:
    propeller, rudder, steering = (parts[name] for name in ("propeller", "rudder", "steering"))
    if propeller is not None:
        diameter, pace = propeller.diameter, math.sqrt(GRAVITY * ship.length) / propeller.diameter
        yield "[propeller] diameter", diameter, ship.draft, "the draft", (0.15, 1.2), "give it in metres"
        remedy, words = "give revolutions per second, not per minute", "(g L)^(1/2) over the diameter"
        yield "[propeller] revolutions", propeller.revolutions, pace, words, (0.0, 1.5), remedy
    if rudder is not None:
        lateral, remedy = ship.length * ship.draft, "give it in m2, not as a share"
        yield "[rudder] area", rudder.area, lateral, "L x T", (0.005, 0.1), remedy
    if steering is not None:
        remedy = "give degrees, not radians"
        yield "[steering] limit_deg", steering.limit_deg, 35.0, "the usual 35 degrees", (0.1, 2.6), remedy
