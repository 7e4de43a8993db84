"""Check a test programme with a twin
==================================

Simulated tests of a ship with known coefficients show whether such tests would find them.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

truth = nw.published("mikkelsen2025_dtc")
fit = nw.identify(nw.twin(truth, seed=1))
for name, verdict in fit.verdicts.items():
    low, high = fit.intervals[name]
    print(f"{name:7s} true {truth.coefficients[name]:8.2f}   95 % {low:9.2f} to {high:9.2f}   {verdict.status}")

picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
axes.axhline(0.0, color="black", label="truth")
for place, (name, (low, high)) in enumerate(fit.intervals.items()):
    ends = (np.array([low, high]) - truth.coefficients[name]) / fit.std[name]
    axes.plot([place, place], ends, color="tab:blue", linewidth=4)
axes.set(xlabel="coefficient, in order", ylabel="error / std [1]", title="95 % intervals of a twin", ylim=(-6, 6))
axes.legend()
