"""What drives the ship beside the water: constant or scheduled surge force, sway force and yaw moment."""

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
