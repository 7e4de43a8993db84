"""A plan of steady legs: which offsets and speeds to hold, what to expect there, and what they will tell."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.logbook.learned_coefficient import ON_TWINS
from narrows.logbook.settings import SETTLING
from narrows.logbook.steady_legs.steady_readings import ReadingErrors, SteadyConditions
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.results import BaseResult

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class PlannedLeg:
    """A leg to hold.

    Parameters
    ----------
    offset : float [m]
        Offset to starboard of the middle.
    speed : float [m/s]
        Through the water.
    rudder : tuple of float [rad]
        Rudder that holds it: 5 %, 50 % and 95 % quantiles, given the uncertainty of the tests.
    drift : tuple of float [rad]
        Likewise; the bow to starboard of the course is positive.
    """

    offset: float
    speed: float
    rudder: tuple[float, float, float]
    drift: tuple[float, float, float]

    @property
    def side(self) -> str:
        """``starboard``, ``port`` or ``middle``."""
        return "starboard" if self.offset > 0 else "port" if self.offset < 0 else "middle"


@dataclass(frozen=True, repr=False)
class SteadyPlan(BaseResult):
    """Legs to hold, in the order to hold them.

    Parameters
    ----------
    legs : tuple of PlannedLeg
        Nearest the middle first; none where none is allowed.
    targets : tuple of str
        The coefficients that they are chosen for.
    std : mapping of str to array (legs + 1,)
        Standard error of each of them before the first leg and after each, in the coefficient's unit.
    model : Model
        The ship.
    errors : ReadingErrors
        Errors of the readings.
    conditions : SteadyConditions
        Wind, zeros and what is left of motion.
    reserve : float [1]
        Rudder that every leg leaves.
    clearance : float [m]
        Clearance from the hull's side to a bank that every leg leaves.
    considered : int
        Number of candidate pairs of legs.
    farthest : tuple of float [m]
        Largest allowed offset of legs now, and probably after these.
    notes : tuple of str
        Rejected legs and why, and assumptions.
    """

    legs: tuple[PlannedLeg, ...]
    targets: tuple[str, ...]
    std: Mapping[str, np.ndarray]
    model: Model
    errors: ReadingErrors
    conditions: SteadyConditions
    reserve: float
    clearance: float
    considered: int
    farthest: tuple[float, float]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<SteadyPlan of {len(self.legs)} legs for {', '.join(self.targets)}>"

    @property
    def most_rudder(self) -> float:
        """Rudder [rad] at which a leg is to be broken off: what leaves the reserve."""
        return (1 - self.reserve) * self.model.configuration.gear.limit

    @property
    def settling(self) -> float:
        """Settling time on the slowest leg before it is read [s]."""
        return SETTLING * self.model.configuration.ship.length / min((leg.speed for leg in self.legs), default=np.inf)

    def summary(self) -> str:
        """Expected information of the legs, and their largest allowed offset."""
        now, then = self.farthest
        if not self.legs:
            return "No leg off the middle is allowed: what the tests leave open of the rudder is more than its reserve."
        gains = (f"{name}: standard error {self.std[name][0]:.2g} now, {self.std[name][-1]:.2g} after"
                 for name in self.targets)  # fmt: skip
        reach = f"Legs are allowed to {now:.3g} m off the middle now" + (
            f", and probably to {then:.3g} m after these." if then > now else "."
        )
        return "\n".join(
            (f"{len(self.legs)} legs of {self.conditions.leg_time:g} s: {'; '.join(gains)}.", reach, ON_TWINS)
        )

    def rows(self) -> list[dict[str, Any]]:
        """Give a row a leg, in metres, knots and degrees, with the standard errors once it is read."""
        names = ("low", "median", "high")
        return [
            {"offset": leg.offset, "side": leg.side, "speed": leg.speed / KNOT}
            | {f"rudder_{name}": float(np.degrees(angle)) for name, angle in zip(names, leg.rudder, strict=True)}
            | {f"drift_{name}": float(np.degrees(angle)) for name, angle in zip(names, leg.drift, strict=True)}
            | {f"std {name}": float(self.std[name][i + 1]) for name in self.targets}
            for i, leg in enumerate(self.legs)
        ]

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the legs as a table."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name."""
        return {
            "summary": self.summary(),
            "legs": self.rows(),
            "targets": {
                name: {"std": float(std[0]), "std_after": float(std[-1])} for name, std in self.std.items()
            },
            "break_off_rudder": float(np.degrees(self.most_rudder)),
            "clearance": self.clearance,
            "considered": self.considered,
            "farthest": list(self.farthest),
            "notes": list(self.notes),
        }  # fmt: skip
