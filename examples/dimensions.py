"""A ship from its main dimensions
===============================

Length, beam, draft and block coefficient give a model, with an uncertainty calibrated on known ships.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

ship = nw.Ship(length=366.0, beam=51.0, draft=15.0, block_coefficient=0.65)
model = nw.estimate_model(ship, nw.Canal(width=300.0, depth=20.0))
draws = np.random.default_rng(1).multivariate_normal(np.zeros(len(model.terms.names)), model.covariance, 60)
y = np.linspace(-80.0, 80.0, 33)


def moment(one):
    return [nw.bank_force(one, y=float(place), psi=0.0, u=4.0).N / 1e6 for place in y]


names = model.terms.names
ships = [
    model.with_coefficients(**{name: model[name] + by for name, by in zip(names, draw, strict=True)}) for draw in draws
]
low, high = np.quantile([moment(one) for one in ships], (0.025, 0.975), axis=0)
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
axes.fill_between(y, low, high, alpha=0.3, label="95 %")
axes.plot(y, moment(model), linewidth=3, label="estimate")
axes.set(xlabel="offset to starboard [m]", ylabel="bow to starboard [MN m]", title="Bank moment of a 366 m ship")
axes.legend()
print(f"60 m off at 4 m/s: {low[28]:.0f} to {high[28]:.0f} MN m")
