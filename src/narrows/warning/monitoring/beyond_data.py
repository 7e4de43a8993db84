"""Whether a ship is where its model was tested."""

import math

from narrows.estimation.estimate import Estimate
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.warning.alerts.alert import Priority
from narrows.warning.alerts.alert_desk import CALM, Condition
from narrows.warning.hearing.bridge_readings import Heard
from narrows.waterway.waterway import Waterway

# Of the draft, by which the ship may lie deeper or less deep than its model; of the depth of the waterway, by which
# there may be more or less water than is charted.
DRAFT_OFF, DEPTH_OFF = 0.03, 0.1


def beyond_data(model: Model, waterway: Waterway, estimate: Estimate, heard: Heard) -> Condition:
    """Return a caution where the ship is outside of what its model's data covered."""
    ship, now = model.configuration.ship, estimate.values
    here = waterway.section(min(max(now["x"], 0.0), waterway.line.length))
    asked = {"speed": now["u"], "abs_y": abs(now["y"] - float(here.middle)), "abs_psi": abs(now["psi"])}
    asked |= {"width_to_beam": float(here.width) / ship.beam, "depth_to_draft": float(here.depth) / ship.draft}
    known = {name: value for name, value in asked.items() if math.isfinite(value)}
    said = list(extrapolation(model.data_range, known))
    if heard.draft is not None and abs(heard.draft - ship.draft) > DRAFT_OFF * ship.draft:
        said.append(f"The ship reports a draft of {heard.draft:g} m; its model is of {ship.draft:g} m.")
    if heard.depth is not None and abs(heard.depth - float(here.depth)) > DEPTH_OFF * float(here.depth):
        charted = f"{waterway.name} has {float(here.depth):.1f} m here"
        said.append(f"The echo sounder tells {heard.depth:.1f} m of water; {charted}.")
    return Condition(Priority.CAUTION, " ".join(said)) if said else CALM
