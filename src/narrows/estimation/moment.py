"""What is known of a ship at a time, to go on from or to go back to."""

from typing import NamedTuple

import numpy as np

from narrows.estimation.drift_monitor import DriftMonitor
from narrows.estimation.unscented import Normal


class Moment(NamedTuple):
    """What is known at a time, to go on from or to go back to."""

    t: float  # When [s]
    normal: Normal  # The state
    positions: np.ndarray  # (actuators,) Indicated positions
    readings: dict[str, tuple[float, ...]]  # What was measured then
    monitor: DriftMonitor  # After them
