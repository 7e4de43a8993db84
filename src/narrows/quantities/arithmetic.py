"""Functions for physics and control laws besides sums, products, powers and ``abs()``: floats, columns, symbols."""

from collections.abc import Callable
from typing import Any

import numpy as np

from narrows.quantities.names import Number

# The functions for floats and columns, by name.
COLUMNS: dict[str, Callable[..., Any]] = {
    "minimum": np.minimum,
    "maximum": np.maximum,
    "choice": lambda test, over, under: np.where(np.asarray(test) > 0, over, under),
    "angle": lambda cosine, sine: np.arctan2(sine, cosine),
    "sine": np.sin,
    "cosine": np.cos,
}


def minimum(one: Number, other: Number) -> Number:
    return _evaluated("minimum", one, other)


def maximum(one: Number, other: Number) -> Number:
    return _evaluated("maximum", one, other)


def clip(value: Number, most: Number) -> Number:
    """Return a number clipped to between ``-most`` and ``most``."""
    return minimum(maximum(value, -most), most)


def choice(test: Number, over: Number, under: Number) -> Number:
    """Return ``over`` where ``test`` is over 0, else ``under``."""
    return _evaluated("choice", test, over, under)


def angle(cosine: Number, sine: Number) -> Number:
    """Return the angle from its cosine and sine, between -pi and pi [rad]."""
    return _evaluated("angle", cosine, sine)


def sine(angle: Number) -> Number:
    return _evaluated("sine", angle)


def _evaluated(name: str, *values: Number) -> Number:
    """Evaluate by the value's own method (a recording placeholder), or by NumPy."""
    for value in values:
        apply = getattr(value, "apply_function", None)
        if apply is not None:
            return apply(name, values)
    return COLUMNS[name](*values)
