"""Waterways: around a bend
========================

A ship is steered along the line of a canal that turns by 45 degrees; the track on a map.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw
from narrows.waterway import Bank, Centreline

angle = np.linspace(0.0, np.pi / 4, 40)
arc = np.stack([1000.0 + 2500.0 * np.sin(angle), 2500.0 * (1.0 - np.cos(angle))], axis=1)
points = np.concatenate([[[0.0, 0.0]], arc, arc[-1:] + 1500.0 * np.array([[np.cos(angle[-1]), np.sin(angle[-1])]])])
line = Centreline(points)
ends = np.array([0.0, line.length])
banks = [Bank(side, ends, np.full(2, 150.0)) for side in ("starboard", "port")]
canal = nw.Waterway(line, *banks, depths=(ends, np.full(2, 16.2)))

model = nw.published("estimated_kcs")
helm = nw.control.regulator(model, y=0.0, u=4.0, waterway=canal)
voyage = nw.simulate(model, x=200.0, y=30.0, u=4.0, duration=900.0, dt=1.0, controller=helm, waterway=canal)
print(voyage.outcome.sentence)

picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
s = np.linspace(0.0, line.length, 200)
for y in (-150.0, 150.0):
    axes.plot(*canal.to_map(s, np.full(200, y), np.zeros(200))[0].T, color="saddlebrown", linewidth=3)
axes.plot(*canal.to_map(voyage.x, voyage.y, voyage.psi)[0].T, linewidth=3)
axes.set(xlabel="east [m]", ylabel="north [m]", title="A bend of 2500 m", aspect="equal")
