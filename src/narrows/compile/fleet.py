"""Sail many vessels at once: columns in, outcomes out, a block of lanes on every core."""

import math
import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from narrows.compile.kernel import LANES, Precision
from narrows.compile.outcome import Outcome
from narrows.compile.trace import STATE
from narrows.errors import InputError
from narrows.vocabulary import Number

RUNNING = -1
LARGEST_SLICE, SMALLEST_SLICE = 256 * LANES, 16 * LANES
SLICES_PER_WORKER = 4
CONTACT_TOLERANCE = 1e-9
NEAR_THE_BANK = 1e-3


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

    def part(self, rows: slice) -> tuple[np.ndarray, ...]:
        """Views of some vessels: what goes in, then what comes out."""
        return tuple(getattr(self, name)[rows] for name in ("start", "pace", "steps", "end", "time", "codes"))


def task_of(start: Mapping[str, Number], dt: Number, duration: float, precision: Precision) -> Task:
    """Lay out a fleet's columns (ours).

    Parameters
    ----------
    start : mapping of str to number
        x, y, psi, u, v, r at the start, SI and rad; they broadcast.
    dt : number [s]
        Time step.
    duration : float [s]
        Longest voyage.
    precision : {"float64", "float32"}
        Of a lane.

    Raises
    ------
    InputError
        Where a number is not finite or the time step is not positive.
    """
    dt, *columns = (np.ravel(c) for c in np.broadcast_arrays(np.asarray(dt, float), *start.values()))
    values = {name: np.asarray(column, float) for name, column in zip(start, columns, strict=True)}
    for name, column in values.items():
        if not np.isfinite(column).all():
            raise InputError(f"{name} of vessel {int(np.argmin(np.isfinite(column)))} is not a finite number; mend it")
    if not ((dt > 0) & np.isfinite(dt)).all() or not 0 <= duration < math.inf:
        raise InputError("dt and duration are times in seconds: the one positive, the other not negative")
    psi = values.pop("psi")
    values |= {"cos_psi": np.cos(psi), "sin_psi": np.sin(psi)}
    state = np.stack([values[name] for name in STATE], axis=1).astype(precision)
    steps = np.ceil(duration / dt - 1e-9)
    codes = np.zeros((len(dt), 3), np.int64)
    codes[:, 0] = RUNNING
    return Task(state, dt, steps, state.copy(), np.zeros(len(dt)), codes)


def settle(task: Task, room: Number, lean: Number, limits: Limits) -> None:
    """End the voyages that end where they begin (ours).

    Parameters
    ----------
    task : Task
        The columns.
    room, lean : number [m]
        Between hull and bank at the start, and which bank is nearer.
    limits : Limits
        What else ends a voyage.
    """
    outcome = task.codes[:, 0]
    outcome[task.steps <= 0] = Outcome.AFLOAT
    outcome[task.start[:, STATE.index("cos_psi")] <= math.cos(limits.heading)] = Outcome.OUTSIDE
    aground = np.broadcast_to(room, outcome.shape) <= 0
    outcome[aground] = Outcome.GROUNDED
    task.codes[aground, 1] = np.sign(np.broadcast_to(lean, outcome.shape)[aground])


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
    workers = workers or len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

    def run(rows: slice) -> int:
        start, pace, steps, *out = task.part(rows)
        return int(kernel.fleet(start, pace, steps, constants(rows), limits, *out))

    slices = _slices(len(task.pace), workers)
    if workers == 1 or len(slices) == 1:
        return _fleet(task, sum(map(run, slices)))
    with ThreadPoolExecutor(min(workers, len(slices))) as pool:
        return _fleet(task, sum(pool.map(run, slices)))


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
    return Fleet(outcome.astype(np.int8), side.astype(np.int8), task.time, psi=psi, steps=steps,
                 lane_steps=lane_steps, **ends)  # fmt: skip
