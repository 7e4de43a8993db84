"""Water around a moving ship, the speed that chokes the section, and a ship's mass, inertia and added mass."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from narrows.physics import squat_and_depth as formulas
from narrows.physics.hull import clarke_sway, clarke_yaw
from narrows.physics.squat_and_depth import BOUNDLESS
from narrows.quantities.arithmetic import choice, maximum, minimum
from narrows.quantities.names import Number
from narrows.ship.particulars import Configuration, Ship


class WaterUnderWay(NamedTuple):
    return_flow: Number  # Speed of the water past the ship, against its course [m/s]
    sinkage: Number  # Mean sinkage [m]
    bow: Number  # Clearance under the bow [m]
    stern: Number  # Clearance under the stern [m]


class SpeedsAfloat(NamedTuple):
    touching: Number  # Speed at which the deeper end touches the bottom; ``BOUNDLESS`` if none [m/s]
    choking: Number  # Speed at which the return flow is critical (Schijf) [m/s]


def water_under_way(values: Mapping[str, Number], speed: Number) -> WaterUnderWay:
    """Return the water around ships by particulars and section, below the choking speed; NaN above it."""
    # One-dimensional continuity and energy; the slender-body formula without banks if that gives more, as in wide
    # water.
    ship = {name: values[name] for name in ("length", "beam", "draft", "block_coefficient")}
    section = {name: values[name] for name in ("beam", "draft", "width", "depth")}
    fast, slow = np.abs(speed), np.abs(speed) < formulas.critical_speed(**section)
    below = np.where(slow, fast, 0.0)
    sinkage = np.maximum(
        formulas.continuity(below, **section), formulas.tuck_midship(below, **ship, depth=values["depth"])
    )
    deeper = formulas.deeper_end(ship["block_coefficient"])  # The other end sinks by 2 less this
    full, still = is_full(ship["block_coefficient"]), values["depth"] - values["draft"]
    found = (
        formulas.return_flow(below, **section), sinkage,
        still - sinkage * np.where(full, deeper, 2 - deeper), still - sinkage * np.where(full, 2 - deeper, deeper),
    )  # fmt: skip
    return WaterUnderWay(*(np.where(slow, one, np.nan) for one in found))


def speeds_afloat(values: Mapping[str, Number]) -> SpeedsAfloat:
    length, beam, draft, block = (values[name] for name in ("length", "beam", "draft", "block_coefficient"))
    width, depth = values["width"], values["depth"]
    mean = maximum(depth - draft, 0.0) / formulas.deeper_end(block)
    touching = minimum(
        formulas.speed_that_sinks(mean, beam, draft, width, depth),
        formulas.speed_that_sinks_midship(mean, length, beam, draft, block, depth),
    )
    choking = formulas.critical_speed(beam, draft, width, depth)
    return SpeedsAfloat(minimum(choice(choking - touching, touching, BOUNDLESS), BOUNDLESS), choking)


def is_full(block_coefficient: Number) -> Number:
    """Return whether a ship sinks most at the bow; a fine one does at the stern."""
    return np.asarray(block_coefficient) >= formulas.TRIMLESS


def displacement(configuration: Configuration) -> float:
    ship = configuration.ship
    return configuration.water.density * ship.length * ship.beam * ship.draft * ship.block_coefficient


def wetted_surface(ship: Ship) -> float:
    """Return the wetted surface of a hull by Denny and Mumford's formula [m2]."""
    return ship.length * (1.7 * ship.draft + ship.block_coefficient * ship.beam)


def ship_mass(configuration: Configuration) -> float:
    return configuration.ship.mass or displacement(configuration)


def ship_inertia(configuration: Configuration) -> float:
    """Return the yaw inertia of a ship, with the least radius of gyration, 0.2 L, if not given [kg m2]."""
    ship = configuration.ship
    return ship.inertia or ship_mass(configuration) * (0.2 * ship.length) ** 2


def added_sway(configuration: Configuration) -> float:
    """Return the added mass in sway in deep water by Clarke's formula [kg]."""
    ship = configuration.ship
    return clarke_sway(ship.length, ship.beam, ship.draft, ship.block_coefficient, configuration.water.density)


def added_yaw(configuration: Configuration) -> float:
    """Return the added inertia in yaw in deep water by Clarke's formula [kg m2]."""
    ship = configuration.ship
    return clarke_yaw(ship.length, ship.beam, ship.draft, ship.block_coefficient, configuration.water.density)
