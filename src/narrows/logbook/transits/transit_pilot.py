"""A pilot who follows an aim that moves, for planned transits: the regulator's gains about the steady course there."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from narrows.control.regulator import regulator
from narrows.control.regulator_law import HeldLine
from narrows.control.steady_course import steady_course
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.controllers import Order, VoyageState

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# Offsets at which steady courses are known, straight between them.
COURSES = 21


@dataclass(frozen=True)
class TransitPilot:
    """A pilot of one voyage."""

    line: HeldLine  # Gains, made for the farthest aim
    lead: float  # How far ahead bends are looked at [s]
    courses: np.ndarray  # (offsets, 4) y [m], rudder, psi [rad], v [m/s] of steady courses
    limit: float  # Of the rudder [rad]
    times: np.ndarray  # (n,) Where it wants to be, straight between [s]
    aims: np.ndarray  # (n,) Where it wants to be, straight between [s]
    waterway: "Waterway | None" = None  # Whose bends it follows

    @classmethod
    def of(
        cls, model: Model, u: float, times: np.ndarray, aims: np.ndarray, waterway: "Waterway | None" = None
    ) -> "TransitPilot":
        """Return the pilot of a ship at a speed."""
        # u [m/s]; times, aims (n,) [s]
        far = max(float(np.abs(aims).max()), 1e-6)
        y = np.linspace(-far, far, COURSES)
        held = steady_course(model, y=xr.DataArray(y, dims="place"), u=u)
        courses = np.stack([y, *(held[name].to_numpy() for name in ("rudder", "psi", "v"))], axis=1)
        if not np.isfinite(courses).all():
            raise InputError(f"no rudder holds this ship {far:.3g} m off the middle at {u:.3g} m/s; aim nearer to it")
        law = regulator(model, far, u)  # Where it is hardest.
        return cls(law.lines[0], float(law.lead), courses, model.configuration.gear.limit, times, aims, waterway)

    def begin(self) -> Order:
        """Return what gives the orders of one voyage: the rudder a step on, by its rate."""
        by_y, by_psi, by_v, by_r, by_rudder, by_integral = (float(gain) for gain in self.line.gains)
        memory = {"t": 0.0, "off": 0.0}

        def order(t: float, at: VoyageState) -> float:
            aim, rudder, psi, v, turn = self._held(t, at)
            step, memory["t"] = t - memory["t"], t
            wanted = by_y * (at.y - aim) + by_psi * (at.psi - psi) + by_v * (at.v - v) + by_r * (at.r - turn)
            wanted += by_rudder * (at.rudder - rudder) + by_integral * memory["off"]
            asked = float(at.rudder - step * wanted / (1 + step * by_rudder))
            # At the end of the rudder the integral waits.
            memory["off"] += step * (at.y - aim) * (abs(asked) < self.limit)
            return asked

        return order

    def _held(self, t: float, at: VoyageState) -> tuple[Any, ...]:
        """Aim, rudder, heading and sway velocity there, and the yaw rate of the bend ahead."""
        aim = float(np.interp(t, self.times, self.aims))
        rudder, psi, v = (float(np.interp(aim, self.courses[:, 0], self.courses[:, i])) for i in (1, 2, 3))
        if self.waterway is None:
            return aim, rudder, psi, v, 0.0
        ahead = min(max(at.x + self.lead * at.u, 0.0), self.waterway.line.length)
        turn = float(self.waterway.section(ahead).curvature) * (at.u + self.waterway.current)
        by_psi, by_v, by_rudder = (float(slope) for slope in self.line.turning)
        return aim, rudder + by_rudder * turn, psi + by_psi * turn, v + by_v * turn, turn
