"""How noisy signals are, by what the model leaves of them, and how much of that is one and the same."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.search_state import Found

# Correlation under which residuals are taken to have nothing to do with each other.
FORGOTTEN = 0.05
MOST_LAGS = 2000


@dataclass(frozen=True)
class NoiseLeft:
    """What is left of a signal."""

    # Standard deviation of a reading: 1.4826 times the median of sizes, which outliers do not move [unit of the
    # signal]
    size: float
    memory: float  # Readings for each independent one [1]
    beyond: float  # Share of readings beyond four of these standard deviations [1]

    @property
    def counted(self) -> float:
        """Standard deviation that readings are to be given for so many to tell what they tell."""
        return float(self.size * np.sqrt(self.memory))


def noise_left(grids: Iterable[RecordGrid], found: Found) -> dict[str, NoiseLeft]:
    """Return what is left of each signal over all records."""
    left: dict[str, list[np.ndarray]] = {}
    for grid, told in zip(grids, found.told, strict=False):  # Fewer were looked at where it was interrupted.
        for name, residual in (told.residuals or {}).items():
            left.setdefault(name, []).append(residual * np.sqrt(grid.readings[name].counted))
    return {name: _left(parts) for name, parts in left.items()}


def _left(parts: Sequence[np.ndarray]) -> NoiseLeft:
    whole = np.concatenate(parts)
    size = float(1.4826 * np.median(np.abs(whole))) or float(np.abs(whole).max(initial=0.0)) or 1e-12
    clipped = [np.clip(part, -4 * size, 4 * size) for part in parts]
    spread = float(np.sqrt(np.mean(np.concatenate(clipped) ** 2)))
    return NoiseLeft(spread, memory_of(clipped), float(np.mean(np.abs(whole) > 4 * size)))


def memory_of(parts: Sequence[np.ndarray]) -> float:
    """Return how many readings there are for each independent one [1]."""
    # parts (n,)
    # One and twice the sum of the autocorrelation, to where it is first forgotten.
    # Bayley and Hammersley (1946), The "effective" number of independent observations in an autocorrelated time
    # series.
    power = sum(float(part @ part) for part in parts)
    memory = 1.0
    for lag in range(1, MOST_LAGS):
        along = sum(float(part[lag:] @ part[:-lag]) for part in parts if len(part) > lag)
        if not power or along / power <= FORGOTTEN:
            break
        memory += 2 * along / power
    return memory
