"""Derivatives of a motion at many points: one compiled copy serves all models."""

from typing import Any

from narrows.codegen.addresses import call_into

Array = Any


def at_points(linear: Any, values: Array, constants: Array, out: Array) -> None:
    """Write what ``linear(values, constants)``, by its address, returns at each row of values into that of ``out``."""
    for row in range(len(values)):
        call_into(linear, out[row], (values[row], constants))
