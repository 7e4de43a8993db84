"""Bank force and yaw moment
=========================

Force towards the near bank and moment that turns the bow away, over the offset of a container ship.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("estimated_kcs")
y = np.linspace(-100.0, 100.0, 81)
force = [nw.bank_force(model, y=float(one), psi=0.0, u=4.0) for one in y]

picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
axes.plot(y, [one.Y / 1e3 for one in force], linewidth=3, label="force [kN]")
axes.plot(y, [one.N / 1e6 for one in force], linewidth=3, label="moment [MN m]")
axes.axhline(0.0, color="grey", linewidth=0.8)
axes.set(xlabel="offset to starboard [m]", title="Bank force and moment at 4 m/s")
axes.legend()
print(f"60 m off: {force[64].Y / 1e3:.0f} kN towards the bank, {force[64].N / 1e6:.1f} MN m that turn the bow away")
