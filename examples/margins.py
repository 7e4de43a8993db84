"""Control: delay margin
=====================

Additional delay that the loop of ship, steering gear and regulator tolerates, by offset and speed.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("estimated_kcs")
u = np.linspace(3.0, 6.0, 7)
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for y in (0.0, 45.0):
    delays = []
    for speed in u:
        helm = nw.control.regulator(model, y=y, u=float(speed))
        loop = nw.control.closed_loop(model, helm, gear=nw.SteeringGear(dead_time=1.0, lag=2.0), dt=1.0)
        delays.append(loop.margins()["delay"])
    axes.plot(u, delays, linewidth=3, label=f"{y:.0f} m off the centreline")
    print(f"{y:.0f} m off: {min(delays):.1f} to {max(delays):.1f} s")
axes.set(xlabel="speed [m/s]", ylabel="delay margin [s]", title="Delay that the loop tolerates")
axes.legend()
