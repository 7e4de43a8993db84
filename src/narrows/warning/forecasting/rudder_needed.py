"""The rudder that holds a ship where it is, against a bank that is as strong as it is estimated to be."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from narrows.control.local_water import local_water
from narrows.control.self_propulsion import with_propulsion
from narrows.control.steady_course import RUDDER, solved
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


def rudder_needed(
    ship: SimulatedShip, waterway: "Waterway | None", at: Mapping[str, float], positions: Mapping[str, float]
) -> float:
    """Return the rudder of the steady course at a place [rad]; infinite where there is none."""
    # at [m]; positions [1/s]
    model = ship.model
    water = local_water(model, waterway, at["x"] if waterway is not None else 0.0)
    offset = at["y"] - water.middle
    if abs(offset) >= (water.width - model.configuration.ship.beam) / 2 or not at["u"] > 0.0:
        return math.inf
    bank = at.get("bank", 1.0)
    banks = {term.name: bank * model.coefficients[term.name] for term in model.terms.terms if term.from_bank}
    place = {"path_curvature": water.curvature / (1.0 - water.curvature * at["y"]), "current": water.current}
    turns = {name: value for name, value in positions.items() if name != RUDDER}
    turning = with_propulsion(model, {**turns, "u": at["u"]})
    values = {**ship.values(), **banks, **water.sections, **place, **turning, "y": offset}
    _, rudder = solved(ship, values, 1, 1)
    return float(rudder[0]) if math.isfinite(rudder[0]) else math.inf
