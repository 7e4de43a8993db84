"""Where the ship grounds
======================

Starts at 2.3 and 2.4 m end at different banks; the probability of grounding by starting offset.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("mikkelsen2025_dtc")
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for y in (2.30, 2.40):
    voyage = nw.simulate(model, y=y)
    print(f"y(0) = {y:.2f} m: {voyage.outcome.sentence}")
    axes.plot(voyage.x, voyage.y, linewidth=3, label=f"from {y:.1f} m")
axes.set(xlabel="along the canal [m]", ylabel="offset to starboard [m]", title="Two starts, two banks")
axes.legend()

fit = nw.identify(nw.twin(model, seed=1))
fleet = nw.ensemble(fit.model, y=np.linspace(0.2, 2.4, 12), samples=100, seed=2)
for y, chance in zip(fleet.y.values, nw.grounding_probability(fleet, 10.0).values, strict=True):
    print(f"y(0) = {y:.1f} m: grounds within 10 m in {chance:4.0%} of samples")
