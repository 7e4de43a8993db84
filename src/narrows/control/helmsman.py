"""A human at the wheel, as a control law: what is seen becomes an order late, in whole degrees, up to a cap."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.errors import InputError
from narrows.quantities.arithmetic import choice, clip
from narrows.results import Described
from narrows.simulation.controllers import EARLY, Named

# From a look to the next, and from an order to its being heard [s].
DELAY = 3.0
# The most rudder that is ordered [deg].
CAP_DEG = 20.0
# Degrees, of which whole ones are made up.
BITS = (32, 16, 8, 4, 2, 1)
DEGREE = math.pi / 180


@dataclass(frozen=True, repr=False)
class Helmsman(Described):
    """A helm by hand: a look every few seconds, an order in whole degrees, heard at the next, up to a cap."""

    # The order is in proportion to what is off, about a trim that follows slowly where the ship stays off its line.

    y: Any  # Offset to hold [m]
    gains: tuple[Any, Any, Any]  # Rudder for offset, heading and yaw rate off [rad/m, 1, s]
    trim: Any = 0.0  # Rate of the trim for an offset [rad/(m s)]
    rudder: Any = 0.0  # That are thought to hold it there [rad, rad]
    psi: Any = 0.0  # That are thought to hold it there [rad, rad]
    delay: float = DELAY  # Between looks, and from an order to its being heard [s]
    cap_deg: float = CAP_DEG  # The most rudder that is ordered, to 63 [deg]

    def __post_init__(self) -> None:
        if len(self.gains) != 3:
            raise InputError(f"a helmsman has three gains, for y, psi and r; these are {len(self.gains)}")
        for number in (self.y, *self.gains, self.trim, self.rudder, self.psi):
            if not np.isfinite(number).all():
                raise InputError(f"a helmsman with {number} steers nothing; give finite numbers")
        if not 0 <= self.delay < math.inf or not 1 <= self.cap_deg <= 63:
            raise InputError(
                f"a delay of {self.delay} s and a cap of {self.cap_deg} degrees: give seconds from 0, and 1 to 63"
            )

    def summary(self) -> str:
        """Say what it holds, and how."""
        return f"y = {self.y}, a look every {self.delay:g} s, whole degrees to {self.cap_deg:g}"

    def parameters(self) -> Mapping[str, Any]:
        """Return what is held, the gains, the delay and the cap."""
        held = {"held_y": self.y, "held_psi": self.psi, "held_rudder": self.rudder, "by_trim": self.trim}
        gains = dict(zip(("by_y", "by_psi", "by_r"), self.gains, strict=True))
        return {**held, **gains, "delay": self.delay, "cap": self.cap_deg * DEGREE}

    def memory(self, start: Named) -> Named:
        """Return the trim, the time of the next look, the order that was given, and the one that is heard."""
        return {"trimmed": 0.0, "next_look": 0.0, "given": start["rudder"], "heard": start["rudder"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the order that is heard, and what is kept in mind."""
        off = at.y - at.held_y
        wanted = at.held_rudder + at.trimmed - (at.by_y * off + at.by_psi * (at.psi - at.held_psi) + at.by_r * at.r)
        looks = at.t + EARLY * at.dt - at.next_look
        heard = choice(looks, at.given, at.heard)
        memory = {
            "trimmed": at.trimmed - choice(at.cap - abs(wanted), at.dt * at.by_trim * off, 0.0),
            "next_look": choice(looks, at.t + at.delay, at.next_look),
            "given": choice(looks, whole_degrees(clip(wanted, at.cap)), at.given),
            "heard": heard,
        }
        return {"rudder": heard}, memory


def whole_degrees(angle: Any) -> Any:
    """Return an angle in whole degrees, in arithmetic; halves go outward [rad]."""
    # angle [rad]
    left, made = abs(angle) / DEGREE + 0.5, 0.0
    for bit in BITS:
        made = made + choice(left - made - bit + 1e-12, bit, 0.0)
    return choice(angle, made, -made) * DEGREE
