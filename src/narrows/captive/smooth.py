"""Raw records to velocities and accelerations, by differentiating low-passed positions."""

import numpy as np

from narrows.captive.settings import SHORTEST_RECORD
from narrows.errors import InputError


def low_passed(t: np.ndarray, column: np.ndarray, cutoff: float) -> np.ndarray:
    """Low-pass a record without delay: a Butterworth filter of fourth order, run forth and back."""
    # t (rows,) [s]; column (rows,); cutoff [Hz]
    from scipy.signal import butter, sosfiltfilt

    if len(t) < SHORTEST_RECORD:
        raise InputError(f"{len(t)} rows are too few to low-pass; give a record of {SHORTEST_RECORD} or more")
    step = np.diff(t)
    if step.min() <= 0 or np.ptp(step) > 0.01 * step.mean():
        raise InputError(f"time steps vary from {step.min():g} to {step.max():g} s; resample the record evenly")
    rate = 1 / step.mean()
    if cutoff >= rate / 2:
        raise InputError(f"a cutoff of {cutoff:g} Hz is not below half the sampling rate {rate:g} Hz; lower it")
    # The filter rings for some periods of its cutoff; SciPy's own padding is shorter and spoils a moving end.
    padding = min(len(column) - 1, round(3 * rate / cutoff))
    return np.asarray(sosfiltfilt(butter(4, cutoff, fs=rate, output="sos"), column, padlen=padding))


def rates(t: np.ndarray, position: np.ndarray, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity and acceleration of a position, low-passed first."""
    # t (rows,) [s]; position (rows,) [m]; cutoff [Hz]
    velocity = np.gradient(low_passed(t, position, cutoff), t)
    return velocity, np.gradient(velocity, t)
