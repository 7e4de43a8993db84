"""What is known of a ship at a time, to go on from or to go back to."""

from typing import NamedTuple

import numpy as np

from narrows.estimation.drift_monitor import DriftMonitor
from narrows.estimation.unscented import Normal


class Moment(NamedTuple):
    """What is known at a time, to go on from or to go back to.

    Parameters
    ----------
    t : float [s]
        When.
    normal : Normal
        The state.
    positions : array (actuators,)
        Indicated positions.
    readings : dict of str to tuple of float
        What was measured then.
    monitor : DriftMonitor
        After them.
    """

    t: float
    normal: Normal
    positions: np.ndarray
    readings: dict[str, tuple[float, ...]]
    monitor: DriftMonitor
