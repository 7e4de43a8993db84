"""Readings from tables and from a bridge: checked, by sensors and actuators."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.estimation.sensors import Sensor

if TYPE_CHECKING:
    import pandas as pd

TIME = "t"
# Readings from a bridge: by name, checked, without NaN.
Reading = float | Sequence[float]


def records_of(table: Any, sensors: Mapping[str, Sensor], actuators: Sequence[str]) -> "pd.DataFrame":
    """Return a column for each field and each actuator, NaN without readings, over rising times."""
    import pandas as pd

    try:
        frame = pd.DataFrame(table.to_dataframe() if hasattr(table, "to_dataframe") else table)
        frame = (frame.reset_index() if frame.index.name == TIME else frame).astype(float)
    except (TypeError, ValueError):
        raise InputError(
            "records are a DataFrame, a Dataset or a mapping of columns of numbers, all of one length; give one, with "
            "missing values empty (NaN)"
        ) from None
    known = [TIME, *(field for sensor in sensors.values() for field in sensor.fields), *actuators]
    for name in frame.columns:
        if name not in known:
            raise InputError(f"no sensor of this estimator has a column {name!r}{did_you_mean(str(name), known)}")
    if TIME not in frame:
        raise InputError("records need their times; give a column t [s]")
    t = frame[TIME].to_numpy()
    if len(t) == 0 or not np.isfinite(t).all() or (np.diff(t) <= 0.0).any():
        raise InputError("times of records are finite and rise; sort them, and merge rows of one time")
    return frame.reindex(columns=known).set_index(TIME)


def rows_of(
    records: "pd.DataFrame", sensors: Mapping[str, Sensor], actuators: Sequence[str]
) -> Iterator[tuple[float, dict[str, tuple[float, ...]]]]:
    """Yield each time with its readings, and positions of actuators, without NaN."""
    fields = {**{name: list(sensor.fields) for name, sensor in sensors.items()}, **{name: [name] for name in actuators}}
    columns = {name: records[own].to_numpy() for name, own in fields.items()}
    for number, t in enumerate(records.index.tolist()):
        now = {name: column[number] for name, column in columns.items()}
        yield t, {name: tuple(row.tolist()) for name, row in now.items() if np.isfinite(row).all()}


def checked_readings(
    readings: Mapping[str, Any], sensors: Mapping[str, Sensor], actuators: Sequence[str]
) -> tuple[dict[str, tuple[float, ...]], dict[str, float], list[str]]:
    """Split readings into those of sensors and of actuators, without NaN, and a note on invalid ones."""
    measured: dict[str, tuple[float, ...]] = {}
    positions: dict[str, float] = {}
    lost = []
    for name, reading in readings.items():
        if name not in sensors and name not in actuators:
            raise InputError(
                f"no sensor of this estimator is called {name!r}{did_you_mean(name, (*sensors, *actuators))}"
            )
        numbers = _numbers(name, reading, len(sensors[name].fields) if name in sensors else 1)
        if not all(map(math.isfinite, numbers)):
            lost.append(name)
        elif name in sensors:
            measured[name] = numbers
        else:
            positions[name] = numbers[0]
    notes = [f"The reading of {' and '.join(lost)} is not a number and was not used."] if lost else []
    return measured, positions, notes


def _numbers(name: str, reading: Any, count: int) -> tuple[float, ...]:
    if count == 1 and isinstance(reading, float):  # Fast path for the most frequent case
        return (reading,)
    try:
        numbers = tuple(np.asarray(math.nan if reading is None else reading, float).ravel().tolist())
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != count and reading is not None:
        raise InputError(f"a reading of {name} is {count} number(s), and this one is {reading!r}; give as many")
    return numbers
