"""A control law that is switched on, by hand or at a time; until then the rudder stays where it is put."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from narrows.quantities.arithmetic import choice
from narrows.quantities.names import Number
from narrows.simulation.controllers import EARLY, ControlLaw, Named

STEERS, SINCE, ORDERED = "steers", "since", "ordered"
"""Numbers beside those of the law: the switch, over 0 where it is on; the time; and the angle that is ordered before.
"""


@dataclass(frozen=True)
class SwitchedLaw:
    """Any control law, where it is on; where it is not, an angle is ordered and the law's memory stays (ours).

    Parameters
    ----------
    law : ControlLaw
        What steers where it is on.
    angle : float or array [rad]
        That is ordered where it is not.
    since : float or array [s], optional
        When it is switched on. By hand unless given: by the number ``steers``, off at first.
    """

    law: ControlLaw
    angle: Any = 0.0
    since: Any = None

    def parameters(self) -> Mapping[str, Any]:
        """Return the law's numbers, the angle, and the switch or the time."""
        switch = {STEERS: 0.0} if self.since is None else {SINCE: self.since}
        return {**self.law.parameters(), ORDERED: self.angle, **switch}

    def memory(self, start: Named) -> Named:
        """Return the law's memory.

        Parameters
        ----------
        start : mapping of str to number
            The state at the start.
        """
        return self.law.memory(start)

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the law's orders or the angle, and the memory.

        Parameters
        ----------
        at : object
            Quantities by name.
        """
        orders, memory = self.law.orders(at)
        on = self._on(at)
        kept = {name: choice(on, value, getattr(at, name)) for name, value in memory.items()}
        return {**orders, "rudder": choice(on, orders["rudder"], at.ordered)}, kept

    def _on(self, at: Any) -> Number:
        """Over 0 where the law steers."""
        on: Number = at.steers if self.since is None else at.t - at.since + EARLY * at.dt
        return on
