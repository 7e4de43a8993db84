"""Export: a model as one Python file
==================================

The exported file needs no package; its voyage equals that of ``narrows``.
"""

import runpy
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("mikkelsen2025_dtc")
path = Path(tempfile.mkdtemp()) / "dtc.py"
model.export(path)
ship = runpy.run_path(str(path))
constants, state = ship["prepare"](ship["MODEL"]), [0.0, 0.5, 1.0, 0.0, 1.0, 0.0, 0.0]
track = []
for _ in range(110):
    track.append(state[:2])
    after = [0.0] * (len(state) + 2)
    ship["step"](state, after, 0.1, ship["AT_REST"], constants)
    state = after[: len(state)]

voyage = nw.simulate(model, y=0.5, u=1.0, dt=0.1)
x, y = np.transpose(track)
print(f"largest difference {np.abs(y - np.interp(x, voyage.x, voyage.y)).max():.1e} m")
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
axes.plot(voyage.x, voyage.y, linewidth=5, color="lightgrey", label="narrows")
axes.plot(x, y, "--", linewidth=2, label="exported file")
axes.set(xlabel="along the canal [m]", ylabel="offset to starboard [m]", title="Exported to Python")
axes.legend()
