"""Control: hold a line near a bank
================================

A linear-quadratic regulator holds the ship 20 m off the centreline; without steering the ship grounds.
"""

from matplotlib.figure import Figure

import narrows as nw

model = nw.published("estimated_kcs")
helm = nw.control.regulator(model, y=20.0, u=4.0)
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for name, controller in (("regulator", helm), ("rudder amidships", nw.ConstantRudder(0.0))):
    voyage = nw.simulate(model, y=35.0, u=4.0, duration=600.0, dt=1.0, controller=controller)
    axes.plot(voyage.t, voyage.y, linewidth=3, label=name)
    print(f"{name}: {voyage.outcome.sentence}")
axes.axhline(20.0, color="grey", linestyle="--", linewidth=1)
axes.set(xlabel="time [s]", ylabel="offset to starboard [m]", title="Holding a line at 4 m/s")
axes.legend(loc="upper left")
