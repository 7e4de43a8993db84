"""The one way from a result to JSON."""

import json
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: None for NaN and infinity, lists for arrays.

    Parameters
    ----------
    value : Any
        Mappings, sequences, arrays, numbers, words, True, False, None.

    Raises
    ------
    TypeError
        Where there is anything else in it.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, Iterable):
        return [plain(part) for part in value]
    raise TypeError(f"{type(value).__name__} has no place in JSON")


def to_json(value: Any) -> str:
    """Write a value, or what a result's ``to_dict`` gives, as JSON.

    Parameters
    ----------
    value : Any
        As in ``plain``.
    """
    return json.dumps(plain(value), indent=2, allow_nan=False)
