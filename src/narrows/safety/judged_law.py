"""A pilot under trial: its law, and how far off its line the ship was through the last part of the trial."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from narrows.quantities.arithmetic import choice, maximum
from narrows.simulation.controllers import ControlLaw, Named


@dataclass(frozen=True)
class JudgedLaw:
    """Any control law that remembers how far off a line the ship was from a time on."""

    law: ControlLaw  # That steers
    y: Any  # The line [m]
    late_from: Any  # From when it counts [s]

    def parameters(self) -> Mapping[str, Any]:
        """Return the law's numbers, the line, and from when it counts."""
        return {**self.law.parameters(), "judged_y": self.y, "late_from": self.late_from}

    def memory(self, start: Named) -> Named:
        """Return the law's memory, and how far off the ship was so far."""
        return {**self.law.memory(start), "farthest": 0.0}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the law's order, and how far off the ship was."""
        orders, memory = self.law.orders(at)
        counted = choice(at.t + at.dt / 2 - at.late_from, abs(at.y - at.judged_y), 0.0)
        return orders, {**memory, "farthest": maximum(at.farthest, counted)}
