"""Drifts: a sensor whose innovations lean to one side for long, each small enough to pass the gate, is under suspicion.

A slow spoof or a failing receiver takes the estimate along, and no single reading is refused. The innovations of a
consistent filter are white, but for what its uncertain coefficients add, which is the same all along: a fading sum of
them over its standard deviation is a standard normal number.

References
----------
Roberts (1959), Control chart tests based on geometric moving averages.
"""

from dataclasses import dataclass, field

import numpy as np

# Readings that a sum remembers.
MEMORIES = (6.0, 12.0, 24.0)
# Standard deviations at which a lean is told: by chance once in 1.7 million sums that have nothing in common.
THRESHOLD = 5.0
# Beyond it a reading is the gate's matter, and counts no more than this.
LARGEST = 5.0
FADING = 1.0 - 1.0 / np.array(MEMORIES)[:, None]
SQUARED = FADING * FADING


@dataclass
class DriftMonitor:
    """Fading sums of the innovations of sensors."""

    size: int  # Numbers that the sensors measure, all together
    considered: int = 0  # Errors of coefficients that the filter carries
    sums: np.ndarray = field(init=False)
    variances: np.ndarray = field(init=False)
    common: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.sums, self.variances = np.zeros((2, len(MEMORIES), self.size))
        self.common = np.zeros((len(MEMORIES), self.considered, self.size))

    def lean(self, whitened: np.ndarray, places: np.ndarray | slice, shared: np.ndarray) -> np.ndarray:
        """Take innovations, and return how far the sums lean to one side, in standard deviations, (numbers,)."""
        # whitened (numbers,); places (numbers,); shared (considered, numbers)
        told = np.minimum(np.maximum(whitened, -LARGEST), LARGEST)
        sums = FADING * self.sums[:, places] + told
        variances = SQUARED * self.variances[:, places] + 1.0
        if self.considered:
            variances -= np.minimum((shared * shared).sum(axis=0), 1.0)
        self.sums[:, places], self.variances[:, places] = sums, variances
        if self.considered:
            common = FADING[:, :, None] * self.common[..., places] + shared
            self.common[..., places] = common
            variances = variances + (common * common).sum(axis=1)
        return np.asarray((np.abs(sums) / np.sqrt(variances)).max(axis=0))

    def copy(self) -> "DriftMonitor":
        """Return the same, to go on from."""
        other = DriftMonitor(self.size, self.considered)
        other.sums, other.variances, other.common = self.sums.copy(), self.variances.copy(), self.common.copy()
        return other
