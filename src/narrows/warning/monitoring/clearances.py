"""Water beside the hull."""

import math
from typing import NamedTuple

from narrows.estimation.estimate import Estimate
from narrows.ship.particulars import Ship
from narrows.ship.swept_width import half_swept
from narrows.waterway.waterway import Waterway


class Clearances(NamedTuple):
    """Of the corners of the hull to the banks, infinite where they are not known."""

    port: float = math.inf  # To which [m]
    starboard: float = math.inf  # To which [m]


def clearances(ship: Ship, waterway: Waterway, estimate: Estimate) -> Clearances:
    """Return the water beside a hull, the banks as they are beside midship."""
    if not estimate.ready:
        return Clearances()
    now = estimate.values
    here = waterway.room(min(max(now["x"], 0.0), waterway.line.length), ship.draft)
    off, room = now["y"] - float(here.middle), float(here.width) / 2 - float(half_swept(ship, now["psi"]))
    return Clearances(room + off, room - off)
