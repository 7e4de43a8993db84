"""A governor of the speed as a control law: revolutions that keep the speeds of a plan along the way, beside a helm."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.errors import InputError
from narrows.quantities.arithmetic import choice, maximum, minimum
from narrows.results import Described
from narrows.simulation.controllers import ControlLaw, Named

# What it remembers: the speed that was lacking, over time [m].
SHORTFALL = "surge_shortfall"


@dataclass(frozen=True, repr=False)
class SpeedGovernor(Described):
    """Revolutions of the propeller by a plan of speeds along the way, while a helm steers.

    The plan is a line from point to point. Revolutions are those that keep its speed straight ahead, with what its
    slope asks for, and a proportional and an integral part of what is lacking; where the engine is at a limit the
    integral rests.

    Parameters
    ----------
    helm : ControlLaw
        What gives the rudder.
    x : sequence of float [m]
        Along the way, rising.
    u : sequence of float [m/s]
        Surge velocity through the water at each.
    revolutions : sequence of float [1/s]
        That keep it straight ahead.
    gain : float [1/m]
        Revolutions for a metre a second that is lacking.
    integral_gain : float [1/(m s)]
        For a metre that is.
    inertia : float [s/m]
        Revolutions for a metre a second squared.
    most_revolutions : float [1/s]
        Of the engine.

    Raises
    ------
    InputError
        Where there are no two points, they do not rise, or a number is not finite.
    """

    helm: ControlLaw
    x: Sequence[float]
    u: Sequence[float]
    revolutions: Sequence[float]
    gain: float
    integral_gain: float
    inertia: float
    most_revolutions: float = math.inf

    def __post_init__(self) -> None:
        if not isinstance(self.helm, ControlLaw):
            raise InputError(f"a {type(self.helm).__name__} is no law in arithmetic that a governor could stand beside")
        if not self.most_revolutions > 0:
            raise InputError(f"most_revolutions = {self.most_revolutions} drives no ship; give it in 1/s, over 0")
        if len(self.x) < 2 or not len(self.x) == len(self.u) == len(self.revolutions):
            raise InputError("a plan of speeds has two points or more, each with x, u and revolutions; give them")
        numbers = np.array([*self.x, *self.u, *self.revolutions, self.gain, self.integral_gain, self.inertia], float)
        if not np.isfinite(numbers).all() or not (np.diff(self.x) > 0).all() or not (np.asarray(self.u) > 0).all():
            raise InputError("points of a plan of speeds rise along the way, with speeds over 0; mend them")

    def summary(self) -> str:
        """Say the slowest and the fastest of its speeds, and what steers."""
        return f"{min(self.u):.3g} to {max(self.u):.3g} m/s along the way, {type(self.helm).__name__} at the rudder"

    def parameters(self) -> Mapping[str, Any]:
        """Return the numbers of the helm and of the plan."""
        plan = {"plan_u": self.u[0], "plan_revolutions": self.revolutions[0]}
        plan |= {f"plan_x_{i}": x for i, x in enumerate(self.x)}
        steps = np.diff(self.x)
        for i in range(len(steps)):
            plan[f"plan_slope_u_{i}"] = (self.u[i + 1] - self.u[i]) / steps[i]
            plan[f"plan_slope_revolutions_{i}"] = (self.revolutions[i + 1] - self.revolutions[i]) / steps[i]
        gains = {"surge_gain": self.gain, "surge_integral_gain": self.integral_gain, "surge_inertia_gain": self.inertia}
        most = {"most_revolutions": self.most_revolutions} if math.isfinite(self.most_revolutions) else {}
        return {**self.helm.parameters(), **plan, **gains, **most}

    def memory(self, start: Named) -> Named:
        """Return what the helm keeps, and that nothing is lacking yet.

        Parameters
        ----------
        start : mapping of str to number
            The state at the start.
        """
        return {**self.helm.memory(start), SHORTFALL: 0.0}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the helm's orders and revolutions, and what both keep.

        Parameters
        ----------
        at : object
            Quantities by name.
        """
        orders, kept = self.helm.orders(at)
        speed, rate, revolutions = at.plan_u, 0.0, at.plan_revolutions
        for i in range(len(self.x) - 1):
            first, last = getattr(at, f"plan_x_{i}"), getattr(at, f"plan_x_{i + 1}")
            covered = _within(at.x - first, last - first)
            slope = getattr(at, f"plan_slope_u_{i}")
            speed = speed + slope * covered
            revolutions = revolutions + getattr(at, f"plan_slope_revolutions_{i}") * covered
            rate = rate + choice(at.x - first, choice(last - at.x, slope * at.u, 0.0), 0.0)
        lacking, shortfall = speed - at.u, getattr(at, SHORTFALL)
        wanted = revolutions + at.surge_inertia_gain * rate + at.surge_gain * lacking
        asked = wanted + at.surge_integral_gain * (shortfall + at.dt * lacking)
        limited = math.isfinite(self.most_revolutions)
        most = minimum(at.revolutions_limit, at.most_revolutions) if limited else at.revolutions_limit
        order = _within(asked, most)
        # At a limit that asks for more of it the integral rests.
        shortfall = shortfall + choice(abs(asked - order), 0.0, at.dt * lacking)
        return {**orders, "revolutions": order}, {**kept, SHORTFALL: shortfall}


def _within(value: Any, most: Any) -> Any:
    return minimum(maximum(value, 0.0), most)
