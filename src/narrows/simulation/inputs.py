"""What drives the ship beside the water: constant or scheduled surge force, sway force and yaw moment."""

from collections.abc import Callable, Sequence

import numpy as np

from narrows.errors import InputError

Schedule = float | Sequence[Sequence[float]]
"""A constant, or pairs of (time [s], value): each value holds from its time until the next."""

Forces = Callable[[float], tuple[float, float, float]]


def forces_over_time(X: Schedule = 0.0, Y: Schedule = 0.0, N: Schedule = 0.0) -> Forces:
    """Return the three inputs as one function of time (ours).

    Parameters
    ----------
    X, Y : float or pairs [N]
        Surge and sway force.
    N : float or pairs [N m]
        Yaw moment.

    Raises
    ------
    InputError
        Where a schedule is not pairs of finite numbers in rising time.
    """
    parts = [_one(name, schedule) for name, schedule in (("X", X), ("Y", Y), ("N", N))]
    if all(isinstance(part, float) for part in parts):
        constant = tuple(parts)
        return lambda t: constant  # type: ignore[return-value]
    functions = [part if callable(part) else (lambda t, value=part: value) for part in parts]
    return lambda t: tuple(function(t) for function in functions)  # type: ignore[return-value]


def _one(name: str, schedule: Schedule) -> float | Callable[[float], float]:
    values = np.asarray(schedule, dtype=float)
    if values.ndim == 0 and np.isfinite(values):
        return float(values)
    if values.ndim != 2 or values.shape[1] != 2 or not np.isfinite(values).all():
        raise InputError(f"input {name} must be a finite number or pairs of (time, value)")
    times, steps = values[:, 0], values[:, 1]
    if (np.diff(times) <= 0).any():
        raise InputError(f"input {name}: the times of its schedule must rise")
    return lambda t: float(steps[np.searchsorted(times, t, side="right") - 1]) if t >= times[0] else 0.0
