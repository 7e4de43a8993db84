"""A turning circle
================

A tanker turns with 35 degrees of rudder, to starboard and to port.
"""

import numpy as np
from matplotlib.figure import Figure

import narrows as nw

model = nw.published("yasukawa2015_kvlcc2_full")
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for degrees in (35.0, -35.0):
    held = nw.ConstantRudder(np.radians(degrees))
    voyage = nw.simulate(model, u=7.97, duration=900.0, dt=1.0, controller=held, surge="free", contact="none")
    length = model.configuration.ship.length
    axes.plot(voyage.y / length, voyage.x / length, linewidth=3, label=f"rudder {degrees:+.0f}°")
    print(f"rudder {degrees:+.0f}: advance {voyage.x.max() / length:.2f} ship lengths")
axes.set(xlabel="transfer / length [1]", ylabel="advance / length [1]", title="Turning circles", aspect="equal")
axes.legend(loc="lower center")
