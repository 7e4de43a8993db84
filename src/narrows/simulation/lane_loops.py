"""Loops over lanes of one ship, before and after the kernel's step, which Numba compiles.

A lane is a state: x, y, psi, u, v, r, then others; ``places`` are those of bank, current, current_across and
rudder_bias among them, -1 for none.
"""

import math

import numpy as np


def depart(
    points: np.ndarray, places: np.ndarray, rows: np.ndarray, inputs: np.ndarray, base: np.ndarray, slope: np.ndarray,
    kept: np.ndarray, rates: np.ndarray, rudder: int, start: np.ndarray, end: np.ndarray, duration: float,
    bend: float, known: float, least: float,
) -> np.ndarray:  # fmt: skip
    """Fill the kernel's rows and inputs; return the states after half of the current's drift."""
    # kept, rates: places of the actuators in the rows and inputs; start, end (1 or lanes, actuators).
    after = drift(points.copy(), places, duration / 2, bend, known)
    for lane in range(len(points)):
        row, heading = rows[lane], after[lane, 2]
        row[0], row[1] = max(after[lane, 0], least), after[lane, 1]
        for speed in range(3):  # Number by number, here and below: Numba takes seconds to compile a slice that is set.
            row[4 + speed] = after[lane, 3 + speed]
        row[2], row[3] = math.cos(heading), math.sin(heading)
        bank = points[lane, places[0]] if places[0] >= 0 else 0.0
        for place in range(inputs.shape[1]):
            inputs[lane, place] = base[lane, place] + bank * slope[lane, place]
        here, there = start[min(lane, len(start) - 1)], end[min(lane, len(end) - 1)]
        for number in range(len(kept)):
            biased = number == rudder and places[3] >= 0
            row[kept[number]] = here[number] + (points[lane, places[3]] if biased else 0.0)
            inputs[lane, rates[number]] = (there[number] - here[number]) / duration
    return after


def arrive(
    after: np.ndarray, places: np.ndarray, rows: np.ndarray, ended: np.ndarray, duration: float, bend: float,
    known: float, change: float,
) -> None:  # fmt: skip
    """Add the kernel's step, the change of the waterway's current, and the other half of the drift to the states."""
    for lane in range(len(after)):
        before, row = rows[lane], ended[lane]
        after[lane, 0] += row[0] - before[0]
        after[lane, 1] += row[1] - before[1]
        # The heading by its change, so that whole turns are kept.
        after[lane, 2] += math.atan2(row[3] * before[2] - row[2] * before[3], row[2] * before[2] + row[3] * before[3])
        for speed in range(3):
            after[lane, 3 + speed] = row[4 + speed]
        if places[1] >= 0:
            after[lane, places[1]] += change
    drift(after, places, duration, bend, known)


def drift(points: np.ndarray, places: np.ndarray, duration: float, bend: float, known: float) -> np.ndarray:
    """Move the states by the current's difference from the known one of the waterway [m/s], and return them."""
    for lane in range(len(points)):
        point = points[lane]
        if places[1] >= 0:
            gone = duration * (point[places[1]] - known) / (1.0 - bend * point[1])
            point[2] -= bend * gone
            point[0] += gone
        if places[2] >= 0:
            point[1] += duration * point[places[2]]
    return points
