"""The elementary functions of plain Python, for floats and for columns: what printed lines call."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np


def _root(value: float) -> float:
    return math.sqrt(value) if value >= 0 else math.nan


def _power(base: float, exponent: float) -> float:
    return base**exponent if base >= 0 or exponent.is_integer() else math.nan


def _entries(row: int) -> Callable[[Any, int, float], float]:
    return lambda table, column, cell: float(table[row * int(cell) + column])


def scalar_functions(row: int) -> dict[str, Callable[..., Any]]:
    """Return the elementary functions for floats."""
    return {
        "minimum": lambda a, b: a if a < b else b,
        "maximum": lambda a, b: a if a > b else b,
        "choice": lambda test, over, under: over if test > 0 else under,
        "positive": lambda test: 1.0 if test > 0 else 0.0,
        "whole": lambda number: float(int(number)),
        "angle": lambda cosine, sine: math.atan2(sine, cosine),
        "sine": math.sin,
        "cosine": math.cos,
        "sqrt": _root,
        "exp": math.exp,
        "log": math.log,
        "power": _power,
        "entry": _entries(row),
    }


def _column_entries(row: int) -> Callable[[Any, int, Any], Any]:
    def entry(table: Any, column: int, cell: Any) -> Any:
        return np.asarray(table)[row * np.nan_to_num(cell).astype(np.int64) + column]

    return entry


def column_functions(row: int = 0) -> dict[str, Callable[..., Any]]:
    """Return the elementary functions for floats and columns alike."""
    return {
        "minimum": np.minimum,
        "maximum": np.maximum,
        "choice": lambda test, over, under: np.where(np.asarray(test) > 0, over, under),
        "positive": lambda test: np.where(np.asarray(test) > 0, 1.0, 0.0),
        "whole": np.trunc,
        "angle": lambda cosine, sine: np.arctan2(sine, cosine),
        "sine": np.sin,
        "cosine": np.cos,
        "sqrt": np.sqrt,
        "exp": np.exp,
        "log": np.log,
        "power": np.power,
        "entry": _column_entries(row),
    }
