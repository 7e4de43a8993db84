"""A zigzag test
=============

Rudder and heading of a tanker in a 20/20 zigzag test, with the overshoot angles that IMO limits.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("yasukawa2015_kvlcc2_full")
law = nw.Zigzag(rudder=np.radians(20.0), heading=np.radians(20.0))
voyage = nw.simulate(model, u=7.97, duration=900.0, dt=1.0, controller=law, surge="free", contact="none")
print("overshoots [deg]:", np.degrees(nw.overshoots(voyage, law)).round(1))

picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
axes.plot(voyage.t, np.degrees(voyage.psi), linewidth=3, label="heading")
axes.plot(voyage.t, np.degrees(voyage.rudder), linewidth=2, label="rudder")
axes.set(xlabel="time [s]", ylabel="angle [°]", title="Zigzag 20/20", ylim=(-40, 50))
axes.legend(loc="upper center", ncols=2)
