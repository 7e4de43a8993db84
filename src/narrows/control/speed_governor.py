"""Plan speeds along a waterway: below every limit, with deceleration in time."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import BaseSummary
from narrows.control import settings
from narrows.control.steady_course import linearize
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice, maximum, minimum
from narrows.quantities.names import Number
from narrows.simulation.controllers import ControlLaw, Named
from narrows.simulation.derivative import derivative
from narrows.simulation.initial_state import self_propulsion

# Memory of the law: the integral of the missing speed [m].
SHORTFALL = "surge_shortfall"


@dataclass(frozen=True, repr=False)
class SpeedGovernor(BaseSummary):
    """Propeller revolutions that follow a speed plan along the way, while a helm steers.

    The plan is the fastest speed that keeps every limit, with a steady rate of change. The revolutions are those that
    keep its speed straight ahead, linear between the slowest and the fastest limit, plus a term for its rate, plus a
    proportional and an integral part of the speed error; at a limit of the engine the integral stops.
    """

    helm: ControlLaw  # Controls the rudder
    x: Sequence[float]  # Places along the way, rising, from which the limits hold [m]
    u: Sequence[float]  # Limits of the surge velocity through the water [m/s]
    revolutions: Sequence[float]  # Revolutions that keep each straight ahead [1/s]
    rate: float  # Rate of speed changes [m/s2]
    gain: float  # Revolutions per speed error [1/m]
    integral_gain: float  # Revolutions per integral of the speed error [1/(m s)]
    inertia: float  # Revolutions per acceleration [s/m]
    most_revolutions: float  # Limit of the engine [1/s]

    def __post_init__(self) -> None:
        if not isinstance(self.helm, ControlLaw):
            raise InputError(f"a {type(self.helm).__name__} is no control law in arithmetic, which a governor needs")

    def summary(self) -> str:
        return f"{min(self.u):.3g} to {max(self.u):.3g} m/s along the way, {type(self.helm).__name__} at the rudder"

    def parameters(self) -> Mapping[str, Any]:
        (slow, least), (fast, most) = (pick(zip(self.u, self.revolutions, strict=True)) for pick in (min, max))
        by_speed = (most - least) / (fast - slow) if fast > slow else least / slow
        plan = {"plan_rate": self.rate, "plan_slowest": slow, "plan_revolutions": least, "plan_by_speed": by_speed}
        for name, values in (("x", self.x), ("u", self.u)):
            plan |= {f"limit_{name}_{i}": value for i, value in enumerate(values)}
        gains = {"surge_gain": self.gain, "surge_integral_gain": self.integral_gain, "surge_inertia_gain": self.inertia}
        return {**self.helm.parameters(), **plan, **gains, "most_revolutions": self.most_revolutions}

    def memory(self, start: Named) -> Named:
        return {**self.helm.memory(start), SHORTFALL: 0.0}

    def orders(self, at: Any) -> tuple[Named, Named]:
        orders, kept = self.helm.orders(at)
        places, limits = ([getattr(at, f"limit_{name}_{i}") for i in range(len(self.x))] for name in "xu")
        speed, rate = planned_speed(at.x, places, limits, at.plan_rate)
        revolutions = at.plan_revolutions + at.plan_by_speed * (speed - at.plan_slowest)
        speed_error, shortfall = speed - at.u, getattr(at, SHORTFALL)
        wanted = revolutions + at.surge_inertia_gain * rate + at.surge_gain * speed_error
        unlimited = wanted + at.surge_integral_gain * (shortfall + at.dt * speed_error)
        order = minimum(maximum(unlimited, 0.0), minimum(at.revolutions_limit, at.most_revolutions))
        # At a limit the integral must not grow further.
        shortfall = shortfall + choice(abs(unlimited - order), 0.0, at.dt * speed_error)
        return {**orders, "revolutions": order}, {**kept, SHORTFALL: shortfall}


@accept_aliases
def speed_governor(
    model: Model, helm: ControlLaw, limits: Sequence[tuple[float, float]], *, deceleration: float | None = None,
    most_revolutions: float | None = None,
) -> SpeedGovernor:  # fmt: skip
    """Return a governor that keeps a ship's speed to limits along its way and decelerates in time.

    Speed and revolutions are those of a ship straight ahead in the model's own water; the governor corrects for the
    resistance of a section, a bend or a rudder. Braking is that of still water: with a current from astern begin early.

    Source: Åström and Hägglund (2006), Advanced PID Control, for pole placement and conditional integration.

    Parameters
    ----------
    model, helm : Model, ControlLaw
        A model with terms of a propeller and a rudder, and what controls the rudder, such as a ``regulator``.
    limits : sequence of pairs (x [m], speed [m/s])
        Limits through the water, each from its place along the way on; the first also holds before it.
    deceleration : float [m/s2], optional
        Rate of speed changes; half of that at the slowest limit with the propeller stopped, unless given.
    most_revolutions : float [1/s], optional
        Limit of the engine; half again those that keep the fastest limit, unless given.
    """
    try:
        places, speeds = (list(map(float, part)) for part in zip(*limits, strict=True))
    except (TypeError, ValueError):
        raise InputError("limits of the speed are pairs of a place along the way [m] and a speed [m/s]") from None
    if not np.isfinite([*places, *speeds]).all() or not (np.diff(places) > 0).all() or min(speeds) <= 0:
        raise InputError("limits of the speed rise along the way, each with a speed over 0; mend them")
    revolutions = [self_propulsion(model, speed) for speed in speeds]
    slowest = min(speeds)
    coasting = -float(derivative(model, {"u": slowest}, surge="free", revolutions=0.0)[3])
    rate = settings.EASE * coasting if deceleration is None else deceleration
    if not 0 < rate <= coasting:
        most_of = f"the {coasting:.3g} that this ship loses at {slowest:g} m/s with its propeller stopped"
        raise InputError(f"deceleration = {rate:g} m/s2: give more than 0 and at most {most_of}, or leave it out")
    most = settings.ENGINE_RESERVE * max(revolutions) if most_revolutions is None else most_revolutions
    # Proportional and integral gain by pole placement, and revolutions per surge acceleration.
    linear = linearize(model, u=slowest, surge="free")
    row = linear.states.index("u")
    slope, push = float(linear.A[row, row]), float(linear.B[row, linear.controls.index("revolutions")])
    pole = slowest / (settings.GOVERNOR_TIME * model.configuration.ship.length)
    gains = (2 * pole + slope) / push, pole**2 / push, 1 / push
    return SpeedGovernor(helm, places, speeds, revolutions, rate, *gains, most)


def planned_speed(x: Number, places: Sequence[Number], speeds: Sequence[Number], rate: Number) -> tuple[Number, Number]:
    """Return the fastest speed at a place that keeps every limit [m/s], and its rate of change [m/s2]."""
    speed: Number = math.inf
    change: Number = 0.0
    for i, limit in enumerate(speeds):
        gap: Number = 0.0
        own_change: Number = 0.0
        # Before the reach of the limit the ship brakes, after it it gains speed.
        ends = [(places[i] - x, -rate)] * bool(i) + [(x - place, rate) for place in places[i + 1 : i + 2]]
        for distance, its_change in ends:
            gap = gap + maximum(distance, 0.0)
            own_change = choice(distance, its_change, own_change)
        own = (limit**2 + 2.0 * rate * gap) ** 0.5
        change = choice(speed - own, own_change, change) if i else own_change
        speed = minimum(speed, own) if i else own
    return speed, change
