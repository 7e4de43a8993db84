"""The ten steady bank tests of Lataire, Vantorre and Eloot (2009): one row per test, each with its draft and depth.

The banks are walls, slopes and platforms at starboard of a tank 7 m wide. Each is replaced by the wall with the same
section at the row's own depth: width and offset refer to the canal between that wall and the tank's own.
"""

from io import StringIO

import numpy as np
import pandas as pd

from narrows.errors import InputError
from narrows.readers import cells
from narrows.ship.particulars import equivalent_wall

RENAMED = {
    "short name test": "test", "draught": "draft [m]", "water depth": "depth [m]",
    "forward component of speed vector": "u [m/s]", "transversal component of speed vector": "v [m/s]",
    "lateral position": "y [m]", "psi": "psi [deg]",
    "longitudinal force": "X [N]", "transversal force": "Y [N]", "yaw moment": "N [Nm]",
    "bank name": "bank", "rudder angle": "rudder [deg]",
}  # fmt: skip
# Distance of the tank's wall from its centreline [m].
WALL = 3.5
# Distance from the tank's centreline and height above its bottom [m], from the data's table of banks: toe, slope (1/5,
# 1/5, 1/5, 1/8, 1/8, 1/3) and, of III, IV and VI, a platform from the top of the slope to the tank's wall.
BANKS = {
    "I": ((2.83, 0.0), (2.83, 0.5)),
    "II": ((0.53, 0.0), (3.03, 0.5)),
    "III": ((0.53, 0.0), (1.13, 0.12), (WALL, 0.12)),
    "IV": ((0.53, 0.0), (1.28, 0.15), (WALL, 0.15)),
    "V": ((0.53, 0.0), (WALL, 2.97 / 8)),
    "VI": ((0.53, 0.0), (1.73, 0.15), (WALL, 0.15)),
    "VII": ((2.23, 0.0), (WALL, 1.27 / 3)),
}


def recognises(frame: pd.DataFrame) -> bool:
    return {"lateral position", "psi", "sinkage fore", "sinkage aft", "bank name"} <= set(frame.columns)


def translated(frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    ahead = frame[np.abs(cells.numbers(frame, "psi", table)) < 90].rename(columns=RENAMED)
    fore, aft = (cells.numbers(ahead, f"sinkage {end}", table) for end in ("fore", "aft"))
    ahead["heave [mm]"] = (fore + aft) / 2
    ahead[["r", "udot", "vdot", "rdot"]] = np.zeros((len(ahead), 4))
    ahead["condition"] = "banks"
    for name in ahead["bank"]:
        if name not in BANKS:
            raise InputError(f"{table}: bank {name!r} is not one of {', '.join(BANKS)}; mend it")
    depths = cells.numbers(ahead, "depth [m]", table)
    walls = np.array([equivalent_wall(BANKS[b], h) for b, h in zip(ahead["bank"], depths, strict=True)])
    ahead["y [m]"] = cells.numbers(ahead, "y [m]", table) - (walls - WALL) / 2
    ahead["width [m]"] = walls + WALL
    left = len(frame) - len(ahead)
    notes = ("slopes and platforms are taken as the wall that leaves the same section; y is from between the walls",)
    return ahead, (f"{left} of {len(frame)} tests left out: sailed backwards", *notes) if left else notes


def sample() -> pd.DataFrame:
    return pd.read_csv(StringIO(SAMPLE))


# Rows of the published data: slopes with and without a platform.
SAMPLE = """\
short name test,draught,water depth,forward component of speed vector,transversal component of speed vector,\
lateral position,psi,longitudinal force,transversal force,yaw moment,sinkage fore,sinkage aft,bank name
A,0.18,0.36,0.6842,-0.0599,0.265,5.0,-4.13,5.139,8.939,5.068,3.672,V
B,0.18,0.198,0.3434,0.0,0.265,0.0,2.132,2.951,-4.99,2.196,3.304,IV
C,0.18,0.198,0.4578,0.0,0.265,0.0,-2.618,-0.962,-4.3,3.902,4.558,III
"""
