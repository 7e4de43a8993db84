"""The ten steady bank tests of Lataire, Vantorre and Eloot (2009): one row a test, each at its own draft and depth.

The banks are sloped and stepped, at starboard of a tank 7 m wide; the table names the bank and no more, so the
canal's width stays the tank's.
"""

import numpy as np
import pandas as pd

from narrows.captive import check

RENAMED = {
    "short name test": "test", "draught": "draft [m]", "water depth": "depth [m]",
    "forward component of speed vector": "u [m/s]", "transversal component of speed vector": "v [m/s]",
    "lateral position": "y [m]", "psi": "psi [deg]",
    "longitudinal force": "X [N]", "transversal force": "Y [N]", "yaw moment": "N [Nm]",
    "bank name": "bank",
}  # fmt: skip


def recognises(frame: pd.DataFrame) -> bool:
    """Say whether a frame has this layout (ours).

    Parameters
    ----------
    frame : DataFrame
        As read.
    """
    return {"lateral position", "psi", "sinkage fore", "sinkage aft", "bank name"} <= set(frame.columns)


def translated(frame: pd.DataFrame, chosen: str, place: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Bring the layout to the documented headers (ours).

    Parameters
    ----------
    frame : DataFrame
        As read.
    chosen : str
        The user's selection of rows, already applied.
    place : str
        The file.
    """
    ahead = frame[np.abs(check.numbers(frame, "psi", place)) < 90].rename(columns=RENAMED)
    fore, aft = (check.numbers(ahead, f"sinkage {end}", place) for end in ("fore", "aft"))
    ahead["heave [mm]"] = (fore + aft) / 2
    ahead[["r", "udot", "vdot", "rdot"]] = np.zeros((len(ahead), 4))
    ahead["condition"] = "banks"
    left = len(frame) - len(ahead)
    notes = ("the banks' slopes and platforms are not modelled: the canal is taken as the tank",)
    return ahead, (f"{left} of {len(frame)} tests left out: sailed backwards", *notes) if left else notes
