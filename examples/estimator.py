"""Estimation: position from noisy sensors
=======================================

A Kalman filter with the ship's model estimates the offset and its uncertainty from fixes with 3 m of noise.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw
from narrows.estimation import Estimator, Gnss, Gyro, Log, RudderIndicator

model = nw.published("estimated_kcs")
voyage = nw.simulate(
    model, y=35.0, u=4.0, duration=240.0, dt=1.0, controller=nw.control.regulator(model, y=20.0, u=4.0)
)
noise = np.random.default_rng(1).standard_normal((2, voyage.t.size))
record = {
    "t": voyage.t, "gnss_x": voyage.x + 3.0 * noise[0], "gnss_y": voyage.y + 3.0 * noise[1],
    "gyro": voyage.psi, "log": voyage.u, "rudder": voyage.rudder,
}  # fmt: skip
sensors = [Gnss(noise=3.0, coloured=None), Gyro(), Log(), RudderIndicator()]
track = Estimator(model, sensors).smooth(record)
print(track.summary())

picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
found = track.dataset()["y"]
axes.plot(voyage.t, record["gnss_y"], ".", color="silver", label="fixes")
axes.plot(found["t"], found, linewidth=3, label="estimate")
axes.plot(voyage.t, voyage.y, "k--", linewidth=1.5, label="truth")
axes.set(xlabel="time [s]", ylabel="offset to starboard [m]", title="Estimate from noisy fixes")
axes.legend()
