"""Sensitivity of a voyage
=======================

Exact derivatives of the track with respect to the start and the coefficients, from one run.
"""

from matplotlib.figure import Figure

import narrows as nw

model = nw.published("mikkelsen2025_dtc")
found = nw.sensitivities(model, by=("b_bank", "c_bank", "b_v"), y=0.5, u=1.0, duration=8.0)
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for name in ("b_bank", "c_bank", "b_v"):
    change = found.of("y", name) * 0.1 * model[name]
    axes.plot(found.voyage.t, change, linewidth=3, label=f"{name} + 10 %")
    print(f"{name} + 10 %: {float(change[-1]):+.2f} m after 8 s")
axes.set(xlabel="time [s]", ylabel="change of the offset [m]", title="Sensitivity of a voyage")
axes.legend()
