"""Manoeuvres that take a ship off a bank, and the helmsman's own steering, as one law of the kernel."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from narrows.quantities.arithmetic import choice, clip
from narrows.results import BaseSummary
from narrows.simulation.controllers import EARLY, Named
from narrows.warning.settings import (
    ENGINE_KICK,
    ESCAPE_ANGLE,
    ESCAPE_HEADING_GAIN,
    ESCAPE_TURN_GAIN,
    REACH_LENGTHS,
)

REVOLUTIONS = "revolutions"


class Manoeuvre(NamedTuple):
    words: str  # Order after the first one
    kick: float = 1.0  # Revolutions over those of now [1]


# The best of 37 manoeuvres (angles back to the line, gains, counter rudder alone) in each case saves less than half a
# percent of the contacts more than the first one here: decisions/warning_scores.py.
STEADY = Manoeuvre("then steady parallel to the bank")
KICK = Manoeuvre("kick ahead, then steady parallel to the bank", ENGINE_KICK)


@dataclass(frozen=True, repr=False)
class LineOfSight(BaseSummary):
    """Line-of-sight guidance with a proportional-derivative autopilot, after a time for which the rudder is held.

    References
    ----------
    Fossen (2011), Handbook of Marine Craft Hydrodynamics and Motion Control, for guidance by line of sight.
    """

    driven: bool = False  # True where it also orders revolutions

    def parameters(self) -> Mapping[str, Any]:
        """Return its numbers as they are before they are loaded: all of them differ from lane to lane."""
        names = ("since", "ordered", "line", "reach", "approach", "by_psi", "by_r", "trim", "most")
        return dict.fromkeys(names, 1.0) | (dict.fromkeys(("turns", "kicked"), 0.0) if self.driven else {})

    def memory(self, start: Named) -> Named:
        """Return nothing: it looks at the present alone."""
        return {}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the rudder that is held before a time, and that of the law from then on."""
        pace = at.u + at.current
        off = at.psi - clip((at.line - at.y) * at.reach, at.approach)
        turn = at.r - at.water("curvature", at.x) * pace
        law = clip(at.trim - at.by_psi * off - at.by_r * turn, at.most)
        on = at.t - at.since + EARLY * at.dt
        orders: dict[str, Any] = {"rudder": choice(on, law, at.ordered)}
        if self.driven:
            orders[REVOLUTIONS] = choice(on, at.kicked, at.turns)
        return orders, {}


def escape_numbers(line: float, length: float, limit: float) -> dict[str, float]:
    """Return the law's numbers of an escape: hard over, and checked in time; ``by_r`` is divided by the speed [m/s]."""
    return {
        "line": line, "reach": 1.0 / (REACH_LENGTHS * length), "approach": ESCAPE_ANGLE, "trim": 0.0, "most": limit,
        "by_psi": ESCAPE_HEADING_GAIN, "by_r": ESCAPE_TURN_GAIN * length,
    }  # fmt: skip
