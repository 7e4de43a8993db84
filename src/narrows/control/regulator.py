"""Regulator: a control law of the rudder, its gains by the Riccati equation of the linear ship."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.aliases import accept_aliases
from narrows.control import settings
from narrows.control.linear_system import LinearSystem
from narrows.control.linearization import linearize
from narrows.control.regulator_gains import DEFAULT_WEIGHTS, FEEDBACK, RegulatorWeights, regulator_gains
from narrows.control.steady_course import check_holds, check_rudder
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice, clip, maximum
from narrows.results import BaseSummary
from narrows.simulation.controllers import LAST_ORDER, ORDER_TOLERANCE, Named

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

TURNED = ("psi", "v", "rudder")


@dataclass(frozen=True)
class HeldLine:
    """A line to hold and its gains; every number may be an array over many ships."""

    y: Any  # Offset to starboard of the line [m]
    # Rate of the rudder per deviation of offset, heading, sway velocity, yaw rate, rudder, and per integral of the
    # offset [rad/(s m), 1/s, rad/m, 1, 1/s, rad/(s2 m)]
    gains: tuple[Any, ...]
    rudder: Any = 0.0  # Rudder angle of the steady course [rad]
    psi: Any = 0.0  # Its heading [rad]
    v: Any = 0.0  # Its sway velocity [m/s]
    # Change of the course's heading, sway velocity and rudder per yaw rate of the waterway [s, m, s]
    turning: tuple[Any, ...] = (0.0, 0.0, 0.0)
    start: float = 0.0  # Time [s] or place [m] from which it is held; the first line also holds before

    def __post_init__(self) -> None:
        if len(self.gains) != len(FEEDBACK) or len(self.turning) != len(TURNED):
            raise InputError(
                f"a regulator has gains for {', '.join(FEEDBACK)} and turns of {', '.join(TURNED)}; give each"
            )
        for number in (self.y, *self.gains, self.rudder, self.psi, self.v, *self.turning, self.start):
            if not np.isfinite(number).all():
                raise InputError(f"a regulator with {number} steers nothing; give finite numbers")

    def numbers(self) -> dict[str, Any]:
        held = {f"held_{name}": getattr(self, name) for name in ("y", "rudder", "psi", "v")}
        held |= {f"by_{name}": gain for name, gain in zip(FEEDBACK, self.gains, strict=True)}
        return held | {f"turn_{name}": slope for name, slope in zip(TURNED, self.turning, strict=True)}


@dataclass(frozen=True, repr=False)
class Regulator(BaseSummary):
    """A track pilot: the rudder's rate is proportional to the deviations and to the integral of the offset.

    The gains scale with speed as if every force were proportional to its square. The steady turn of a bend ahead is
    added to the course. If the gear cannot follow, the integral is reduced to an attainable value (anti-windup).
    """

    lines: Sequence[HeldLine]  # The line to hold, or several, each from its own time or place on
    u: Any  # Design surge velocity [m/s]
    lead: Any  # Time that it looks ahead for bends of a waterway [s]
    unwinding: Any  # Time in which the integral is reduced if the gear is at a limit [s]
    integral: Any = 0.0  # Integral of the offset at the start [m s]
    along: bool = False  # True if lines are held from a place along the way on, instead of a time

    def __post_init__(self) -> None:
        starts = [line.start for line in self.lines]
        if not starts or any(after <= before for before, after in pairwise(starts)):
            raise InputError(
                "a regulator holds one line or more, each from a later time or place than the one before; give them"
            )
        for name in ("u", "unwinding", "lead", "integral"):
            value, positive = np.asarray(getattr(self, name)), name in ("u", "unwinding")
            if not (np.isfinite(value) & ((value > 0) | (not positive))).all():
                remedy = f"{name} over 0" if positive else "a finite number"
                raise InputError(f"a regulator with {name} = {getattr(self, name)} steers nothing; give {remedy}")

    def summary(self) -> str:
        """Describe the lines."""
        more = f", {len(self.lines)} lines one after the other" if len(self.lines) > 1 else ""
        return f"y = {self.lines[0].y} at u = {self.u}{more}"

    def parameters(self) -> Mapping[str, Any]:
        """Return the numbers of its lines, the speed, and the times for bends and for the integral."""
        numbers = {"made_for": self.u, "lead": self.lead, "unwinding": self.unwinding}
        for index, line in enumerate(self.lines):
            numbers |= {f"{name}_{index}": value for name, value in line.numbers().items()}
            numbers |= {f"start_{index}": line.start} if index else {}
        return numbers

    def memory(self, start: Named) -> Named:
        """Return the integral of the offset and the last order, at the start."""
        return {"integral": self.integral, LAST_ORDER: start["rudder"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the rudder's angle a step ahead, the integral, and that order."""
        speed = maximum(at.u, settings.SLOWEST * at.made_for)
        pace, share = at.u + at.current, speed / at.made_for
        turn = at.water("curvature", at.x + at.lead * pace) * pace
        held = {name: self._now(at, name) for name in self.lines[0].numbers()}
        off_y = at.y - held["held_y"]
        off_psi = at.psi - held["held_psi"] - held["turn_psi"] * turn / share
        off_v = at.v - held["held_v"] * share - held["turn_v"] * turn
        # The rate is added to the last order, not to the indicated angle, which lags by the delay of the gear:
        # otherwise only dt / (dt + delay) of the rate would be ordered.
        last = getattr(at, LAST_ORDER)
        off_rudder = last - held["held_rudder"] - held["turn_rudder"] * turn / share
        by_integral = held["by_integral"] * share * share
        wanted = -(
            share * (held["by_y"] * off_y + held["by_psi"] * off_psi + held["by_rudder"] * off_rudder)
            + held["by_v"] * off_v + held["by_r"] * (at.r - turn) + by_integral * at.integral
        )  # fmt: skip
        # The rudder's own term is taken at the end of the step, so that a long step does not overshoot.
        move = at.dt * wanted / (1 + at.dt * share * held["by_rudder"])
        order = clip(last + clip(move, at.dt * at.rudder_rate), at.rudder_limit)
        wound = (move - (order - last)) / (by_integral * at.unwinding)
        return {"rudder": order}, {"integral": at.integral + at.dt * off_y + wound, LAST_ORDER: order}

    def _now(self, at: Any, name: str) -> Any:
        value = getattr(at, f"{name}_0")
        for index in range(1, len(self.lines)):
            begun = (at.x if self.along else at.t + ORDER_TOLERANCE * at.dt) - getattr(at, f"start_{index}")
            value = choice(begun, getattr(at, f"{name}_{index}"), value)
        return value


@accept_aliases
def regulator(
    model: Model, y: Any, u: float, *, waterway: "Waterway | None" = None,
    at: float | Sequence[float] = 0.0, weights: RegulatorWeights = DEFAULT_WEIGHTS, **values: float,
) -> Regulator:  # fmt: skip
    """Return the regulator that holds a ship on a line: linear-quadratic on the rudder's rate.

    The law needs the sway velocity, as a track pilot with a good position fix has it.

    Parameters
    ----------
    model : Model
        A model with terms of a rudder.
    y : float or pairs (time [s], offset [m])
        Offset to starboard of the canal's centreline or of the waterway's line; each pair holds from its time on.
    u : float [m/s]
        Surge velocity through the water.
    waterway, at : Waterway, float or sequence of float [m], optional
        Waterway instead of the model's own canal, and the place along it for which the gains are computed; with
        several, rising, each holds from its place on.
    weights : RegulatorWeights
        Weights of the cost: defaults tuned by simulated voyages, or those of ``design``.
    **values : float [SI]
        As for ``linearize``.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, for weights and integrals; Åström and Hägglund
    (2006), Advanced PID Control, for the back-calculation.
    """
    check_rudder(model)
    about = partial(linearize, model, u=u, waterway=waterway, surge="held", **values)
    try:
        pairs = [(float(time), float(offset)) for time, offset in y] if np.ndim(y) else [(0.0, y)]
    except (TypeError, ValueError):
        raise InputError("the line to hold is an offset [m], or pairs of time [s] and offset; mend it") from None
    if isinstance(at, Sequence | np.ndarray):
        if np.ndim(y):
            raise InputError("y changes in time and the gains change along the way; give one of the two")
        courses = [(place, about(y=y, at=place)) for place in at]
    else:
        courses = [(time, about(y=offset, at=at)) for time, offset in pairs]
    lines = tuple(held_line(model, linear, start, weights) for start, linear in courses)
    passing = model.configuration.ship.length / u
    return Regulator(lines, u, settings.LEAD_TIME * passing, weights.unwinding_time * passing, along=np.ndim(at) > 0)


def held_line(
    model: Model, linear: LinearSystem, start: float = 0.0, weights: RegulatorWeights = DEFAULT_WEIGHTS
) -> HeldLine:  # fmt: skip
    course = {name: float(value) for name, value in linear.course.items()}
    check_holds(model, course["rudder"], course["y"], course["u"])
    gains = regulator_gains(model, linear, weights)
    # On a steady turn psi, v and the rudder keep y, v and r constant.
    balanced, b = [0, 2, 3], linear.B[:, linear.controls.index("rudder")]
    by_choice = np.column_stack([linear.A[balanced, 1], linear.A[balanced, 2], b[balanced]])
    turning = np.linalg.solve(by_choice, -linear.A[balanced, 3]).tolist()
    psi, v, rudder = (course[name] - by_turn * course["r"] for name, by_turn in zip(TURNED, turning, strict=True))
    return HeldLine(course["y"], gains, rudder, psi, v, tuple(turning), start)
