"""What plays a part in a voyage: what would change nothing is refused, for whoever gives it means something by it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from narrows.errors import InputError
from narrows.ship.actuator import places_of
from narrows.simulation.inputs import INPUTS, START
from narrows.simulation.ship import SimulatedShip

OF_THE_HULL = ("length", "beam", "width")
# What a Coriolis force asks for.
OF_THE_BODY = ("mass", "inertia", "x_g")
# What changes nothing where it is 0, whatever the model.
NOTHING_AT_REST = ("X", "rudder", "heave")


def check_felt(ship: SimulatedShip, asked: Mapping[str, Any]) -> None:
    """Raise where something is given that changes nothing."""
    terms = ship.model.terms
    felt = {*START, *INPUTS, *terms.inputs, *terms.names, *OF_THE_HULL, *places_of(terms.actuators)}
    felt |= {actuator.name for actuator in terms.actuators} | (set(OF_THE_BODY) if ship.coriolis else set())
    felt -= {"X"} if ship.surge == "held" else set()
    for name, value in asked.items():
        if name not in felt and not (name in NOTHING_AT_REST and not np.any(value)):
            remedy = "give surge='free', or leave it out" if name == "X" else "leave it out"
            why = "the speed is held" if name == "X" else "no term of this model feels it"
            raise InputError(f"{name} changes nothing here: {why}; {remedy}")
