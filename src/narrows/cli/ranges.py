"""Numbers, ranges of them and speeds, as the command line spells them."""

import re

import numpy as np

from narrows.errors import InputError, shown
from narrows.quantities.constants import KNOT

# Of a speed as written, in m/s.
SPEED_UNITS = {"": 1.0, "m/s": 1.0, "kn": KNOT, "km/h": 1 / 3.6}
# Values of a range.
MOST = 1_000_000
UNIT = re.compile(r"(?:m/s|kn|km/h)?\s*$")


def numbers(option: str, text: str, such_as: str = "0.5, or 0.5,1,2, or -2.5:2.5:101") -> np.ndarray:
    """Read ``0.5``, ``0.5,1,2`` or ``from:to:count``."""
    try:
        if ":" in text:
            low, high, count = text.split(":")
            values = np.linspace(float(low), float(high), min(int(count), MOST + 1))
        else:
            values = np.array([float(word) for word in text.split(",")])
    except (ValueError, OverflowError):
        raise InputError(f"{option} {shown(text)} is not understood; give {such_as}") from None
    if values.size > MOST:
        raise InputError(f"{option} {shown(text)} asks for more than {MOST} values; take fewer")
    if not values.size or not np.isfinite(values).all():
        raise InputError(f"{option} {shown(text)} must be finite numbers, at least one")
    return values


def speeds(option: str, text: str) -> np.ndarray:
    """Read speeds [m/s]: as numbers, each with its unit or all without: ``4.1m/s``, ``8kn,9kn``, ``4kn:12kn:17``."""
    between = ":" if ":" in text else ","
    words = text.split(between)
    carry = words[:2] if between == ":" else words
    units = {UNIT.search(word)[0].strip() for word in carry}  # type: ignore[index]
    if len(units) > 1:
        raise InputError(
            f"{option} {shown(text)} has several units, or numbers without; give each number the same unit"
        )
    (unit,) = units
    plain = between.join([word.strip().removesuffix(unit) for word in carry] + words[len(carry) :])
    return numbers(option, plain, "4.1m/s, 8kn, or 8kn,9kn, or 4kn:12kn:17") * SPEED_UNITS[unit]


def speed(option: str, text: str) -> float:
    """Read one speed [m/s]."""
    values = speeds(option, text)
    if values.size != 1:
        raise InputError(f"{option} {shown(text)} is more than one speed; give one, as 4.1m/s or 8kn")
    return float(values[0])
