"""Raw records of the DTC tests for MASHCON 2019: tab separated, two header lines, positions without rates.

The speed column of these files is a stepped encoder value, so velocities and accelerations come from the
low-passed positions; forces stay as measured.
"""

import numpy as np
import pandas as pd

from narrows.captive.smooth import rates

CUTOFF = 0.5
"""Of the low-pass [Hz]: ramps last seconds, the tank's carriage shakes above one hertz (ours)."""


def recognises(frame: pd.DataFrame) -> bool:
    """Say whether a frame has this layout (ours).

    Parameters
    ----------
    frame : DataFrame
        As read.
    """
    return {"time [s]", "x0 [m]", "y0 [m]"} <= set(frame.columns)


def translated(frame: pd.DataFrame, chosen: str = "") -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Bring the layout to the documented headers (ours).

    Parameters
    ----------
    frame : DataFrame
        As read.
    chosen : str
        The user's selection of rows, already applied.
    """
    t = frame["time [s]"].to_numpy(dtype=float)
    psi = np.unwrap(np.radians(frame["psi [°]"].to_numpy(dtype=float)))
    north, ahead = rates(t, frame["x0 [m]"].to_numpy(dtype=float), CUTOFF)
    east, aside = rates(t, frame["y0 [m]"].to_numpy(dtype=float), CUTOFF)
    r, rdot = rates(t, psi, CUTOFF)
    c, s = np.cos(psi), np.sin(psi)
    u, v = north * c + east * s, east * c - north * s
    translation = {
        "t": t, "x": frame["x0 [m]"], "y": frame["y0 [m]"], "psi": psi, "u": u, "v": v, "r": r,
        "udot": ahead * c + aside * s + v * r, "vdot": aside * c - ahead * s - u * r, "rdot": rdot,
        "heave [mm]": frame["heave [mm]"], "X": frame["X [N]"], "Y": frame["Y [N]"], "N": frame["N [Nm]"],
    }  # fmt: skip
    note = f"velocities and accelerations from positions low-passed at {CUTOFF:g} Hz"
    return pd.DataFrame(translation, index=frame.index), (note,)
