"""From tests to a chart of safe speeds
====================================

From the measured tests of a container ship to a chart for the pilot.
"""

import tempfile
from pathlib import Path

from matplotlib.figure import Figure

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.model.tables import table_named

# Identify it with the terms of a rudder, from tests with the rudder turned too.
terms = table_named("speed+helm")
turned = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
tests = nw.read_captive(*measured_files("kcs"), turned).by_condition()["C0101A02"]
fit = nw.identify(tests, terms)

# Its own size, in a canal; notes list what does not scale.
scaled = nw.scale_model(fit.model, length=230.0, density=1025.0, width=300.0, depth=16.2)
for note in scaled.notes:
    print("-", note)

# Where is it safe, with a gust and the uncertainty of the tests?
gust = nw.Disturbance(heading_deg=2.0, gust=nw.wind_force(speed=15.0, area=6000.0))
found = nw.safe_envelope(scaled.model, disturbance=gust, samples=100)
print(found.summary())

chart = Path(tempfile.mkdtemp()) / "chart.png"
found.save(chart)
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
speeds = found.data["u"].where(found.by_model())
slowest, fastest = speeds.min("u"), speeds.max("u")
axes.fill_between(found.data["y"], slowest, fastest, color="tab:green", alpha=0.5)
axes.set(xlabel="offset to starboard [m]", ylabel="speed [m/s]", title="Safe by the model, 95 %")
print(f"wrote {chart.name}")
