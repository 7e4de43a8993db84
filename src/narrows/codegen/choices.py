"""Choices of a step: contact, section, control law, external forces. No symbol is made here."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

from narrows.codegen.free_motion import INPUTS, MIDSHIP, OPEN, STATE
from narrows.codegen.trace import Trace

# Columns of a waterway's table at each place: distances of the walls, depth and curvature of the line; the current over
# the number ``current``; the least distance at which a hull can meet a bank; the distances at which the keel does.
COLUMNS = (
    "starboard", "port", "depth", "curvature", "flow", "near_starboard", "near_port", "keel_starboard", "keel_port",
)  # fmt: skip
ROW = 2 * len(COLUMNS)  # Numbers per cell: for each column the value at its start and the rise to the next
# Further columns where the current is not along the line alone: its speed across, and the rise of that along it to
# starboard.
FIELD = ("across", "shear")
# Speed through the water at which a ship touches the bottom or chokes the section [m/s]: an input in a straight canal,
# the last column of the table of a waterway with known depths.
AFLOAT_SPEED = "afloat_speed"
# Water quantities available to a control law at a place, by their name in its trace: the curvature of the line and the
# distances at which the keel meets the banks.
WATER = {"water_curvature": "curvature", "water_starboard": "keel_starboard", "water_port": "keel_port"}
# Time at the start of a step [s], length of a whole step [s], and the share of it that is taken: 1 unless a contact is
# located or an output lies within the step.
TIME, LENGTH, SHARE = "t", "step_length", "share"
# Heading with whole turns [rad], used where heading across the canal does not end a voyage.
COUNTED = "counted_psi"
MIDSHIP_LEAVES = 0.9

# Inputs that all vessels share, in their order in an array: the queue reads the last three too. Every other input is
# per vessel, so that one kernel serves fleets in which other things vary; a lane reads both equally fast.
SHARED = ("least_cos", "x_last", "x_first", "cells_a_metre", "most_speed", "most_rate")

# First fields of a lane, before its state: the queue of vessels reads and writes them.
BOOK = ("step_length", "share", "left", "flag", "clearance", "side", "clearance_before")

# Lanes of a block of vessels; those of a block of derivatives, where more directions need more passes.
LANES, DIRECTIONS = 64, 32
CACHE_LINE = 8  # numbers: 64 bytes

AFTER = "{}_after".format  # An external force from ``push_end`` on, by its name before it

Pushed = Literal["never", "always", "until"]
CURRENT_ACROSS = "current_across"
# A current across: none; the same everywhere, an input of each vessel; or by place in a waterway's table, with a shear.
Across = Literal["none", "uniform", "field"]


# First-order stages that approximate the dead time of a gear: more make the delay sharper and each step dearer.
STAGES = 4


@dataclass(frozen=True)
class Actuated:
    name: str  # Name of its position
    angle: bool  # True if it enters the terms as cosine and sine
    late: bool = False  # True if it has a dead time, a lag or a dead band besides its limit and its rate

    @property
    def controls(self) -> tuple[str, ...]:
        return (f"cos_{self.name}", f"sin_{self.name}") if self.angle else (self.name,)

    @property
    def stages(self) -> tuple[str, ...]:
        """Names of the stored orders on their way to the actuator, the earliest last."""
        return tuple(f"{self.name}_delayed_{stage}" for stage in range(STAGES)) if self.late else ()


def stages_at(actuators: Iterable[Actuated], position: Callable[[str], Any]) -> dict[str, Any]:
    """Return the stored orders when the last one equals the position."""
    return {stage: position(actuator.name) for actuator in actuators for stage in actuator.stages}


@dataclass(frozen=True)
class Law:
    trace: Trace  # Results: orders by actuator name, new memory by its names
    memory: tuple[str, ...]  # Numbers stored from step to step
    ordered: tuple[Actuated, ...]  # Actuators that it orders


@dataclass(frozen=True)
class Choices:
    contact: str | int = "corners"  # ``corners``, ``midship``, ``none``, or the number of points of an outline
    waterway: bool = False  # True if the section of the water changes
    law: Law | None = None  # Control law; without one the actuators stay where they are
    pushed: Pushed = "never"  # External forces: none, constant, or changing ones that end at ``push_end`` [s]
    bottom: bool = False  # True if bottom contact or a choked section ends a voyage
    across: Across = "none"

    @property
    def columns(self) -> tuple[str, ...]:
        return (*COLUMNS, *FIELD * (self.across == "field"), *(AFLOAT_SPEED,) * self.bottom)

    @property
    def row(self) -> int:
        """Numbers per cell of a waterway's table: for each column the value at its start and the rise to the next."""
        return 2 * len(self.columns)

    @property
    def kept(self) -> tuple[str, ...]:
        """Quantities carried from step to step: state, optional turns and time, actuators, memory."""
        law = self.law
        timed = self.pushed == "until" or (law is not None and TIME in law.trace.inputs)
        state = (*STATE, *(COUNTED,) * (self.contact == OPEN), *(TIME,) * timed)
        if law is None:
            return state
        stages = (stage for actuator in law.ordered for stage in actuator.stages)
        return (*state, *(actuator.name for actuator in law.ordered), *stages, *law.memory)

    @property
    def leaves(self) -> float:
        """Least share of the clearance that a step leaves [1]: at midship contact the suction becomes infinite."""
        return MIDSHIP_LEAVES if self.contact == MIDSHIP else 0.0

    @property
    def moving(self) -> tuple[str, ...]:
        """Quantities of the terms that change within a voyage, besides the state."""
        law = self.law.ordered if self.law else ()
        controls = [name for actuator in law for name in actuator.controls]
        return (
            *controls,
            *(("width", "depth") if self.waterway else ()),
            *(INPUTS.values() if self.pushed == "until" or self.across == "field" else ()),
        )
