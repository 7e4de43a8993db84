"""A prepared run: arrays are allocated once, so that a call costs only the kernel's time."""

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property, partial
from types import ModuleType
from typing import Any

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.codegen.choices import SHARED
from narrows.codegen.kernels.event import PLACES
from narrows.errors import InputError

# Largest number of steps that single precision can count.
MOST_STEPS_SINGLE = 2**24
# Vessels per slice of a thread: few enough to share the work evenly, enough to make call overhead small.
LARGEST_SLICE, SMALLEST_SLICE, SLICES_PER_WORKER = 16_384, 1024, 4


@dataclass(frozen=True)
class WaterTable:
    table: np.ndarray  # Table of a waterway, one row per cell; empty in a straight canal
    track: np.ndarray  # Nodes of line and banks, for the exact clearance
    outline: np.ndarray  # Points of the hull, forward and starboard alternating [m]


# A straight canal: no table.
NOWHERE = WaterTable(np.zeros(16), np.zeros(27), np.zeros(6))


@dataclass
class PreparedRun:
    """Vessels in arrays of a kernel; a call integrates them all from the current ``start``."""

    kernel: ModuleType  # The generated kernel
    start: np.ndarray  # (n, kept) State at the start
    times: np.ndarray  # (n, 3) Length of a step, whole steps, length of the last and shorter one [s]
    vessel_inputs: np.ndarray  # (n, vessel inputs) Inputs of each vessel; (1, vessel inputs) if none varies
    shared: np.ndarray  # (shared inputs,) Inputs that all share
    water: WaterTable  # The waterway
    # (2,) Tolerance of a contact's location, and distance at which a diverging motion counts as contact [m]
    limits: np.ndarray
    workers: int  # Threads
    end: np.ndarray = field(init=False)
    time: np.ndarray = field(init=False)
    codes: np.ndarray = field(init=False)
    lane_steps: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        vessels = len(self.start)
        self.end, self.time = self.start.copy(), np.zeros(vessels)
        self.codes = np.zeros((vessels, 2), np.int64)
        parts, inputs = slices(vessels, self.workers), self.vessel_inputs
        self._calls = [
            (
                self.start[part], self.times[part], inputs if len(inputs) == 1 else inputs[part],
                self.end[part], self.time[part], self.codes[part],
            )
            for part in parts
        ]  # fmt: skip
        lanes, size = self.kernel.LANES, (self.kernel.FIELDS + 1) * self.kernel.LANES
        self._memories = [
            (np.zeros(size, self.start.dtype), np.zeros((lanes, PLACES)), np.zeros(lanes, np.int64))
            for _ in range(min(self.workers, len(parts)))
        ]

    @cached_property
    def _integrate(self) -> Callable[..., int]:
        """The loop over vessels with the model's functions and the water."""
        from narrows.codegen.addresses import entry
        from narrows.codegen.kernels import queue

        kernel, water = self.kernel, self.water
        functions = [entry(kernel, name) for name in ("step", "clearance_of", "ends_of")]
        sizes = np.array([*functions, len(kernel.KEPT_NAMES), kernel.FIELDS, kernel.EXACT])
        arrays = water.table, self.shared, water.track, water.outline, self.limits
        return partial(compiled_loops(queue).integrate_fleet, sizes, kernel.LEAVES, *arrays)

    def __call__(self) -> int:
        """Integrate every vessel and return the number of lane-steps."""
        if not len(self.start):
            return 0
        free = list(self._memories)

        def one(arguments: tuple[Any, ...]) -> int:
            memory = free.pop()
            try:
                return int(self._integrate(*arguments, *memory))
            finally:
                free.append(memory)

        self.lane_steps = sum(in_threads(one, self._calls, len(self._memories)))
        return self.lane_steps


def in_threads(work: Any, parts: Sequence[Any], workers: int) -> list[Any]:
    """Work on parts in threads; an interrupt does not wait for the whole queue."""
    if len(parts) == 1:
        return [work(parts[0])]
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


def step_counts(dt: np.ndarray, duration: np.ndarray) -> np.ndarray:
    """Return length of a step, whole steps and length of the last, shorter one, (n, 3) [s]."""
    count = np.floor(duration / dt + 1e-9)
    rest = duration - count * dt
    return np.ascontiguousarray(np.stack([dt, count, np.where(rest > 1e-9 * dt, rest, 0.0)], axis=1))


def prepare(
    kernel: ModuleType, inputs: Mapping[str, Any], start: Mapping[str, Any], times: np.ndarray, water: WaterTable,
    limits: np.ndarray, workers: int, precision: str = "float64",
) -> PreparedRun:  # fmt: skip
    vessels = len(times)
    if precision == "float32" and times[:, 1].max(initial=0) >= MOST_STEPS_SINGLE:
        raise InputError(f"single precision counts fewer than {MOST_STEPS_SINGLE} steps; lengthen dt or use float64")

    def table(names: tuple[str, ...], values: Mapping[str, Any], rows: int) -> np.ndarray:
        columns = [np.broadcast_to(np.asarray(values[name], float), rows) for name in names]
        stacked = np.stack(columns, axis=1) if columns else np.zeros((rows, 0))
        return np.ascontiguousarray(stacked.astype(precision))

    shared = np.array([np.ravel(inputs.get(name, 0.0))[0] for name in SHARED], precision)
    kept = table(kernel.KEPT_NAMES, start, vessels)
    is_own = any(np.ndim(inputs[name]) for name in kernel.VESSEL_INPUTS)
    vessel_inputs = table(kernel.VESSEL_INPUTS, inputs, vessels if is_own else 1)
    return PreparedRun(kernel, kept, times, vessel_inputs, shared, water, limits.astype(precision), workers)
