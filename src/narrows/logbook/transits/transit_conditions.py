"""Assumed conditions of a routine transit: wind, correlated gusts, and the wander of a pilot's aim."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from narrows.control.regulator import regulator
from narrows.control.regulator_law import HeldLine
from narrows.control.steady_course import steady_course
from narrows.errors import InputError, shown
from narrows.logbook.beam_wind import BeamWind
from narrows.logbook.settings import PILOT_COURSES
from narrows.model.model import Model
from narrows.simulation.controllers import Order, VoyageState

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


@dataclass(frozen=True, repr=False)
class TransitConditions(BeamWind):
    """Wind and aim of transits, as standard deviations.

    Parameters
    ----------
    wind : float [m/s]
        Speed of a beam wind of one standard deviation, from either side, the same all through a transit.
    windage : float [m2], optional
        Lateral area above the water; a tenth of the square of the length unless given.
    wind_lever : float [m], optional
        Standard deviation of where the force acts, off midship; a tenth of the length unless given.
    gust : float [1]
        Force and moment that come and go, over those of the wind.
    gust_time : float [s]
        How long a gust stays: a first-order process.
    wander : float [m]
        Wander of a pilot's aim about the middle.
    wander_time : float [s]
        How long an aim stays.
    gust_correlation : float [1]
        Between force and moment of gusts: 1 where they act at one place ahead of midship all through.

    Raises
    ------
    InputError
        Where a number is negative or not finite, a time is 0, or a correlation is more than 1.

    Examples
    --------
    >>> nw.TransitConditions(wind=2.0).wind
    2.0
    """

    gust: float = 0.3
    gust_time: float = 40.0
    wander: float = 3.0
    wander_time: float = 400.0
    gust_correlation: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.gust_correlation > 1:
            raise InputError(f"gust_correlation = {shown(self.gust_correlation)}: a correlation is 1 at most")

    def summary(self) -> str:
        """The conditions."""
        return (
            f"beam wind {self.wind:g} m/s, gusts of {100 * self.gust:.0f} % of its force that stay {self.gust_time:g} s"
            f", an aim that wanders by {self.wander:g} m in {self.wander_time:g} s (standard deviations)"
        )

    def gust_push(self, model: Model) -> np.ndarray:
        """Return sway force [N] and yaw moment [N m] of two independent gusts of size one, (2, 2).

        Parameters
        ----------
        model : Model
            The ship.
        """
        along, apart = self.gust_correlation, math.sqrt(1 - self.gust_correlation**2)
        return np.asarray(self.gust * self.steady_push(model)[:, None] * [[1.0, 0.0], [along, apart]])


def wandering(
    size: float, memory: float, step: float, count: int, draw: np.random.Generator, width: int = 1
) -> np.ndarray:
    kept, normal = math.exp(-step / memory), draw.standard_normal((count, width))
    values = np.empty((count, width))
    values[0] = normal[0]
    for i in range(1, count):
        values[i] = kept * values[i - 1] + math.sqrt(1 - kept**2) * normal[i]
    return size * values


@dataclass(frozen=True)
class TransitPilot:
    line: HeldLine  # Gains, made for the farthest aim
    lead: float  # How far ahead bends are looked at [s]
    courses: np.ndarray  # (offsets, 4) y [m], rudder, psi [rad], v [m/s] of steady courses
    limit: float  # Limit of the rudder [rad]
    times: np.ndarray  # (n,) Where it wants to be, straight between [s]
    aims: np.ndarray  # (n,) Where it wants to be, straight between [s]
    waterway: "Waterway | None" = None  # Whose bends it follows

    @classmethod
    def of(
        cls, model: Model, u: float, times: np.ndarray, aims: np.ndarray, waterway: "Waterway | None" = None
    ) -> "TransitPilot":
        # u [m/s]; times, aims (n,) [s]
        far = max(float(np.abs(aims).max()), 1e-6)
        y = np.linspace(-far, far, PILOT_COURSES)
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
        turn = float(self.waterway.section(ahead).curvature) * (at.u + float(self.waterway.current_at(ahead)))
        by_psi, by_v, by_rudder = (float(slope) for slope in self.line.turning)
        return aim, rudder + by_rudder * turn, psi + by_psi * turn, v + by_v * turn, turn
