"""From tests to a chart
=====================

From the measured tests of a container ship to the chart that its pilot would pin up.
"""

import tempfile
from pathlib import Path

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.terms.tables import table_named

# Identify it with the terms of a rudder, from tests with the rudder turned too.
terms = table_named("speed+helm")
turned = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
tests = nw.read_captive(*measured_files("kcs"), turned).by_condition()["C0101A02"]
fit = nw.identify(tests, terms)

# Its own size, in a canal; what does not scale is said.
scaled = nw.scale_model(fit.model, length=230.0, density=1025.0, width=300.0, depth=16.2)
for note in scaled.notes:
    print("-", note)

# Where is it safe, with a gust and what the tests leave uncertain?
gust = nw.Disturbance(heading_deg=2.0, gust=nw.wind_force(speed=15.0, area=6000.0))
found = nw.safe_envelope(scaled.model, disturbance=gust, samples=100)
print(found.summary())
for note in found.notes:
    print("-", note)

chart = Path(tempfile.mkdtemp()) / "chart.png"
found.save(chart)
picture = found.plot()
print(f"wrote {chart.name}")

# The same track pilot, for one voyage from 40 m off to 30.
pilot = nw.track_pilot(scaled.model, y=30.0, u=4.0)
voyage = nw.simulate(scaled.model, y=40.0, u=4.0, duration=900.0, dt=1.0, controller=pilot)
print(f"{voyage.outcome.sentence} It is {voyage.y[-1]:.1f} m off the middle.")
