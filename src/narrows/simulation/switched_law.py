"""A control law that is switched on, by hand or at a time; until then the rudder stays where it is put."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from narrows.quantities.arithmetic import choice
from narrows.quantities.names import Number
from narrows.simulation.controllers import EARLY, ControlLaw, Named

# Numbers beside those of the law: the switch, over 0 where it is on; the time; and the angle that is ordered before.
STEERS, SINCE, ORDERED = "steers", "since", "ordered"


@dataclass(frozen=True)
class SwitchedLaw:
    """Any control law, where it is on; where it is not, an angle is ordered and the law's memory stays."""

    law: ControlLaw  # What steers where it is on
    angle: Any = 0.0  # That is ordered where it is not [rad]
    since: Any = None  # When it is switched on [s]

    def parameters(self) -> Mapping[str, Any]:
        """Return the law's numbers, the angle, and the switch or the time."""
        switch = {STEERS: 0.0} if self.since is None else {SINCE: self.since}
        return {**self.law.parameters(), ORDERED: self.angle, **switch}

    def memory(self, start: Named) -> Named:
        """Return the law's memory."""
        return self.law.memory(start)

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the law's orders or the angle, and the memory."""
        orders, memory = self.law.orders(at)
        on = self._on(at)
        kept = {name: choice(on, value, getattr(at, name)) for name, value in memory.items()}
        return {**orders, "rudder": choice(on, orders["rudder"], at.ordered)}, kept

    def _on(self, at: Any) -> Number:
        """Over 0 where the law steers."""
        on: Number = at.steers if self.since is None else at.t - at.since + EARLY * at.dt
        return on
