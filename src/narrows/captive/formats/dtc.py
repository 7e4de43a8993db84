"""Raw records of the DTC tests for MASHCON 2019: tab separated, two header lines, positions without rates.

The speed column of these files is a stepped encoder value, so velocities and accelerations come from the
low-passed positions; forces stay as measured.
"""

import numpy as np
import pandas as pd

from narrows.captive.smooth import rates
from narrows.errors import InputError
from narrows.readers import cells

# Of the low-pass [Hz]: ramps last seconds, the tank's carriage shakes above one hertz.
CUTOFF = 0.5


HEADERS = ("time [s]", "x0 [m]", "y0 [m]", "psi [°]", "heave [mm]", "X [N]", "Y [N]", "N [Nm]")


def recognises(frame: pd.DataFrame) -> bool:
    """Say whether a frame has this layout."""
    return set(HEADERS) <= set(frame.columns)


def translated(frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Bring the layout to the documented headers."""
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
    """Give a record as its files have them: 20 s of a steady speed along the tank."""
    t = np.arange(1, 401) / 20.0
    still = 0 * t
    columns = (t, 0.4 * t, still, still, 2.0 + still, -30.0 + still, still, still)
    return pd.DataFrame(dict(zip(HEADERS, columns, strict=True)))
