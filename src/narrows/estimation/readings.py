"""Readings as they come from a bridge: by name, checked, without what is no number."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.estimation.sensor import Sensor

Reading = float | Sequence[float]


class Told(NamedTuple):
    """What came in."""

    measured: dict[str, tuple[float, ...]]  # By sensor
    positions: dict[str, float]  # Of actuators
    notes: tuple[str, ...]  # What was no number


def checked_readings(readings: Mapping[str, Any], sensors: Mapping[str, Sensor], actuators: Sequence[str]) -> Told:
    """Part readings into those of sensors and of actuators, and leave out what is no number."""
    measured: dict[str, tuple[float, ...]] = {}
    positions: dict[str, float] = {}
    lost = []
    for name, reading in readings.items():
        if name not in sensors and name not in actuators:
            known = (*sensors, *actuators)
            hint = did_you_mean(name, known) or f"; there are {', '.join(known)}"
            raise InputError(f"no sensor of this estimator is called {name!r}{hint}")
        numbers = _numbers(name, reading, len(sensors[name].fields) if name in sensors else 1)
        if not all(map(math.isfinite, numbers)):
            lost.append(name)
        elif name in sensors:
            measured[name] = numbers
        else:
            positions[name] = numbers[0]
    notes = (f"What {' and '.join(lost)} told is no number: it counts as not told.",) if lost else ()
    return Told(measured, positions, notes)


def _numbers(name: str, reading: Any, count: int) -> tuple[float, ...]:
    try:
        if isinstance(reading, float):
            return (reading,) if count == 1 else _refused(name, 1, count)
        numbers = tuple(map(float, reading if isinstance(reading, tuple) else np.ravel(reading)))
    except (TypeError, ValueError):
        raise InputError(f"a reading of {name} is {count} number(s), and this one is {reading!r}") from None
    if len(numbers) != count:
        return _refused(name, len(numbers), count)
    return numbers


def _refused(name: str, told: int, count: int) -> tuple[float, ...]:
    raise InputError(f"a reading of {name} is {count} number(s), and this one has {told}; give as many")
