"""Sail many vessels at once: columns in, outcomes out, a block of lanes on every core."""

import math
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from types import ModuleType
from typing import TypeVar

import numpy as np

from narrows.compile.kernel import LANES, Precision
from narrows.compile.outcome import Outcome
from narrows.compile.trace import STATE
from narrows.errors import InputError
from narrows.quantities.names import Number

RUNNING = -1
Result = TypeVar("Result")
LARGEST_SLICE, SMALLEST_SLICE = 256 * LANES, 16 * LANES
SLICES_PER_WORKER = 4
CONTACT_TOLERANCE = 1e-9
NEAR_THE_BANK = 1e-3
"""Of the width: a hull that runs away so near a bank has met it, for at midship the suction ends infinite."""
MOST_STEPS_SINGLE = 2**24


@dataclass(frozen=True)
class Limits:
    """What ends a voyage beside a bank and time.

    Parameters
    ----------
    heading : float [rad]
        Beyond this size of heading the ship lies across the canal and the model says nothing.
    speed : float [m/s]
        Surge or sway velocity that no ship has.
    rate : float [rad/s]
        Yaw rate that no ship has.
    """

    heading: float = math.radians(85)
    speed: float = 100.0
    rate: float = 10.0


@dataclass(frozen=True)
class Fleet:
    """Where and how each voyage ended.

    Parameters
    ----------
    outcome : array (n,) of int
        An ``Outcome``.
    side : array (n,) of int
        +1 where the starboard bank was touched, -1 the port bank, 0 neither.
    time : array (n,) [s]
        When.
    x, y : array (n,) [m]
        Midship in the canal.
    psi : array (n,) [rad]
        Heading.
    u, v : array (n,) [m/s]
        Surge and sway velocity.
    r : array (n,) [rad/s]
        Yaw rate.
    steps : array (n,) of int
        Whole time steps begun.
    lane_steps : int
        Steps that all lanes took between them, with shortened ones and those of lanes that stood empty.
    """

    outcome: np.ndarray
    side: np.ndarray
    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    psi: np.ndarray
    u: np.ndarray
    v: np.ndarray
    r: np.ndarray
    steps: np.ndarray
    lane_steps: int


@dataclass
class Task:
    """The columns that a kernel reads and writes, a row for each vessel."""

    start: np.ndarray
    pace: np.ndarray
    steps: np.ndarray
    end: np.ndarray
    time: np.ndarray
    codes: np.ndarray

    def part(self, rows: slice) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
        """Views of some vessels: what goes in, and what comes out."""
        return (self.start[rows], self.pace[rows], self.steps[rows]), (
            self.end[rows],
            self.time[rows],
            self.codes[rows],
        )


def task_of(start: Mapping[str, Number], dt: Number, duration: float, vessels: int, precision: Precision) -> Task:
    """Lay out a fleet's columns (ours).

    Parameters
    ----------
    start : mapping of str to number
        x, y, psi, u, v, r at the start, SI and rad; they broadcast.
    dt : number [s]
        Time step.
    duration : float [s]
        Longest voyage.
    vessels : int
        How many there are at least; 1 leaves it to the columns.
    precision : {"float64", "float32"}
        Of a lane.

    Raises
    ------
    InputError
        Where columns do not match, a number is not finite or the time step is not positive.
    """
    values = _columns({"dt": dt, **start}, vessels)
    pace, psi = values.pop("dt"), values.pop("psi")
    if (pace <= 0).any() or not 0 <= duration < math.inf:
        raise InputError("dt and duration are times in seconds: the one positive, the other not negative")
    steps = np.ceil(duration / pace - 1e-9)
    if precision == "float32" and steps.max(initial=0) >= MOST_STEPS_SINGLE:
        raise InputError(f"single precision counts fewer than {MOST_STEPS_SINGLE} steps; lengthen dt or use float64")
    values |= {"cos_psi": np.cos(psi), "sin_psi": np.sin(psi)}
    state = np.stack([values[name] for name in STATE], axis=1).astype(precision)
    codes = np.full((len(pace), 3), (RUNNING, 0, 0))
    return Task(state, pace, steps, state.copy(), np.zeros(len(pace)), codes)


def _columns(values: Mapping[str, Number], vessels: int) -> dict[str, np.ndarray]:
    try:
        _, *columns = np.broadcast_arrays(np.empty(vessels), *(np.asarray(v, float) for v in values.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {np.shape(value)}" for name, value in values.items() if np.ndim(value))
        raise InputError(f"the columns of a fleet do not match: {vessels} vessels, {shapes}; give one length") from None
    flat = {name: column.flatten() for name, column in zip(values, columns, strict=True)}
    for name, column in flat.items():
        if not np.isfinite(column).all():
            raise InputError(f"{name} of vessel {int(np.argmin(np.isfinite(column)))} is not a finite number; mend it")
    return flat


def settle(
    task: Task,
    constants: Sequence[Number],
    gap: Callable[..., Number],
    lean: Callable[..., Number],
    limits: Limits,
) -> None:
    """End the voyages that end where they begin (ours).

    Parameters
    ----------
    task : Task
        The columns.
    constants : sequence of number
        Of the right-hand side.
    gap, lean : callable
        Room between hull and bank, and the side that is nearer, by pose and constants.
    limits : Limits
        What else ends a voyage.
    """
    outcome, side, _ = task.codes.T
    pose = [task.start[:, STATE.index(name)] for name in ("y", "cos_psi", "sin_psi")]
    outcome[task.steps <= 0] = Outcome.AFLOAT
    outcome[pose[1] <= math.cos(limits.heading)] = Outcome.OUTSIDE
    aground = np.asarray(gap(*pose, *constants)) <= 0
    outcome[aground] = Outcome.GROUNDED
    side[aground] = np.sign(np.asarray(lean(*pose, *constants))[aground])


def sail(
    task: Task, kernel: ModuleType, constants: Callable[[slice], np.ndarray], limits: np.ndarray, workers: int | None
) -> Fleet:
    """Sail a fleet on several cores; what comes out does not depend on how many (ours).

    Parameters
    ----------
    task : Task
        The columns.
    kernel : module
        The generated kernel.
    constants : callable
        Gives those of some vessels.
    limits : array
        As ``limits_of`` gives them.
    workers : int, optional
        Threads; a core each if absent.
    """

    def run(rows: slice) -> int:
        given, out = task.part(rows)
        return int(kernel.fleet(*given, constants(rows), limits, *out))

    return _fleet(task, sum(on_all_cores(run, len(task.pace), workers)))


def on_all_cores(run: Callable[[slice], Result], vessels: int, workers: int | None) -> list[Result]:
    """Run a fleet slice by slice in threads (ours).

    Parameters
    ----------
    run : callable
        Sails the vessels of a slice.
    vessels : int
        How many.
    workers : int, optional
        Threads; a core each if absent.
    """
    workers = workers or _cores()
    pool = ThreadPoolExecutor(workers)
    try:
        return list(pool.map(run, _slices(vessels, workers)))
    finally:
        pool.shutdown(cancel_futures=True)  # an interrupt does not wait for the whole queue


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def limits_of(limits: Limits, width: Number, precision: Precision) -> np.ndarray:
    """Lay out the limits for a kernel (ours).

    Parameters
    ----------
    limits : Limits
        What ends a voyage.
    width : number [m]
        Of the canal; a contact is located as closely as the lanes can tell.
    precision : {"float64", "float32"}
        Of a lane.
    """
    tolerance = max(CONTACT_TOLERANCE, 4 * float(np.finfo(precision).eps) * float(np.max(width)))
    near = NEAR_THE_BANK * float(np.min(width))
    return np.array([math.cos(limits.heading), limits.speed, limits.rate, tolerance, near], precision)


def _slices(vessels: int, workers: int) -> list[slice]:
    size = max(SMALLEST_SLICE, min(LARGEST_SLICE, -(-vessels // (workers * SLICES_PER_WORKER))))
    return [slice(first, min(first + size, vessels)) for first in range(0, vessels, size)]


def _fleet(task: Task, lane_steps: int) -> Fleet:
    ends = dict(zip(STATE, np.asarray(task.end, float).T, strict=True))
    psi = np.arctan2(ends.pop("sin_psi"), ends.pop("cos_psi"))
    outcome, side, steps = task.codes.T
    codes = {"outcome": outcome.astype(np.int8), "side": side.astype(np.int8), "steps": steps}
    return Fleet(**codes, **ends, psi=psi, time=task.time, lane_steps=lane_steps)
