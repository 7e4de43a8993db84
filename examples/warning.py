"""Warning: forecast over four minutes
===================================

Share of the samples of an uncertain ship that touch a bank if nobody moves the rudder.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("estimated_kcs")
draws = np.random.default_rng(1).multivariate_normal(np.zeros(len(model.terms.names)), model.covariance, 32)
course = nw.steady_course(model, y=20.0, u=4.5)
now = {"y": 20.0, "psi": course["psi"], "u": 4.5, "duration": 240.0, "dt": 1.0, "rudder": course["rudder"]}

picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
met = 0
for draw in draws:
    changed = {name: model[name] + change for name, change in zip(model.terms.names, draw, strict=True)}
    voyage = nw.simulate(model.with_coefficients(**changed), **now)
    met += voyage.grounded
    axes.plot(voyage.x, voyage.y, color="crimson" if voyage.grounded else "steelblue", linewidth=1.5)
for bank in (-160.0, 150.0):
    axes.axhspan(bank, bank + 10.0, color="tan")
axes.set(xlabel="along the canal [m]", ylabel="offset to starboard [m]", title="The next four minutes")
print(f"chance of contact {met / len(draws):.0%}")
