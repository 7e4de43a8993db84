"""The regulator as a control law: linear-quadratic on the rate of the rudder, with an integral of the offset."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from narrows.control.settings import SLOWEST
from narrows.errors import InputError
from narrows.quantities.arithmetic import choice, clip, maximum
from narrows.results import BaseSummary
from narrows.simulation.controllers import LAST_ORDER, ORDER_TOLERANCE, Named

FEEDBACK = ("y", "psi", "v", "r", "rudder", "integral")
TURNED = ("psi", "v", "rudder")


@dataclass(frozen=True)
class HeldLine:
    """A line to hold and its gains; every number may be an array over many ships.

    Parameters
    ----------
    y : float [m]
        Offset to starboard of the line.
    gains : six floats [rad/(s m), 1/s, rad/m, 1, 1/s, rad/(s2 m)]
        Rate of the rudder per deviation of offset, heading, sway velocity, yaw rate, rudder, integral of the offset.
    rudder, psi : float [rad]
        Values on the steady course.
    v : float [m/s]
        Sway velocity on it.
    turning : three floats [s, m, s]
        Change of the course's heading, sway velocity and rudder per yaw rate of the waterway.
    start : float [s] or [m]
        Time or place from which it is held; the first line also holds before.

    Raises
    ------
    InputError
        If the number of gains or turns is wrong, or a number is not finite.
    """

    y: Any
    gains: tuple[Any, ...]
    rudder: Any = 0.0
    psi: Any = 0.0
    v: Any = 0.0
    turning: tuple[Any, ...] = (0.0, 0.0, 0.0)
    start: float = 0.0

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

    Parameters
    ----------
    lines : sequence of HeldLine
        The line to hold, or several, each from its own time on.
    u : float [m/s]
        Design surge velocity.
    lead : float [s]
        Time that it looks ahead for bends of a waterway.
    unwinding : float [s]
        Time in which the integral is reduced if the gear is at a limit.
    integral : float [m s]
        Integral of the offset at the start.
    along : bool
        True if lines are held from a place along the way on, instead of a time.

    Raises
    ------
    InputError
        If there is no line, their times do not rise, or a number is not finite or has the wrong sign.
    """

    lines: Sequence[HeldLine]
    u: Any
    lead: Any
    unwinding: Any
    integral: Any = 0.0
    along: bool = False

    def __post_init__(self) -> None:
        starts = [line.start for line in self.lines]
        if not starts or any(after <= before for before, after in pairwise(starts)):
            raise InputError(
                "a regulator holds one line or more, each from a later time or place than the one before; give them"
            )
        for name in ("u", "unwinding"):
            if not (np.isfinite(getattr(self, name)).all() and np.all(np.asarray(getattr(self, name)) > 0)):
                raise InputError(f"a regulator needs {name} over 0; it is {getattr(self, name)}")
        for name in ("lead", "integral"):
            if not np.isfinite(getattr(self, name)).all():
                raise InputError(f"a regulator with {name} = {getattr(self, name)} steers nothing; give a number")

    def summary(self) -> str:
        """Describe the lines."""
        line = self.lines[0]
        more = f", {len(self.lines)} lines one after the other" if len(self.lines) > 1 else ""
        return f"y = {line.y} at u = {self.u}{more}"

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
        speed = maximum(at.u, SLOWEST * at.made_for)
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
        """Return a number of the current line."""
        value = getattr(at, f"{name}_0")
        for index in range(1, len(self.lines)):
            begun = (at.x if self.along else at.t + ORDER_TOLERANCE * at.dt) - getattr(at, f"start_{index}")
            value = choice(begun, getattr(at, f"{name}_{index}"), value)
        return value
