"""Stability near a bank
=====================

Time in which a deviation doubles without steering, from the eigenvalues of the ship near a bank.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("estimated_kcs")
y = np.linspace(0.0, 40.0, 9)
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for u in (3.0, 4.0, 5.0):
    growth = [nw.control.linearize(model, y=float(one), u=u).eigenvalues()[0].real for one in y]
    axes.plot(y, np.log(2.0) / np.array(growth), linewidth=3, label=f"{u:g} m/s")
    print(f"{u:g} m/s: a deviation doubles in {np.log(2.0) / growth[0]:.0f} s on the centreline")
axes.set(xlabel="offset to starboard [m]", ylabel="doubling time [s]", title="Instability near a bank", ylim=(100, 270))
axes.legend(loc="upper center", ncols=3)
