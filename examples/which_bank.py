"""Which bank does it meet?
========================

Ships without a helmsman start at every offset and speed; the colour is the distance to the grounding and its side.
"""

import numpy as np

import narrows as nw

model = nw.published("mikkelsen2025_dtc")
fleet = nw.ensemble(model, y=np.linspace(-2.5, 2.5, 41), u=np.linspace(0.6, 1.2, 7))
print(f"{int((fleet.side > 0).sum())} of {fleet.side.size} ships ground to starboard")
picture = fleet.plot()
