"""Raw records of the DTC tests for MASHCON 2019: tab separated, two header lines, positions without rates.

The speed column of these files is a stepped encoder value, so velocities and accelerations come from the low-passed
positions; forces are unfiltered.
"""

import numpy as np
import pandas as pd

from narrows.captive.settings import SHORTEST_RECORD
from narrows.errors import InputError
from narrows.readers import cells

# Cutoff frequency of the low-pass [Hz]: ramps last seconds, the tank's carriage vibrates above one hertz.
CUTOFF = 0.5

HEADERS = ("time [s]", "x0 [m]", "y0 [m]", "psi [°]", "heave [mm]", "X [N]", "Y [N]", "N [Nm]")


def recognises(frame: pd.DataFrame) -> bool:
    return set(HEADERS) <= set(frame.columns)


def translated(frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    t, x, y, degrees = (cells.numbers(frame, header, table) for header in HEADERS[:4])
    psi = np.unwrap(np.radians(degrees))
    try:
        (north, ahead), (east, aside), (r, rdot) = (rates(t, position, CUTOFF) for position in (x, y, psi))
    except InputError as error:
        raise InputError(f"{table}: {error}") from None
    c, s = np.cos(psi), np.sin(psi)
    u, v = north * c + east * s, east * c - north * s
    translation = {
        "t": t, "x": x, "y": y, "psi": psi, "u": u, "v": v, "r": r,
        "udot": ahead * c + aside * s + v * r, "vdot": aside * c - ahead * s - u * r, "rdot": rdot,
        "heave [mm]": frame["heave [mm]"], "X": frame["X [N]"], "Y": frame["Y [N]"], "N": frame["N [Nm]"],
    }  # fmt: skip
    note = f"velocities and accelerations from positions low-passed at {CUTOFF:g} Hz"
    return pd.DataFrame(translation, index=frame.index), (note,)


def sample() -> pd.DataFrame:
    """Return a record in its file format: 20 s of a steady speed along the tank."""
    t = np.arange(1, 401) / 20.0
    still = 0 * t
    columns = (t, 0.4 * t, still, still, 2.0 + still, -30.0 + still, still, still)
    return pd.DataFrame(dict(zip(HEADERS, columns, strict=True)))


def rates(t: np.ndarray, position: np.ndarray, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity and acceleration of a position, low-passed by a Butterworth filter that runs forward and back."""
    # t (rows,) [s]; position (rows,) [m]; cutoff [Hz]
    from scipy.signal import butter, sosfiltfilt

    if len(t) < SHORTEST_RECORD:
        raise InputError(f"{len(t)} rows are too few to low-pass; give a record of {SHORTEST_RECORD} or more")
    step = np.diff(t)
    if step.min() <= 0 or np.ptp(step) > 0.01 * step.mean():
        raise InputError(f"time steps vary from {step.min():g} to {step.max():g} s; resample the record evenly")
    rate = 1 / step.mean()
    if cutoff >= rate / 2:
        raise InputError(f"a cutoff of {cutoff:g} Hz is not below half the sampling rate {rate:g} Hz; lower it")
    # The filter's transient lasts some periods of its cutoff; SciPy's own padding is shorter and spoils a moving end.
    padding = min(len(position) - 1, round(3 * rate / cutoff))
    velocity = np.gradient(sosfiltfilt(butter(4, cutoff, fs=rate, output="sos"), position, padlen=padding), t)
    return velocity, np.gradient(velocity, t)
