"""Squat in a canal
================

Bow sinkage of a container ship over speed; the spread of the formulas shows their uncertainty.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

configuration = nw.published("estimated_dtc").configuration
u = np.linspace(1.0, 5.0, 33)
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for name in ("icorels", "huuska", "tuck_bow"):
    sinkage = [nw.squat(configuration, u=float(one), gives="bow", formula=name).sinkage for one in u]
    axes.plot(u, sinkage, linewidth=3, label=name)
    print(f"{name}: {sinkage[-1]:.2f} m at 5 m/s")
axes.set(xlabel="speed [m/s]", ylabel="squat [m]", title="Squat of a 355 m ship, h = 24 m")
axes.invert_yaxis()
axes.legend()
