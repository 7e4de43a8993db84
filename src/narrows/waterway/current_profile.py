"""A current along and across a line: numbers, or profiles of a place and a number."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from narrows.errors import InputError, shown

# A number, or pairs of a place along the line [m] and the number there, linear between places.
Profile = float | Sequence[Sequence[float]]
# Speed greater than any current [m/s], and shear greater than any [1/s].
FASTEST, STEEPEST = 100.0, 100.0
MEANINGS = {
    "current": "one speed in m/s for its beginning, or (place, speed) pairs along it",
    "current_across": "one speed in m/s to starboard, or (place, speed) pairs along it",
    "current_shear": "its rise in m/s per metre to starboard, or (place, rise) pairs along it",
}


def checked_profile(waterway: str, name: str, value: Any) -> float | tuple[tuple[float, float], ...]:
    """Return a current as a float, or as pairs of place and speed that rise."""
    try:
        # Rows of different length make no float array; text and booleans would be converted to floats.
        kind, values = np.asarray(value).dtype.kind, np.asarray(value, float)
    except (TypeError, ValueError, OverflowError):
        kind, values = "O", np.array(np.nan)
    rows = values.ndim == 2 and values.shape[1] == 2 and bool((np.diff(values[:, 0]) > 0).all())
    speeds = values[:, 1] if rows else values
    largest = STEEPEST if name == "current_shear" else FASTEST
    if kind not in "iuf" or not (values.ndim == 0 or rows) or not (np.abs(speeds) < largest).all():
        what = name.replace("_", " ")
        raise InputError(f"{waterway}: the {what} {shown(value)} is invalid; give {MEANINGS[name]}")
    return tuple((float(place), float(speed)) for place, speed in values) if rows else float(values)


def check_along_only(waterway: Any, user: str) -> None:
    """Raise if the current of a waterway has a component across, or a shear, which its user does not take."""
    if waterway.has_current_field:
        remedy = "give one along the line: with_water(current_across=0, current_shear=0)"
        raise InputError(f"{waterway.name} has a current across or a shear, which {user} does not take; {remedy}")


def profile_at(profile: Profile, s: np.ndarray | float) -> np.ndarray:
    """Return a profile at places along the line."""
    if np.ndim(profile):
        return np.asarray(np.interp(s, *np.transpose(profile)))
    return np.full(np.shape(s), profile)


def current_words(along: np.ndarray, across: Profile, shear: Profile, s: np.ndarray) -> list[str]:
    """Return what is not zero of a current in words."""
    columns = (
        (along, "current", "m/s"), (profile_at(across, s), "current across", "m/s"),
        (profile_at(shear, s), "shear of the current", "1/s"),
    )  # fmt: skip
    return [f"{name} {extent(column)} {unit}" for column, name, unit in columns if column.any()]


def extent(values: np.ndarray) -> str:
    """Return the lowest and highest, once if they are equal."""
    return " to ".join(dict.fromkeys(f"{end:.4g}" for end in (float(np.nanmin(values)), float(np.nanmax(values)))))
