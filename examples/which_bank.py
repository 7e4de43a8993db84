"""Which bank does the ship touch?
===============================

Ships without steering start at every offset and speed; the picture has the distance to the grounding and its side.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("mikkelsen2025_dtc")
fleet = nw.ensemble(model, y=np.linspace(-2.5, 2.5, 41), u=np.linspace(0.6, 1.2, 7))
print(f"{int((fleet.side > 0).sum())} of {fleet.side.size} ships ground to starboard")
picture = Figure((4.2, 3.0), layout="constrained")
axes, chosen = picture.subplots(), fleet.sel(u=0.9, method="nearest")
for side, colour, name in ((-1, "tab:blue", "to port"), (1, "tab:orange", "to starboard")):
    distance = chosen.distance.where(chosen.side == side)
    axes.plot(fleet.y, distance, "o", color=colour, label=name)
axes.set(xlabel="start, to starboard [m]", ylabel="distance to grounding [m]", title="At 0.9 m/s")
axes.legend()
