"""Readings from tables and from a bridge: checked, by sensors and actuators."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.estimation.sensors import Sensor

TIME = "t"


@dataclass(frozen=True)
class Records:
    t: np.ndarray  # (rows,) Rising times [s]
    readings: dict[str, np.ndarray]  # (rows, numbers) Readings by sensor
    positions: dict[str, np.ndarray]  # (rows,) Positions of actuators, by name

    def rows(self) -> Iterator[tuple[float, dict[str, np.ndarray], dict[str, float]]]:
        """Yield each time with the valid readings and actuator positions."""
        for number, t in enumerate(self.t.tolist()):
            now = {name: column[number] for name, column in self.readings.items() if np.isfinite(column[number]).all()}
            known = {n: float(column[number]) for n, column in self.positions.items() if np.isfinite(column[number])}
            yield t, now, known


def records_of(table: Any, sensors: Mapping[str, Sensor], actuators: Sequence[str]) -> Records:
    columns = _columns(table)
    fields = {field for sensor in sensors.values() for field in sensor.fields}
    if TIME not in columns:
        raise InputError("records need their times; give a column t [s]")
    for name in columns:
        if name not in fields and name not in actuators and name != TIME:
            known = (TIME, *sorted(fields), *actuators)
            hint = did_you_mean(name, known) or f"; there are {', '.join(known)}"
            raise InputError(f"no sensor of this estimator has a column {name!r}{hint}")
    t = columns[TIME]
    if len(t) == 0 or not np.isfinite(t).all() or (np.diff(t) <= 0.0).any():
        raise InputError("times of records are finite and rise; sort them, and merge rows of one time")
    nothing = np.full(len(t), np.nan)
    readings = {
        name: np.stack([columns.get(field, nothing) for field in sensor.fields], axis=1)
        for name, sensor in sensors.items()
    }
    return Records(t, readings, {name: columns[name] for name in actuators if name in columns})


def _columns(table: Any) -> dict[str, np.ndarray]:
    if hasattr(table, "coords") and hasattr(table, "data_vars"):
        table = {name: table[name] for name in (*table.coords, *table.data_vars)}
    elif hasattr(table, "reset_index"):
        frame = table.reset_index() if table.index.name == TIME else table
        table = {name: frame[name] for name in frame.columns}
    if not isinstance(table, Mapping):
        raise InputError("records are a DataFrame, a Dataset or a mapping of columns; give one")
    try:
        columns = {str(name): np.asarray(column, float) for name, column in table.items()}
    except (TypeError, ValueError):
        raise InputError("records contain a value that is not a number; leave missing values empty (NaN)") from None
    sizes = {column.shape for column in columns.values()}
    if len(sizes) > 1 or any(len(size) != 1 for size in sizes):
        raise InputError("columns of records have different lengths; give one value per row, NaN for no reading")
    return columns


# Readings from a bridge: by name, checked, without NaN.
Reading = float | Sequence[float]


def checked_readings(
    readings: Mapping[str, Any], sensors: Mapping[str, Sensor], actuators: Sequence[str]
) -> tuple[dict[str, tuple[float, ...]], dict[str, float], tuple[str, ...]]:
    """Split readings into those of sensors and of actuators, without NaN, and a note on invalid ones."""
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
    notes = (f"The reading of {' and '.join(lost)} is not a number and was not used.",) if lost else ()
    return measured, positions, notes


def _numbers(name: str, reading: Any, count: int) -> tuple[float, ...]:
    if count == 1 and isinstance(reading, float):  # Fast path for the most frequent case
        return (reading,)
    if reading is None:
        return (math.nan,) * count
    try:
        numbers = tuple(np.asarray(reading, float).ravel().tolist())
    except (TypeError, ValueError):
        raise InputError(f"a reading of {name} is {count} number(s), and this one is {reading!r}") from None
    if len(numbers) != count:
        raise InputError(f"a reading of {name} is {count} number(s), and this one has {len(numbers)}; give as many")
    return numbers
