"""Many voyages of one model at once: numbers and columns by name in, columns of ends out."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.codegen.choices import COUNTED, Pushed
from narrows.codegen.free_motion import INPUTS
from narrows.codegen.run import PreparedRun, cores, prepare, step_counts
from narrows.codegen.system import System
from narrows.errors import InputError
from narrows.simulation.channel import Channel, along_waterway, straight_channel
from narrows.simulation.column_run import ColumnRun, lacks_compiler
from narrows.simulation.heading import counted_heading
from narrows.simulation.inputs import INPUTS as PUSHED
from narrows.simulation.inputs import START
from narrows.simulation.march import CONTACT_TOLERANCE, NEAR_THE_BANK
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import Steering

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

PUSH_END = "push_end"
STATE_AT_END = ("y", "psi", "u", "v", "r")
# What is kept of each voyage, and as what.
OUTPUTS: dict[str, type] = {
    "outcome": np.int8, "side": np.int8, "time": np.float64, "distance": np.float64,
    **{f"{name}_end": np.float64 for name in STATE_AT_END},
}  # fmt: skip

Result = dict[str, np.ndarray]


@dataclass(frozen=True)
class KernelRun:
    """How to run voyages."""

    ship: SimulatedShip  # The model and the choices of simulation
    duration: Any  # Longest time [s]
    dt: Any  # Step [s]
    precision: str = "float64"  # ``float64`` or ``float32``
    steering: Steering | None = None  # What steers; its numbers that vary are among the values of a run
    waterway: "Waterway | None" = None  # Where the ships sail instead of the model's own canal

    def __post_init__(self) -> None:
        if self.precision not in ("float64", "float32"):
            raise InputError(f"precision {self.precision!r} is unknown; it is 'float64' or 'float32'")
        if self.precision == "float32" and self.waterway is not None:
            raise InputError("single precision cannot tell places along a waterway apart; leave precision at float64")
        if self.steering and self.steering.asked:
            raise InputError(
                f"a {type(self.steering.asked).__name__} steers single voyages; write it as a law in arithmetic (with "
                "`parameters`, `memory` and `orders`) to steer many"
            )

    def run(self, values: Mapping[str, Any], vessels: int, workers: int | None = None) -> Result:
        """Run voyages; in columns of NumPy, in double precision, where there is no Numba."""
        columns = lacks_compiler()
        prepared = self._in_columns(values, vessels) if columns else self.prepared(values, vessels, workers)
        prepared()
        ended = self.ended(prepared, values)
        return {name: ended[name] for name in OUTPUTS}

    def ended(self, prepared: PreparedRun | ColumnRun, values: Mapping[str, Any]) -> Result:
        """Return how voyages ended: ``OUTPUTS``, positions of actuators and the controller's memory at the end."""
        names = prepared.kernel.KEPT_NAMES
        ends = dict(zip(names, np.asarray(prepared.end, float).T, strict=True))
        ends["psi"] = counted_heading(ends["cos_psi"], ends["sin_psi"], ends.pop(COUNTED, values["psi"]))
        distance = ends["x"] - (0.0 if self.precision == "float32" else np.asarray(values["x"], float))
        codes = prepared.codes.astype(np.int8)
        kept = {"outcome": codes[:, 0], "side": codes[:, 1], "time": prepared.time.copy(), "distance": distance}
        return {**kept, **{f"{name}_end": ends[name] for name in ends if name not in ("x", "cos_psi", "sin_psi")}}

    def prepared(self, values: Mapping[str, Any], vessels: int, workers: int | None = None) -> PreparedRun:
        """Lay out voyages, to be sailed by a call."""
        system = self._system(values)
        inputs, channel = self._inputs(system, values)
        start, times = self._start(system, values), self._times(vessels)
        kernel = system.kernel(_vessel_inputs(system, inputs, self.steering), self.precision)
        width = np.asarray(inputs.get("width", 1.0))
        tolerance = max(CONTACT_TOLERANCE, 4 * float(np.finfo(self.precision).eps) * float(width.max()))
        limits = np.array([tolerance, NEAR_THE_BANK * float(width.min())])
        return prepare(kernel, inputs, start, times, channel.water, limits, workers or cores(), self.precision)

    def _in_columns(self, values: Mapping[str, Any], vessels: int) -> ColumnRun:
        system, start = self._system(values), self._start(self._system(values), values)
        kept = [np.broadcast_to(np.asarray(start[name], float), vessels) for name in system.choices.kept]
        inputs, channel = self._inputs(system, values)
        return ColumnRun(system, inputs, np.stack(kept, axis=1), self._times(vessels), channel)

    def _times(self, vessels: int) -> np.ndarray:
        return step_counts(*(np.broadcast_to(np.asarray(time, float), vessels) for time in (self.dt, self.duration)))

    def _system(self, values: Mapping[str, Any]) -> System:
        # Forces from outside cost a little in each step, so they go in only where there are any.
        pushed: Pushed = "never"
        if PUSH_END in values:
            pushed = "until"
        elif any(np.any(values[name]) for name in PUSHED):
            pushed = "always"
        return self.ship.system(self.waterway is not None, self.steering.law if self.steering else None, pushed)

    def _inputs(self, system: System, values: Mapping[str, Any]) -> tuple[dict[str, Any], Channel]:
        rest = {name: value for name, value in values.items() if name not in START and name not in PUSHED}
        positions = {
            actuator.name: values[actuator.name] for actuator in self.ship.actuators if actuator.name in values
        }
        ship = {**self.ship.values(**positions), **rest, **{INPUTS[name]: values[name] for name in PUSHED}}
        if self.waterway is None:
            channel = straight_channel(ship, self.ship.shape)
        else:
            channel = along_waterway(self.waterway, self.ship.model, self.ship.shape)
        steering = self.steering.parameters if self.steering else {}
        law = {name: ship.get(name, value) for name, value in steering.items()}
        return {**ship, **system.constants(ship), **channel.inputs, **law}, channel

    def _start(self, system: System, values: Mapping[str, Any]) -> dict[str, Any]:
        psi = np.asarray(values["psi"], float)
        state = {name: values[name] for name in START if name != "psi"}
        state |= {"t": 0.0, "cos_psi": np.cos(psi), "sin_psi": np.sin(psi), COUNTED: psi}
        if self.precision == "float32":
            state["x"] = 0.0  # a place far along the canal has no room for the distance in single precision
        here = {**self.ship.values(), **values}
        state |= {actuator.name: here.get(actuator.name, 0.0) for actuator in self.ship.actuators}
        return {**state, **(self.steering.memory(state) if self.steering else {})}

    @property
    def text(self) -> str:
        """What tells this run from others, beside the values that vary."""
        law = self.steering.law.tape.text if self.steering else ""
        options = (self.duration, self.dt, self.precision, self.ship.surge, self.ship.coriolis, self.ship.contact)
        where = self._where()
        return (
            f"{self.ship.system().tape.text} {options!r} {law} {where} {sorted(self.ship.values().items(), key=str)!r}"
        )

    def _where(self) -> str:
        """The waterway in as many letters as tell it from others."""
        if self.waterway is None:
            return ""
        channel = along_waterway(self.waterway, self.ship.model, self.ship.shape)
        return hashlib.sha256(channel.water.table.tobytes() + channel.water.track.tobytes()).hexdigest()


def _vessel_inputs(system: System, inputs: Mapping[str, Any], steering: Steering | None) -> tuple[str, ...]:
    """What each vessel has of its own: whole groups, so that few kernels are ever made."""
    groups = [
        tuple(system.scalar.CONSTANTS),
        tuple(steering.parameters) if steering else (),
        (*INPUTS.values(), PUSH_END),
        tuple(n for n in inputs if n.startswith(("half_", "wall_", "outline_"))),
        tuple(f"{a.name}_{end}" for a in (steering.law.ordered if steering else ()) for end in ("limit", "rate")),
    ]
    names: list[str] = []
    for number, group in enumerate(groups):
        if any(np.size(inputs.get(name, 0.0)) > 1 for name in group):
            names += ("k",) if number == 0 else group
    return tuple(sorted(set(names)))
