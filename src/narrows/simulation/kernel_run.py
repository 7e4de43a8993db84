"""Many voyages of one model at once, by the compiled kernel: inputs as numbers and columns by name, arrays kept."""

import logging
import math
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from narrows.base.errors import InputError, installing, libraries_of, needs
from narrows.codegen import free_motion
from narrows.codegen.cache import compiled_loops, lacks_compiler
from narrows.codegen.free_motion import INPUTS, Across, Pushed, stages_at
from narrows.codegen.kernels import event
from narrows.codegen.system import DEFAULTS, System
from narrows.model.water import is_full
from narrows.quantities.names import Number
from narrows.simulation import lane_loops
from narrows.simulation.controllers import WithoutMemory
from narrows.simulation.inputs import START, counted_heading
from narrows.simulation.outcome import Code
from narrows.simulation.settings import CONTACT_TOLERANCE, NEAR_THE_BANK
from narrows.simulation.ship import PARAMETER, Channel, SimulatedShip, Steering, steering_of
from narrows.waterway.centreline import check_along_only
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
    lane_steps: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        vessels, inputs, lanes = len(self.start), self.vessel_inputs, self.kernel.LANES
        share = -(-vessels // (self.workers * SLICES_PER_WORKER))
        size = vessels if self.workers == 1 else max(SMALLEST_SLICE, min(LARGEST_SLICE, share))
        self.end, self.time, self.codes = self.start.copy(), np.zeros(vessels), np.zeros((vessels, 2), np.int64)
        self._calls = [
            (
                self.start[part], self.times[part], inputs if len(inputs) == 1 else inputs[part],
                self.end[part], self.time[part], self.codes[part],
                np.zeros(self.kernel.FIELDS * lanes + free_motion.CACHE_LINE), np.zeros((lanes, event.PLACES)),
                np.zeros(lanes, np.int64),
            )
            for part in (slice(first, first + size) for first in range(0, vessels, size or 1))
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
        self.lane_steps = sum(in_threads(lambda given: int(self._integrate(*given)), self._calls, self.workers))
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


@dataclass(frozen=True)
class KernelRun:
    ship: SimulatedShip  # The model and the choices of simulation
    duration: Any  # Longest duration [s]
    dt: Any  # Step [s]
    steering: Steering | None = None  # Control law; its numbers that vary are among the values of a run
    waterway: Waterway | None = None  # Waterway instead of the model's own canal
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
        ends["psi"] = counted_heading(ends["cos_psi"], ends["sin_psi"], ends.pop(free_motion.COUNTED, values["psi"]))
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
        dt, duration = (np.broadcast_to(np.asarray(time, float), vessels) for time in (self.dt, self.duration))
        count = np.floor(duration / dt + 1e-9)
        rest = duration - count * dt
        times = np.ascontiguousarray(np.stack([dt, count, np.where(rest > 1e-9 * dt, rest, 0.0)], axis=1))
        kernel = system.kernel(min(vessels, MOST_LANES))
        limits = np.array([CONTACT_TOLERANCE, NEAR_THE_BANK * float(np.min(inputs.get("width", 1.0)))])

        def table(names: tuple[str, ...], numbers: Mapping[str, Any], rows: int) -> np.ndarray:
            columns = [np.broadcast_to(np.asarray(numbers[name], float), rows) for name in names]
            stacked = np.stack(columns, axis=1) if columns else np.zeros((rows, 0))
            return np.ascontiguousarray(stacked)

        shared = np.array([np.ravel(inputs.get(name, 0.0))[0] for name in free_motion.SHARED], float)
        rows = vessels if any(np.ndim(inputs[name]) for name in kernel.VESSEL_INPUTS) else 1
        kept, own = table(kernel.KEPT_NAMES, self.start(values), vessels), table(kernel.VESSEL_INPUTS, inputs, rows)
        return PreparedRun(kernel, kept, times, own, shared, channel, limits, workers or cores())

    def system(self, values: Mapping[str, Any]) -> System:
        # External forces cost a little in each step, so they are compiled only if there are any.
        pushed: Pushed = "never"
        if PUSH_END in values:
            pushed = "until"
        elif any(np.any(values[name]) for name in INPUTS):
            pushed = "always"
        field = self.waterway is not None and self.waterway.has_current_field
        across: Across = "uniform" if free_motion.CURRENT_ACROSS in values else "field" if field else "none"
        law = self.steering.law if self.steering else None
        return self.ship.system((self.waterway or self.bend) is not None, law, pushed, across)

    def inputs(self, system: System, values: Mapping[str, Any]) -> tuple[dict[str, Any], Channel]:
        rest = {name: value for name, value in values.items() if name not in START and name not in INPUTS}
        positions = {one.name: values[one.name] for one in self.ship.actuators if one.name in values}
        ship = {**self.ship.values(**positions), **rest, **{INPUTS[name]: values[name] for name in INPUTS}}
        ship |= {free_motion.AFTER(INPUTS[name]): values.get(free_motion.AFTER(name), 0.0) for name in INPUTS}
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
        state |= {"cos_psi": np.cos(psi), "sin_psi": np.sin(psi), free_motion.COUNTED: psi, free_motion.TIME: 0.0}
        positions = {**self.ship.values(), **values}
        state |= {one.name: 0.0 if (at := positions.get(one.name)) is None else at for one in self.ship.actuators}
        state |= stages_at(self.ship.actuators, state.__getitem__)
        return {**state, **(self.steering.memory(state) if self.steering else {})}


RUDDER = "rudder"
# Place along a waterway that no lane reaches [m].
ENDLESS = 1e12


class ActuatorRates(WithoutMemory):
    """A law of prescribed rates of actuators."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)

    def parameters(self) -> dict[str, float]:
        return {f"turning_{name}": 0.0 for name in self.names}

    def orders(self, at: Any) -> tuple[dict[str, Number], dict[str, Number]]:
        return {name: getattr(at, name) + getattr(at, f"turning_{name}") * at.dt for name in self.names}, {}


class ShipLanes:
    """States of one ship, one per lane, each with its own forces, bank strength and coefficients."""

    def __init__(
        self, ship: SimulatedShip, states: Sequence[str], lanes: int, waterway: Waterway | None = None,
        coefficients: np.ndarray | None = None, *, pushed: bool = False, endless: bool = False,
    ) -> None:  # fmt: skip
        if waterway is not None:
            check_along_only(waterway, "an estimate or a plan")
        # states: x, y, psi, u, v, r, then any of bank, current, current_across and rudder_bias. coefficients (lanes,
        # coefficients), the model's unless given. endless: beyond its ends the waterway has its last sections.
        self.ship, self.lanes, self.waterway, self.coefficients = ship, lanes, waterway, coefficients
        self.places = {name: place for place, name in enumerate(states)}
        self.actuators = tuple(actuator.name for actuator in ship.actuators)
        self.silent = {term.name: 0.0 for term in ship.model.terms.terms if term.from_bank}
        law = ActuatorRates(self.actuators)
        placed = [replace(one, late=False) for one in ship.actuators]  # Positions are given instead of orders
        steering = steering_of(law, placed) if self.actuators else None
        self._run = KernelRun(ship, 1.0, 1.0, steering=steering, waterway=waterway)
        # With an end of the push, forces are inputs of their own that each call may change.
        self._forces: dict[str, Any] = dict.fromkeys(INPUTS, np.zeros(lanes) if pushed else 0.0)
        self._forces |= {PUSH_END: np.inf} if pushed else {}
        self.prepared = self._laid_out(1.0)
        kernel = self.prepared.kernel
        kept = [kernel.KEPT_NAMES.index(name) for name in self.actuators]
        self._inputs = {name: place for place, name in enumerate(kernel.VESSEL_INPUTS)}
        rates = [self._inputs[PARAMETER(f"turning_{name}")] for name in self.actuators]
        rudder = self.actuators.index(RUDDER) if RUDDER in self.actuators else -1
        self._movers = np.array(kept, int), np.array(rates, int), rudder
        own = "bank", "current", "current_across", "rudder_bias"
        self._columns_of_states = np.array([self.places.get(name, -1) for name in own])
        self._pushes = [self._inputs[name] for name in (INPUTS["Y"], INPUTS["N"])] if pushed else []
        self._system = self._run.system(self._values(1.0))
        self._ship_values: dict[str, Any] = {**DEFAULTS, **ship.values()}
        self._constants = [self._inputs.get(name) for name in self._system.scalar.CONSTANTS]
        self._base, self._slope = self._by_bank()
        self._none = np.zeros_like(self._base)
        self._water = self.prepared.channel.table.reshape(-1, free_motion.ROW) if waterway else None
        self._endless, self._lasting = endless, (0.0, 0)
        if endless:
            self.prepared.shared[free_motion.SHARED.index("x_last")] = ENDLESS

    def _values(self, bank: float) -> dict[str, Any]:
        model = self.ship.model
        numbers = {name: np.full(self.lanes, value) for name, value in model.coefficients.items()}
        if self.coefficients is not None:
            numbers = dict(zip(model.terms.names, self.coefficients.T, strict=True))
        numbers |= {name: bank * numbers[name] for name in self.silent}
        # An actuator is at its indicated position: no limit and no rate apply.
        limits = {f"{name}_{of}": 1e9 for name in self.actuators for of in ("limit", "rate")}
        law = {PARAMETER(f"turning_{name}"): np.zeros(self.lanes) for name in self.actuators}
        return {**dict.fromkeys(START, 0.0), **self._forces, "u": 1.0, **numbers, **limits, **law}

    def _laid_out(self, bank: float) -> PreparedRun:
        return self._run.prepared(self._values(bank), self.lanes, workers=1)

    def _by_bank(self) -> tuple[np.ndarray, np.ndarray]:
        """Inputs of each lane without a bank, and the addition of a bank of strength 1."""
        full = self.prepared.vessel_inputs.copy()
        if "bank" not in self.places or not self.silent:
            return full, np.zeros_like(full)
        none, double = self._laid_out(0.0).vessel_inputs, self._laid_out(2.0).vessel_inputs
        # If a lane's inputs are affine in the strength, they are this sum.
        if not (np.abs(double - 2 * full + none) <= 1e-9 * (np.abs(full) + np.abs(none))).all():
            raise InputError("the bank's terms of this model hold accelerations, so its strength cannot be estimated")
        return none, full - none

    def bend(self, x: float) -> float:
        return self._column("curvature", x)

    def _known_current(self, x: float) -> float:
        return self._column("flow", x) * (self.waterway.reference_current if self.waterway else 0.0)

    def _column(self, name: str, x: float) -> float:
        if self._water is None or self.waterway is None:
            return 0.0
        cells = len(self._water)
        place = min(max(x / self.waterway.line.length * cells, 0.0), cells - 1e-9)
        first, rise = self._water[int(place), 2 * free_motion.COLUMNS.index(name) :][:2]
        return float(first + (place - int(place)) * rise)

    def advance(
        self, points: np.ndarray, duration: float, start: np.ndarray, end: np.ndarray,
        columns: np.ndarray | None = None, pushes: np.ndarray | None = None, steps: int = 1,
    ) -> np.ndarray:  # fmt: skip
        """Advance states (lanes, states), with actuators from start to end (actuators,) or (lanes, actuators)."""
        # columns: inputs of the lanes, (lanes, inputs); pushes: sway force and yaw moment, (lanes, 2) [N, N m].
        # The current's difference from the waterway's moves the ship half before and half after the step.
        run, loops, places = self.prepared, compiled_loops(lane_loops), self._columns_of_states
        x, (base, slope) = float(points[0, 0]), (self._base, self._slope) if columns is None else (columns, self._none)
        known = self._known_current(x)
        least = 1e-3 if self._endless else -math.inf  # A lane at the very start of a waterway would be at its end
        after = loops.depart(
            points, places, run.start, run.vessel_inputs, base, slope, *self._movers, np.atleast_2d(start),
            np.atleast_2d(end), duration, self.bend(x), known, least,
        )  # fmt: skip
        if self._lasting != (duration, steps):
            run.times[:], self._lasting = (duration / steps, steps, 0.0), (duration, steps)
        if pushes is not None:
            run.vessel_inputs[:, self._pushes] = pushes
        run()
        x, before = float(after[0, 0] + run.end[0, 0] - run.start[0, 0]), known
        known = self._known_current(x)
        loops.arrive(after, places, run.start, run.end, 0.5 * duration, self.bend(x), known, known - before)
        return np.asarray(after)

    @property
    def aground(self) -> np.ndarray:
        """Lanes that met a bank, an end of the waterway or the limit of heading in the last step."""
        return np.asarray(self.prepared.codes[:, 0] != 0)

    def columns_of(self, coefficients: np.ndarray, bank: np.ndarray) -> np.ndarray:
        numbers = dict(zip(self.ship.model.terms.names, coefficients.T, strict=True))
        numbers |= {name: bank * numbers[name] for name in self.silent}
        known = self._ship_values | numbers
        with np.errstate(all="ignore"):
            constants = self._system.columns.constants(*map(known.__getitem__, self._system.parameters))
        columns = self._base.copy()
        for place, constant in zip(self._constants, constants, strict=True):
            if place is not None:
                columns[:, place] = constant
        if not np.isfinite(columns).all():
            self._system.constants(known)  # Raises an error with the reason
        return columns
