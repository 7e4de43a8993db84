"""A rudder that stays where it is until a pilot takes over."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from narrows.quantities.arithmetic import choice
from narrows.simulation.controllers import EARLY, ControlLaw, Named

TAKEN_OVER, HELD = "taken_over", "held_angle"


@dataclass(frozen=True)
class TakeoverLaw:
    """Any control law, from a time on; before it an angle is ordered (ours).

    Parameters
    ----------
    law : ControlLaw
        Of the pilot.
    angle : float or array [rad]
        That is ordered before.
    taken_over : float or array [s]
        When the pilot takes over.
    """

    law: ControlLaw
    angle: Any
    taken_over: Any

    def parameters(self) -> Mapping[str, Any]:
        """Return the pilot's numbers, the angle, and the time."""
        return {**self.law.parameters(), HELD: self.angle, TAKEN_OVER: self.taken_over}

    def memory(self, start: Named) -> Named:
        """Return the pilot's memory.

        Parameters
        ----------
        start : mapping of str to number
            The state at the start.
        """
        return self.law.memory(start)

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the angle, or the pilot's order; before the pilot is there, the memory stays what it is.

        Parameters
        ----------
        at : object
            Quantities by name.
        """
        orders, memory = self.law.orders(at)
        waiting = at.taken_over - at.t - EARLY * at.dt
        kept = {name: choice(waiting, getattr(at, name), value) for name, value in memory.items()}
        return {**orders, "rudder": choice(waiting, at.held_angle, orders["rudder"])}, kept
