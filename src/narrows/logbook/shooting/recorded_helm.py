"""A helm that does again what was recorded: actuators go from one recorded position to the next within each step."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from narrows.results.shown_results import Described
from narrows.simulation.controllers import Named

# What the law calls the position that an actuator has at the end of the step.
RECORDED = "recorded_{}".format
# The actuator that is read with a zero of its own, and how much farther to starboard it truly is [rad].
RUDDER, RUDDER_OFFSET = "rudder", "rudder_offset"
# Limit and rate of what was recorded: it went where it went.
BEYOND = 1e9


@dataclass(frozen=True, repr=False)
class RecordedHelm(Described):
    """A control law that follows recorded positions, straight between the ends of the steps."""

    positions: Mapping[str, float]  # Of the actuators that were recorded, at the start

    def summary(self) -> str:
        """Say what was recorded."""
        return f"as recorded: {', '.join(self.positions)}"

    def parameters(self) -> Mapping[str, float]:
        """Return the positions at the end of the step, and how far the rudder's zero is off."""
        offset = {RUDDER_OFFSET: 0.0} if RUDDER in self.positions else {}
        return {RECORDED(name): position for name, position in self.positions.items()} | offset

    def memory(self, start: Named) -> Named:
        """Return nothing: all that it follows is told."""
        return {}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return where the actuators are at the end of the step."""
        orders = {name: getattr(at, RECORDED(name)) for name in self.positions}
        if RUDDER in orders:
            orders[RUDDER] = orders[RUDDER] + at.rudder_offset
        return orders, {}


def unlimited(names: tuple[str, ...]) -> dict[str, float]:
    """Return limits and rates that no record meets, by the names of the lines."""
    return {f"{name}_{end}": BEYOND for name in names for end in ("limit", "rate")}
