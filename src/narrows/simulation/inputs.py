"""What drives the ship beside the water: constant or scheduled surge force, sway force and yaw moment."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from narrows.errors import InputError

Schedule = float | Sequence[Sequence[float]]
"""A constant, or pairs of (time [s], value): each value holds from its time until the next, and 0 before the first."""


class Stretch(NamedTuple):
    """A time over which the inputs are constant.

    Parameters
    ----------
    start, stop : float [s]
        From when until when.
    forces : tuple of float [N, N, N m]
        Surge force, sway force, yaw moment.
    """

    start: float
    stop: float
    forces: tuple[float, float, float]


def stretches(X: Schedule, Y: Schedule, N: Schedule, stop: float) -> list[Stretch]:
    """Cut a voyage where its inputs jump, so that no step reaches over a jump (ours).

    Parameters
    ----------
    X, Y : float or pairs [N]
        Surge and sway force.
    N : float or pairs [N m]
        Yaw moment.
    stop : float [s]
        End of the voyage.

    Raises
    ------
    InputError
        Where a schedule is not pairs of finite numbers in rising time.
    """
    tables = [_table(name, schedule) for name, schedule in (("X", X), ("Y", Y), ("N", N))]
    jumps = sorted({0.0, *(t for times, _ in tables for t in times.tolist() if 0 < t < stop)})
    return [
        Stretch(begin, end, (_value(tables[0], begin), _value(tables[1], begin), _value(tables[2], begin)))
        for begin, end in zip(jumps, [*jumps[1:], stop], strict=True)
    ]


def _value(table: tuple[np.ndarray, np.ndarray], t: float) -> float:
    times, values = table
    place = int(np.searchsorted(times, t, side="right")) - 1
    return float(values[place]) if place >= 0 else 0.0


def _table(name: str, schedule: Schedule) -> tuple[np.ndarray, np.ndarray]:
    values = np.asarray(schedule, dtype=float)
    if values.ndim == 0:
        values = np.array([[0.0, float(values)]])
    if values.ndim != 2 or values.shape[1] != 2 or not np.isfinite(values).all():
        raise InputError(f"input {name} must be a finite number or pairs of (time, value)")
    if (np.diff(values[:, 0]) <= 0).any():
        raise InputError(f"input {name}: the times of its schedule must rise")
    return values[:, 0], values[:, 1]


def finite_numbers(**values: object) -> dict[str, float]:
    """Return arguments as finite floats (ours).

    Parameters
    ----------
    **values : object
        As a caller gave them, by name.

    Raises
    ------
    InputError
        Where one is no finite number: with its name.
    """
    found = {}
    for name, value in values.items():
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name} = {str(value)[:40]} must be a finite number") from None
        if not math.isfinite(number):
            raise InputError(f"{name} = {number} must be finite")
        found[name] = number
    return found


def check_steps(duration: object, dt: object, most: float) -> tuple[float, float]:
    """Return a duration and a time step [s] (ours).

    Parameters
    ----------
    duration, dt : object
        As a caller gave them.
    most : float
        Steps that can be taken.

    Raises
    ------
    InputError
        Where one is not positive and finite, or there would be too many steps.
    """
    numbers = finite_numbers(duration=duration, dt=dt)
    for name, number in numbers.items():
        if number <= 0:
            raise InputError(f"{name} = {number} must be a positive, finite number")
    if numbers["duration"] / numbers["dt"] > most:
        raise InputError(
            f"a duration of {numbers['duration']:g} s in steps of {numbers['dt']:g} s is more than {most:.0g} steps; "
            "lengthen dt"
        )
    return numbers["duration"], numbers["dt"]


def check_times(at: Sequence[float], duration: float | None) -> list[float]:
    """Return output times after the start [s] (ours).

    Parameters
    ----------
    at : sequence of float
        As a caller gave them.
    duration : float [s], optional
        That they must lie within.

    Raises
    ------
    InputError
        Where they do not rise, or one is no finite number.
    """
    try:
        times = [float(t) for t in at]
    except (TypeError, ValueError, OverflowError):
        times = [math.nan]
    times = [t for t in times if not t <= 0]
    if not times or not all(map(math.isfinite, times)) or sorted(set(times)) != times:
        raise InputError("at: give rising, finite output times after 0 s")
    if duration is not None and times[-1] > duration:
        raise InputError(f"at: {times[-1]:g} s lies beyond the duration of {duration:g} s; lengthen it")
    return times


def check_workers(workers: int | None) -> None:
    """Raise where a number of threads is none (ours).

    Parameters
    ----------
    workers : int, optional
        As a caller gave it.

    Raises
    ------
    InputError
        Where it is no whole number from 1.
    """
    if workers is not None and not (isinstance(workers, int) and workers >= 1):
        raise InputError(f"workers = {workers!r}: give a whole number from 1, or leave it out for all cores")
