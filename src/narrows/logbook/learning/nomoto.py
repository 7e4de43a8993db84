"""The nonlinear Nomoto model, the simplest with which a model of forces has to compare."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from narrows.logbook.filtering.record_grid import RecordGrid

# The yaw rate, in turns of one radian a ship length, that the largest rudder of a record turns the ship with, about.
USUAL_TURN = 0.5
NUMBERS = 5
# Standard deviation of a compass reading [rad], which only weighs the start; and of the yaw rate at the start [rad/s].
READING, START_RATE = 0.01, 0.01


@dataclass(frozen=True)
class HeadingRecord:
    """The part of a record for the Nomoto model: rudder and heading on even times."""

    step: float  # [s]
    rudder: np.ndarray  # (nodes,) [rad]
    heading: np.ndarray  # (nodes,) [rad]
    rate: float  # Yaw rate at the start [rad/s]


def heading_record(grid: RecordGrid) -> HeadingRecord | None:
    """Return rudder and heading of a record; None where one of them was not recorded."""
    if "psi" not in grid.readings or "rudder" not in grid.positions:
        return None
    read = grid.readings["psi"]
    heading = np.interp(grid.times, grid.times_of(read), read.values)
    few = min(10, len(heading) - 1)
    return HeadingRecord(
        grid.step, grid.positions["rudder"], heading, float(heading[few] - heading[0]) / few / grid.step
    )


def headings(numbers: np.ndarray, record: HeadingRecord, start: np.ndarray) -> np.ndarray:
    """Integrate ``rdot = a rudder + b + c r + d |r| r + e r^3`` by Euler's method."""
    a, b, c, d, e = numbers
    psi, r, path = start[0], start[1], np.empty(len(record.rudder))
    for place, rudder in enumerate(record.rudder.tolist()):
        path[place] = psi
        psi += record.step * r
        r += record.step * (a * rudder + b + (c + d * abs(r) + e * r * r) * r)
        if not abs(r) < 1.0:
            path[place:] = 1e3
            break
    return path


def fitted_nomoto(records: Sequence[HeadingRecord], time: float) -> np.ndarray:
    """Fit the five numbers, and the start of each record, to headings under the recorded rudder."""
    # time [s], of a ship length
    from scipy.optimize import least_squares

    scale = np.array([1.0, 0.01, time, time**2, time**3]) / time**2
    first = np.array([USUAL_TURN, 0.0, -1.0, 0.0, -4.0])

    def residuals(unknowns: np.ndarray) -> np.ndarray:
        starts = unknowns[NUMBERS:].reshape(-1, 2)
        return np.concatenate([_left(unknowns[:NUMBERS] * scale, *pair) for pair in zip(records, starts, strict=True)])

    found = least_squares(residuals, np.append(first, np.zeros(2 * len(records))), method="trf", max_nfev=40)
    return np.asarray(found.x[:NUMBERS] * scale)


def nomoto_missed(numbers: np.ndarray, record: HeadingRecord) -> float:
    """Return the root mean square of what the model misses of the heading, its start fitted [rad]."""
    from scipy.optimize import least_squares

    def residuals(start: np.ndarray) -> np.ndarray:
        return _left(numbers, record, start)

    found = least_squares(residuals, np.zeros(2), max_nfev=40)
    return float(np.sqrt(np.mean(found.fun**2)) * READING)


def _left(numbers: np.ndarray, record: HeadingRecord, start: np.ndarray) -> np.ndarray:
    """Headings missed over the error of a reading; start (2,) in units of READING and START_RATE."""
    begun = np.array([record.heading[0] + READING * start[0], record.rate + START_RATE * start[1]])
    return np.asarray((headings(numbers, record, begun) - record.heading) / READING)
