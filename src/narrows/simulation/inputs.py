"""External inputs of the ship: constant or scheduled surge force, sway force and yaw moment."""

import math
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from narrows.base.errors import InputError, check_choice, check_count, shown
from narrows.codegen.free_motion import Surge
from narrows.quantities.names import Number
from narrows.ship.checks import LARGEST
from narrows.simulation.settings import MOST_EXTENT, MOST_POINTS, MOST_WORKERS

# Default state at the start; sinkage and rudder angle, constant through a voyage.
START = {"x": 0.0, "y": 0.0, "psi": 0.0, "u": 1.0, "v": 0.0, "r": 0.0}
STEADY = {"heave": 0.0, "rudder": 0.0}

# Hull points that meet a bank, unless an outline is given.
Contact = Literal["corners", "midship", "none"]

# A constant, or pairs of (time [s], value): each value holds from its time until the next, and 0 before the first.
Schedule = float | Sequence[Sequence[float]]


class Segment(NamedTuple):
    start: float  # [s]
    stop: float  # [s]
    forces: tuple[float, float, float]  # Surge force, sway force, yaw moment [N, N, N m]


def segments_of(X: Schedule, Y: Schedule, N: Schedule, stop: float) -> list[Segment]:
    """Split a voyage where its inputs jump, so that no step crosses a jump."""
    tables = [table_of(name, schedule) for name, schedule in (("X", X), ("Y", Y), ("N", N))]
    jumps = sorted({0.0, *(t for times, _ in tables for t in times.tolist() if 0 < t < stop)})
    # A value is 0 before the first time.
    columns = [np.append(0.0, values)[np.searchsorted(times, jumps, side="right")].tolist() for times, values in tables]
    return [*map(Segment, jumps, [*jumps[1:], stop], zip(*columns, strict=True))]


def table_of(name: str, schedule: Schedule) -> tuple[np.ndarray, np.ndarray]:
    values = real_numbers(schedule)
    if values.ndim == 0:
        values = np.array([[0.0, float(values)]])
    if values.ndim != 2 or values.shape[1] != 2 or not (np.abs(values) < LARGEST).all():
        raise InputError(f"input {name} must be a finite number or pairs of (time, value)")
    if (np.diff(values[:, 0]) <= 0).any():
        raise InputError(f"input {name}: the times of its schedule must rise")
    return values[:, 0], values[:, 1]


def real_numbers(value: Any) -> np.ndarray:
    """Return an array of floats; NaN for words, truth values and whatever else is no number."""
    try:
        values = np.asarray(value)
        return values.astype(float) if values.dtype.kind in "iufO" else np.array(math.nan)
    except (TypeError, ValueError, OverflowError):
        return np.array(math.nan)


def finite_numbers(**values: object) -> dict[str, float]:
    return {name: _finite(name, value) for name, value in values.items()}


def _finite(name: str, value: Any) -> float:
    numbers = real_numbers(value)
    number = math.nan if numbers.ndim else float(numbers)
    if not math.isfinite(number):
        state = name == "x" and isinstance(value, list | tuple | np.ndarray)
        hint = "; x is the place along the canal [m], and a state is given by name: y=0.5, u=1.0, psi=0.0" * state
        several = "; for several take a loop, or nw.ensemble" * isinstance(value, list | tuple | np.ndarray)
        steered = "; controller=... takes a function of time and state" * callable(value)
        raise InputError(f"{name} = {shown(value)} must be a finite number{hint or several or steered}")
    if not abs(number) < LARGEST:
        raise InputError(f"{name} = {shown(value)} is beyond all measure; check its unit")
    return number


def check_steps(duration: object, dt: object, most: float) -> tuple[float, float]:
    for name, value in (("duration", duration), ("dt", dt)):
        if _finite(name, value) <= 0:
            raise InputError(f"{name} = {shown(value)} must be a positive, finite number")
    longest, step = _finite("duration", duration), _finite("dt", dt)
    steps = longest / step
    if steps > most:
        asked = f"duration = {longest:g} s in steps of dt = {step:g} s is {steps:.3g} steps"
        raise InputError(f"{asked}, and more than {most:.0g} are refused; lengthen dt or shorten the duration")
    return longest, step


def check_workers(workers: object) -> None:
    if workers is not None:
        check_count("workers", workers, 1, MOST_WORKERS)


def check_options(surge: object, surge_inertia: object, coriolis: object, contact: object) -> None:
    check_choice("surge", surge, get_args(Surge))
    if surge_inertia is not None:
        finite_numbers(surge_inertia=surge_inertia)
        if surge == "held":
            raise InputError("surge_inertia changes nothing: the speed is held; give surge='free', or leave it out")
    check_flag("coriolis", coriolis)
    if isinstance(contact, str):
        check_choice("contact", contact, get_args(Contact))
        return
    points = real_numbers(contact)
    known = points.ndim == 2 and points.shape[1] == 2 and (np.abs(points) < MOST_EXTENT).all()
    if not known or not 3 <= len(points) <= MOST_POINTS:
        outline = f"an outline as 3 to {MOST_POINTS} points (forward, starboard) in metres"
        raise InputError(f"contact = {shown(contact)}: give corners, midship, none, or {outline}")


def check_flag(name: str, value: object) -> None:
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} = {shown(value)}: give True or False")


def check_waterway(waterway: object) -> None:
    if waterway is not None and not hasattr(waterway, "line"):
        raise InputError(f"waterway = {shown(waterway)} is none; read one with read_waterway")


def counted_heading(cosine: Number, sine: Number, near: Number) -> np.ndarray:
    """Return the angle of a cosine and a sine that is nearest to another angle with whole turns [rad]."""
    angle = np.arctan2(sine, cosine)
    return np.asarray(angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi)))
