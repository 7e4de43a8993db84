"""What a step holds: contact, section, control law, forces from outside. No symbol is made here."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

from narrows.codegen.free_motion import INPUTS, MIDSHIP, OPEN, STATE
from narrows.codegen.tape import Tape

# What the table of a waterway holds at each place: how far off its walls are, its depth and the curvature of its line;
# the least distance at which a hull can meet a bank; how far off a keel meets it.
COLUMNS = (
    "starboard", "port", "depth", "curvature", "near_starboard", "near_port", "keel_starboard", "keel_port",
)  # fmt: skip
# Numbers a cell: of each column the value at its start, and the rise to the next.
ROW = 2 * len(COLUMNS)
# Speed through the water at which a ship touches the bottom or chokes the section [m/s]: an input of a straight canal,
# the last column of a waterway's table where voyages know the bottom.
AFLOAT_SPEED = "afloat_speed"
# What a control law sees of the water at a place along it, by what its tape calls it: the curvature of the line, and
# how far off it a keel meets the banks.
WATER = {"water_curvature": "curvature", "water_starboard": "keel_starboard", "water_port": "keel_port"}
# The time at the start of a step [s], the length of a whole step [s], and the share of it that is taken: 1 but where a
# contact is located, or where an output lies within the step.
TIME, LENGTH, SHARE = "t", "step_length", "share"
# The heading that counts whole turns [rad], kept where nothing ends a voyage across the canal.
COUNTED = "counted_psi"
MIDSHIP_LEAVES = 0.9

Pushed = Literal["never", "always", "until"]


# First-order stages by which a gear hears an order late: more make the delay sharper and each step dearer.
STAGES = 4


@dataclass(frozen=True)
class Actuated:
    name: str  # Of its position
    angle: bool  # Whether it enters the terms as cosine and sine
    late: bool = False  # Whether it has a dead time, a lag or a dead band beside its limit and its rate

    @property
    def stages(self) -> tuple[str, ...]:
        """What is kept of orders on their way to it, the earliest last."""
        return tuple(f"{self.name}_heard_{stage}" for stage in range(STAGES)) if self.late else ()


def stages_at(actuators: Iterable[Actuated], position: Callable[[str], Any]) -> dict[str, Any]:
    """Return what is kept of orders on their way where the last was the position."""
    return {stage: position(actuator.name) for actuator in actuators for stage in actuator.stages}


@dataclass(frozen=True)
class Law:
    tape: Tape  # Of the orders, by the names of the actuators, and of the new memory, by its names
    memory: tuple[str, ...]  # Numbers that it keeps from step to step
    ordered: tuple[Actuated, ...]  # What it gives orders to


@dataclass(frozen=True)
class Choices:
    """What a step holds."""

    contact: str | int = "corners"  # ``corners``, ``midship``, ``none``, or the number of points of an outline
    waterway: bool = False  # Whether the section of the water changes
    law: Law | None = None  # What steers; actuators stay where they are without one
    # Whether forces from outside act: constant ones, or ones that change and end at ``push_end`` [s]
    pushed: Pushed = "never"
    bottom: bool = False  # Whether a voyage ends where the ship touches the bottom or chokes the section

    @property
    def row(self) -> int:
        """Numbers a cell of the table of a waterway."""
        return ROW + 2 * self.bottom

    @property
    def kept(self) -> tuple[str, ...]:
        """What goes from step to step: the state, turns and time where they are asked for, actuators, memory."""
        law = self.law
        timed = self.pushed == "until" or (law is not None and TIME in law.tape.inputs)
        state = (*STATE, *(COUNTED,) * (self.contact == OPEN), *(TIME,) * timed)
        if law is None:
            return state
        stages = (stage for actuator in law.ordered for stage in actuator.stages)
        return (*state, *(actuator.name for actuator in law.ordered), *stages, *law.memory)

    @property
    def leaves(self) -> float:
        """Least share of the room that a step leaves [1]: at midship contact the suction ends infinite."""
        return MIDSHIP_LEAVES if self.contact == MIDSHIP else 0.0

    @property
    def moving(self) -> tuple[str, ...]:
        """Quantities of the terms that change within a voyage, beside the state."""
        law = self.law.ordered if self.law else ()
        controls = [name for actuator in law for name in control_names(actuator)]
        return (
            *controls,
            *(("width", "depth") if self.waterway else ()),
            *(INPUTS.values() if self.pushed == "until" else ()),
        )


def control_names(actuator: Actuated) -> tuple[str, ...]:
    """Return what the terms call the position of an actuator."""
    return (f"cos_{actuator.name}", f"sin_{actuator.name}") if actuator.angle else (actuator.name,)
