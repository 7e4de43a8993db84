"""The helm of a page: a regulator that can be switched on and off, and a rudder that stays where it is put."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice
from narrows.simulation.controllers import Named

if TYPE_CHECKING:
    from narrows.control.regulator_law import Regulator

SWITCH, ORDERED = "steers", "ordered"
"""Numbers of the law beside the regulator's: over 0 where it steers, and the rudder where it does not."""


@dataclass(frozen=True)
class SwitchedHelm:
    """A regulator that steers, or does not: a law in arithmetic.

    Parameters
    ----------
    regulator : Regulator
        What steers where it is on.
    """

    regulator: "Regulator"

    def parameters(self) -> Mapping[str, Any]:
        """Return the regulator's numbers, the switch and the rudder that is ordered without it."""
        return {**self.regulator.parameters(), SWITCH: 0.0, ORDERED: 0.0}

    def memory(self, start: Named) -> Named:
        """Return the regulator's memory.

        Parameters
        ----------
        start : mapping of str to number
            The state at the start.
        """
        return self.regulator.memory(start)

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the rudder's angle a step ahead, and the memory.

        Parameters
        ----------
        at : object
            Quantities by name.
        """
        orders, memory = self.regulator.orders(at)
        held = {name: choice(at.steers, value, getattr(at, name)) for name, value in memory.items()}
        return {"rudder": choice(at.steers, orders["rudder"], at.ordered)}, held


def helm_of(model: Model, speed: float) -> "tuple[SwitchedHelm | None, str]":
    """Return what holds a ship in the middle of its canal, or why nothing does (ours).

    Parameters
    ----------
    model : Model
        The ship in its canal.
    speed : float [m/s]
        That the gains are made for.
    """
    from narrows.control.regulator import regulator

    if not any(actuator.name == "rudder" for actuator in model.terms.actuators):
        return None, "This model has no rudder: nothing steers."
    try:
        return SwitchedHelm(regulator(model, 0.0, speed)), ""
    except InputError as error:
        return None, f"No helm: {error}."
