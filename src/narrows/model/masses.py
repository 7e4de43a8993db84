"""Mass and inertia of a ship, given or estimated, and its added mass in deep water."""

from narrows.physics.hull import clarke_sway, clarke_yaw
from narrows.ship.particulars import Configuration, Ship

# Least radius of gyration over length, for a ship without a given inertia.
SLENDEREST = 0.2


def displacement(configuration: Configuration) -> float:
    """Return the mass of the water that a ship displaces at rest [kg]."""
    ship = configuration.ship
    return configuration.water.density * ship.length * ship.beam * ship.draft * ship.block_coefficient


def wetted_surface(ship: Ship) -> float:
    """Return the wetted surface of a hull by Denny and Mumford's formula [m2]."""
    return ship.length * (1.7 * ship.draft + ship.block_coefficient * ship.beam)


def ship_mass(configuration: Configuration) -> float:
    """Return the mass of a ship, estimated from its displacement if not given [kg]."""
    return configuration.ship.mass or displacement(configuration)


def ship_inertia(configuration: Configuration) -> float:
    """Return the yaw inertia of a ship, with the least radius of gyration if not given [kg m2]."""
    ship = configuration.ship
    return ship.inertia or ship_mass(configuration) * (SLENDEREST * ship.length) ** 2


def added_sway(configuration: Configuration) -> float:
    """Return the added mass in sway in deep water by Clarke's formula [kg]."""
    ship = configuration.ship
    return clarke_sway(ship.length, ship.beam, ship.draft, ship.block_coefficient, configuration.water.density)


def added_yaw(configuration: Configuration) -> float:
    """Return the added inertia in yaw in deep water by Clarke's formula [kg m2]."""
    ship = configuration.ship
    return clarke_yaw(ship.length, ship.beam, ship.draft, ship.block_coefficient, configuration.water.density)
