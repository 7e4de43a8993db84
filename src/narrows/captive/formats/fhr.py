"""Flanders Hydraulics Research's tests for SIMMAN: planar motion mechanism, averaged by phase, several depths.

Their layout: ``env, test, type, x_m, y_m, psi_deg, ...``, one row per phase of a harmonic run or per steady run,
``env`` the environment (a water depth), ``rud_given_deg`` the rudder angle. Sinkage stands for heave.
"""

import re
from io import StringIO

import numpy as np
import pandas as pd

from narrows.readers import cells

# Harmonic sway and harmonic yaw: the tests covered by the paper's terms.
HARMONIC = ("PMMY2", "PMMPSI2")

RENAMED = {
    "env": "condition",
    "sinkage_mm": "heave [mm]",
    "rud_given_deg": "rudder [deg]",
    "n_meas_rpm": "revolutions [rpm]",
}
TURNED = (
    "rudder is rud_given_deg with its sign turned, as it counts the other way there: positive turns the bow to port"
)


def recognises(frame: pd.DataFrame) -> bool:
    return {"env", "type", "psi_deg", "rud_given_deg"} <= set(frame.columns)


def translated(frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    # Unless the user's selection names the type of test or the rudder, harmonic tests with the rudder amidships are
    # kept: the paper's terms cover neither a rudder nor a drift of 90 degrees.
    turned = -cells.numbers(frame, "rud_given_deg", table)
    frame = frame.assign(rud_given_deg=turned).rename(columns=RENAMED)
    if re.search(r"\b(?:type|rud_given_deg|rudder\w*)\b", chosen):
        return frame, (TURNED,)
    kept = frame[frame["type"].isin(HARMONIC) & (np.abs(frame["rudder [deg]"]) < 1)]
    return kept, (f"{len(kept)} of {len(frame)} rows read: harmonic sway and yaw with the rudder amidships",)


def sample() -> pd.DataFrame:
    return pd.read_csv(StringIO(SAMPLE))


# Rows of the KCS tests: a steady run, harmonic sway and harmonic yaw.
SAMPLE = """\
ship,env,test,type,x_m,y_m,psi_deg,u_mps,v_mps,r_degps,udot_mps2,vdot_mps2,rdot_degps2,X_N,Y_N,N_Nm,sinkage_mm,rud_given_deg
KCS,C0101A01,C0101A01_C20100,STATX0,41.8736,0.0001,0.0,0.248,0.0,0.0,0,0.0,0.0,-0.5675,0.2894,-0.571,0.1672,10.0
KCS,C0101A01,C0101A01_F60000,PMMY2,0.0062,0.2,0.0,0.62,0.0,0.0,0,-0.0031,0.0,0.0201,2.7625,-1.88,3.0767,0.0
KCS,C0101A01,C0101A01_G20000,PMMPSI2,0.0024,-0.0006,-15.0,0.248,0.0,0.0035,0,0.0,0.3491,-0.5042,-0.1645,-5.7464,0.3652,0.0
"""
