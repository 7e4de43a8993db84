"""Numbers as files give them: each named by its section and key where it cannot be."""

import math
from dataclasses import fields
from typing import Any

from narrows.errors import InputError

PLACES = {
    "Ship": "ship", "Canal": "canal", "Water": "water", "Propeller": "propeller", "Rudder": "rudder",
    "SteeringGear": "steering",
}  # fmt: skip
"""The section of a file that gives each part."""


def check_positive(owner: object, names: tuple[str, ...]) -> None:
    """Raise where a number that is given is not positive (ours).

    Parameters
    ----------
    owner : object
        The part of a configuration.
    names : tuple of str
        Of its numbers.

    Raises
    ------
    InputError
        Names the section and the key.
    """
    for name in names:
        place, value = f"[{PLACES.get(type(owner).__name__, '')}] {name}", getattr(owner, name)
        if value is None:
            continue
        check_number(place, value)
        if value <= 0:
            raise InputError(f"{place} = {value} must be positive, in SI units")


def check_finite(owner: Any) -> None:
    """Raise where a number of a part is not finite (ours).

    Parameters
    ----------
    owner : dataclass
        The part of a configuration, numbers alone.
    """
    for own in fields(owner):
        check_number(f"[{PLACES[type(owner).__name__]}] {own.name}", getattr(owner, own.name))


def check_number(place: str, value: object) -> None:
    """Raise where a value is no finite number (ours).

    Parameters
    ----------
    place : str
        Its section and key.
    value : object
        As given.

    Raises
    ------
    InputError
        Names the place.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{place} = {value!r} is not a finite number; give it in SI units")
