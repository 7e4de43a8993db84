"""States of a ship as its record shows them, smoothed: where the reference path begins."""

import numpy as np

from narrows.logbook.filtering.record_grid import Readings, RecordGrid
from narrows.logbook.filtering.recorded_motion import RecordedMotion

NODES = 9  # that are averaged
SPIKES = 5  # readings among which the middle one is taken


def first_guess(motion: RecordedMotion, grid: RecordGrid) -> np.ndarray:
    """Return the states at the start of each step, (n, 6)."""
    place = {name: _at_nodes(grid, read) for name, read in grid.readings.items() if len(read.values)}
    x, y = (smoothed(place[name]) if name in place else np.zeros(len(grid.times)) for name in ("x", "y"))
    along, across = np.gradient(x, grid.times), np.gradient(y, grid.times)
    psi = smoothed(place["psi"]) if "psi" in place else np.unwrap(np.arctan2(across, along))
    cosine, sine = np.cos(psi), np.sin(psi)
    guessed = {
        "u": along * cosine + across * sine,
        "v": across * cosine - along * sine,
        "r": np.gradient(psi, grid.times) + along * _curvature(motion, x),
    }
    for name, others in (("u", ("u", "u_ground", "speed_over_ground")), ("v", ("v", "v_ground")), ("r", ("r",))):
        guessed[name] = next((smoothed(place[other]) for other in others if other in place), guessed[name])
    states = np.stack([x, y, psi, guessed["u"], guessed["v"], guessed["r"]], axis=1)
    return np.asarray(states[:-1])


def _curvature(motion: RecordedMotion, x: np.ndarray) -> np.ndarray | float:
    """Curvature of the waterway's line, to which the heading is relative."""
    waterway = motion.choices.get("waterway")
    if waterway is None:
        return 0.0
    return np.asarray(waterway.section(np.clip(x, 0.0, waterway.line.length)).curvature)


def _at_nodes(grid: RecordGrid, read: Readings) -> np.ndarray:
    """Readings at the nodes, straight between them, spikes cut off."""
    from scipy.ndimage import median_filter

    return np.asarray(np.interp(grid.times, grid.times_of(read), median_filter(read.values, SPIKES, mode="nearest")))


def smoothed(column: np.ndarray, nodes: int = NODES) -> np.ndarray:
    """Return means of a few nodes, straight on at the ends, (n,)."""
    width = min(nodes, len(column) // 2 * 2 - 1)
    if width < 3:
        return column
    padded = np.pad(column, width // 2, mode="reflect", reflect_type="odd")
    return np.convolve(padded, np.ones(width) / width, "valid")
