"""Many voyages of one model at once: inputs as numbers and columns by name, results as columns."""

import hashlib
import logging
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.errors import installing, libraries_of, needs
from narrows.codegen.cache import compiled_loops, lacks_compiler
from narrows.codegen.choices import (
    AFTER,
    CACHE_LINE,
    COUNTED,
    CURRENT_ACROSS,
    SHARED,
    TIME,
    Across,
    Pushed,
    stages_at,
)  # fmt: skip
from narrows.codegen.free_motion import INPUTS
from narrows.codegen.kernels import event
from narrows.codegen.system import System
from narrows.model.water import is_full
from narrows.simulation.channel import Channel, across_of
from narrows.simulation.inputs import INPUTS as PUSHED
from narrows.simulation.inputs import START, counted_heading
from narrows.simulation.outcome import Code
from narrows.simulation.settings import CONTACT_TOLERANCE, NEAR_THE_BANK
from narrows.simulation.ship import SimulatedShip, Steering

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

PUSH_END = "push_end"

# Stored results of each voyage, and their types.
OUTPUTS: dict[str, type] = {
    "outcome": np.int8, "side": np.int8, "time": np.float64, "distance": np.float64,
    **{f"{name}_end": np.float64 for name in ("y", "psi", "u", "v", "r")},
}  # fmt: skip

Result = dict[str, np.ndarray]

# Vessels per slice of a thread: few enough to share the work evenly, enough to make call overhead small.
LARGEST_SLICE, SMALLEST_SLICE, SLICES_PER_WORKER = 16_384, 1024, 4
# Most vessels that take a step at once without a compiler.
MOST_LANES = 4096


@dataclass
class PreparedRun:
    """Vessels in arrays of a kernel; a call integrates them all from the current ``start``."""

    kernel: Any  # The generated kernel
    start: np.ndarray  # (n, kept) State at the start
    times: np.ndarray  # (n, 3) Length of a step, whole steps, length of the last and shorter one [s]
    vessel_inputs: np.ndarray  # (n, vessel inputs) Inputs of each vessel; (1, vessel inputs) if none varies
    shared: np.ndarray  # (shared inputs,) Inputs that all share
    channel: Channel  # The water
    # (2,) Tolerance of a contact's location, and distance at which a diverging motion counts as contact [m]
    limits: np.ndarray
    workers: int  # Threads
    end: np.ndarray = field(init=False)
    time: np.ndarray = field(init=False)
    codes: np.ndarray = field(init=False)
    lane_steps: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        vessels, inputs, lanes = len(self.start), self.vessel_inputs, self.kernel.LANES
        self.end, self.time, self.codes = self.start.copy(), np.zeros(vessels), np.zeros((vessels, 2), np.int64)
        self._calls = [
            (
                self.start[part], self.times[part], inputs if len(inputs) == 1 else inputs[part],
                self.end[part], self.time[part], self.codes[part],
                np.zeros(self.kernel.FIELDS * lanes + CACHE_LINE), np.zeros((lanes, event.PLACES)),
                np.zeros(lanes, np.int64),
            )
            for part in slices(vessels, self.workers)
        ]  # fmt: skip

    @cached_property
    def _integrate(self) -> Callable[..., int]:
        from narrows.codegen.addresses import entry
        from narrows.codegen.kernels import queue

        kernel, water = self.kernel, self.channel
        functions = [entry(kernel, name) for name in ("step", "clearance_of", "ends_of")]
        sizes = np.array([*functions, len(kernel.KEPT_NAMES), kernel.FIELDS, kernel.EXACT])
        arrays = water.table, self.shared, water.track, water.outline, self.limits
        return partial(compiled_loops(queue).integrate_fleet, sizes, kernel.LEAVES, *arrays)

    def __call__(self) -> int:
        calls = self._calls if len(self.start) else []
        self.lane_steps = sum(in_threads(lambda given: int(self._integrate(*given)), calls, self.workers))
        return self.lane_steps


def in_threads(work: Any, parts: Sequence[Any], workers: int) -> list[Any]:
    """Work on parts in threads; an interrupt does not wait for the whole queue."""
    if len(parts) <= 1:
        return list(map(work, parts))
    pool = ThreadPoolExecutor(workers)
    try:
        return list(pool.map(work, parts))
    finally:
        pool.shutdown(cancel_futures=True)


def cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def slices(vessels: int, workers: int) -> list[slice]:
    if workers == 1:
        return [slice(0, vessels)]
    size = max(SMALLEST_SLICE, min(LARGEST_SLICE, -(-vessels // (workers * SLICES_PER_WORKER))))
    return [slice(first, min(first + size, vessels)) for first in range(0, vessels, size)]


@dataclass(frozen=True)
class KernelRun:
    ship: SimulatedShip  # The model and the choices of simulation
    duration: Any  # Longest duration [s]
    dt: Any  # Step [s]
    steering: Steering | None = None  # Control law; its numbers that vary are among the values of a run
    waterway: "Waterway | None" = None  # Waterway instead of the model's own canal
    bend: Channel | None = None  # Bend of constant curvature instead of either

    def run(self, values: Mapping[str, Any], vessels: int, workers: int | None = None) -> Result:
        """Run voyages; without Numba in columns of NumPy."""
        if lacks_compiler() and vessels > 1:
            install = installing(libraries_of("compiled") or ["numba"])
            logging.getLogger("narrows").info("without Numba many voyages take longer; to add it: %s", install)
        prepared = self._laid_out(values, vessels, 1 if lacks_compiler() else workers)
        with np.errstate(all="ignore"):
            prepared()
        ended = self.ended(prepared, values)
        return {name: ended[name] for name in OUTPUTS}

    def ended(self, prepared: PreparedRun, values: Mapping[str, Any]) -> Result:
        """Return the ends of voyages: ``OUTPUTS``, positions of actuators and the controller's memory."""
        system = self.system(values)
        ends = dict(zip(system.choices.kept, np.asarray(prepared.end, float).T, strict=True))
        ends["psi"] = counted_heading(ends["cos_psi"], ends["sin_psi"], ends.pop(COUNTED, values["psi"]))
        distance = ends["x"] - np.asarray(values["x"], float)
        outcome, side = prepared.codes.astype(np.int8).T
        if (outcome == event.SHALLOW).any():
            outcome = self.inputs(system, values)[1].codes(outcome, ends["x"]).astype(np.int8)
            block = values.get("block_coefficient", self.ship.model.configuration.ship.block_coefficient)
            side = np.where(outcome == Code.TOUCHED, np.where(is_full(block), 1, -1), side).astype(np.int8)
        kept = {"outcome": outcome, "side": side, "time": prepared.time.copy(), "distance": distance}
        return {**kept, **{f"{name}_end": ends[name] for name in ends if name not in ("x", "cos_psi", "sin_psi")}}

    def prepared(self, values: Mapping[str, Any], vessels: int, workers: int | None = None) -> PreparedRun:
        with needs("compiled", "compiled simulation (safe envelopes, estimation, predictive helms, the monitor)"):
            import numba  # noqa: F401  # Their many calls would take minutes in NumPy.
        return self._laid_out(values, vessels, workers)

    def _laid_out(self, values: Mapping[str, Any], vessels: int, workers: int | None) -> PreparedRun:
        system = self.system(values)
        inputs, channel = self.inputs(system, values)
        start, times = self.start(values), self._times(vessels)
        kernel = system.kernel(min(vessels, MOST_LANES))
        limits = np.array([CONTACT_TOLERANCE, NEAR_THE_BANK * float(np.min(inputs.get("width", 1.0)))])

        def table(names: tuple[str, ...], numbers: Mapping[str, Any], rows: int) -> np.ndarray:
            columns = [np.broadcast_to(np.asarray(numbers[name], float), rows) for name in names]
            stacked = np.stack(columns, axis=1) if columns else np.zeros((rows, 0))
            return np.ascontiguousarray(stacked)

        shared = np.array([np.ravel(inputs.get(name, 0.0))[0] for name in SHARED], float)
        rows = vessels if any(np.ndim(inputs[name]) for name in kernel.VESSEL_INPUTS) else 1
        kept, own = table(kernel.KEPT_NAMES, start, vessels), table(kernel.VESSEL_INPUTS, inputs, rows)
        return PreparedRun(kernel, kept, times, own, shared, channel, limits, workers or cores())

    def _times(self, vessels: int) -> np.ndarray:
        """Return length of a step, whole steps and length of the last, shorter one, (n, 3) [s]."""
        dt, duration = (np.broadcast_to(np.asarray(time, float), vessels) for time in (self.dt, self.duration))
        count = np.floor(duration / dt + 1e-9)
        rest = duration - count * dt
        return np.ascontiguousarray(np.stack([dt, count, np.where(rest > 1e-9 * dt, rest, 0.0)], axis=1))

    def system(self, values: Mapping[str, Any]) -> System:
        # External forces cost a little in each step, so they are compiled only if there are any.
        pushed: Pushed = "never"
        if PUSH_END in values:
            pushed = "until"
        elif any(np.any(values[name]) for name in PUSHED):
            pushed = "always"
        across: Across = "uniform" if CURRENT_ACROSS in values else across_of(self.waterway)
        law = self.steering.law if self.steering else None
        return self.ship.system((self.waterway or self.bend) is not None, law, pushed, across)

    def inputs(self, system: System, values: Mapping[str, Any]) -> tuple[dict[str, Any], Channel]:
        rest = {name: value for name, value in values.items() if name not in START and name not in PUSHED}
        positions = {
            actuator.name: values[actuator.name] for actuator in self.ship.actuators if actuator.name in values
        }
        ship = {**self.ship.values(**positions), **rest, **{INPUTS[name]: values[name] for name in PUSHED}}
        ship |= {AFTER(INPUTS[name]): values.get(AFTER(name), 0.0) for name in PUSHED}
        channel = self.channel(ship)
        law = self.steering.parameters if self.steering else {}
        law = {name: values.get(name, value) for name, value in law.items()}
        return {**ship, **system.constants(ship), **channel.inputs, **law}, channel

    def channel(self, values: Mapping[str, Any]) -> Channel:
        return self.bend or self.ship.channel(self.waterway, values)

    def start(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the state at the start: actuators at rest unless given, each order on its way equal to them."""
        psi = np.asarray(values["psi"], float)
        state = {name: values[name] for name in START if name != "psi"}
        state |= {"cos_psi": np.cos(psi), "sin_psi": np.sin(psi), COUNTED: psi, TIME: 0.0}
        positions = {**self.ship.values(), **values}
        state |= {one.name: 0.0 if (at := positions.get(one.name)) is None else at for one in self.ship.actuators}
        state |= stages_at(self.ship.actuators, state.__getitem__)
        return {**state, **(self.steering.memory(state) if self.steering else {})}

    @property
    def text(self) -> str:
        """Identifier of this run, apart from the values that vary."""
        law = self.steering.law.trace.text if self.steering else ""
        options = (self.duration, self.dt, self.ship.surge, self.ship.coriolis, self.ship.contact,
            self.ship.bottom)  # fmt: skip
        where = ""
        if self.waterway is not None:
            water = self.channel({})
            where = hashlib.sha256(water.table.tobytes() + water.track.tobytes()).hexdigest()
        values = sorted(self.ship.values().items(), key=str)
        return f"{self.ship.system().trace.text} {options!r} {law} {where} {values!r}"
