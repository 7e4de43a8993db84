"""Control: steady rudder angle
============================

The rudder angle that holds a ship at an offset, with samples of the uncertain coefficients.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("estimated_kcs")
y = np.linspace(0.0, 40.0, 9)
draws = np.random.default_rng(1).multivariate_normal(np.zeros(len(model.terms.names)), model.covariance, 12)


def rudder(ship):
    return [np.degrees(nw.steady_course(ship, y=float(one), u=4.0)["rudder"]) for one in y]


picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for draw in draws:
    ship = model.with_coefficients(**{
        name: model[name] + change for name, change in zip(model.terms.names, draw, strict=True)
    })  # fmt: skip
    axes.plot(y, rudder(ship), color="silver", linewidth=1)
best = rudder(model)
axes.plot(y, best, linewidth=3)
axes.set(xlabel="offset to starboard [m]", ylabel="rudder [°]", title="Rudder of the steady course", ylim=(-35, 35))
print(f"{best[-1]:.1f} degrees at 40 m")
