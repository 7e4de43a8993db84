"""Controllers: orders to rudder and propeller, step by step.

A control law is written like a term: arithmetic of named quantities, with a few numbers of memory. Such a law runs in
every engine, also for a million ships at once. Any other object that gives orders steers single voyages.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.results import BaseSummary, shortened
from narrows.quantities.arithmetic import angle, choice
from narrows.quantities.names import Number
from narrows.simulation.inputs import real_numbers

Named = Mapping[str, Number]

# Tolerance for an early order of a schedule [steps]: times are sums, and rounding must not delay an order.
ORDER_TOLERANCE = 1e-6


@runtime_checkable
class ControlLaw(Protocol):
    """A controller in arithmetic, for single voyages, fleets and the envelope."""

    def parameters(self) -> Mapping[str, Any]:
        """Return its numbers by name: floats, or DataArrays if they vary over a fleet."""

    def memory(self, start: Named) -> Named:
        """Return its memory at the ``start``: x, y [m], cos_psi, sin_psi, u, v [m/s], r [rad/s] and actuators."""

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return orders by the names of actuators (``rudder`` [rad]), and the new memory.

        Attributes of ``at`` are t, dt [s], the state, psi [rad], positions of actuators, the limit and rate of each
        (``rudder_limit`` [rad], ``rudder_rate`` [rad/s]), the ``current`` along the line [m/s], parameters and memory.
        ``water(name, x)`` gives the water at a place along the line: its ``curvature`` [1/m], and the distance at which
        a keel meets the bank to ``starboard`` and to ``port`` [m].
        """


class VoyageState(NamedTuple):
    """The state of the ship for a controller of Python."""

    x: float  # Position of midship along the canal [m]
    y: float  # Position of midship to starboard of its line [m]
    psi: float  # Heading relative to the line [rad]
    u: float  # Surge velocity through the water [m/s]
    v: float  # Sway velocity through the water [m/s]
    r: float  # Yaw rate [rad/s]
    rudder: float  # Rudder angle [rad]


# The ordered rudder angle [rad] at a time [s] in a state.
Order = Callable[[float, VoyageState], float]


@runtime_checkable
class Controller(Protocol):
    """Any object that gives orders to the rudder of a single voyage."""

    def begin(self) -> Order:
        """Return the orders of one voyage, with a memory of their own."""


class _Law(BaseSummary):
    # Each law writes these; the protocol documents them.
    parameters, memory, orders = ControlLaw.parameters, ControlLaw.memory, ControlLaw.orders

    def summary(self) -> str:
        numbers = {n: f"{v:.4g}" if isinstance(v, float) else " ".join(str(v).split()) for n, v in vars(self).items()}
        return ", ".join(f"{name} = {shortened(text, 40)}" for name, text in numbers.items())


class WithoutMemory(_Law):
    def memory(self, start: Named) -> Named:
        return {}


@accept_aliases
@dataclass(frozen=True, repr=False)
class ConstantRudder(WithoutMemory):
    """One rudder angle, ordered at the start: a turning circle.

    Raises an InputError if it is not finite.

    >>> nw.simulate(kcs, u=6.0, duration=60.0, controller=nw.ConstantRudder(0.1)).grounded
    False
    """

    rudder: Any  #: Angle, positive if it turns the bow to starboard: float or DataArray [rad]

    def __post_init__(self) -> None:
        if not np.isfinite(real_numbers(self.rudder)).all():
            raise InputError(f"a rudder held at {shown(self.rudder)} is no order; give its angle in radians")

    def parameters(self) -> Mapping[str, Any]:
        return {"angle": self.rudder}

    def orders(self, at: Any) -> tuple[Named, Named]:
        return {"rudder": at.angle}, {}


@accept_aliases
@dataclass(frozen=True, repr=False)
class Zigzag(_Law):
    """The zigzag test: the rudder is reversed each time the heading has changed as far to the other side.

    Raises an InputError if an angle is zero or not finite, or the heading is negative.

    Source: ITTC (2017), Recommended procedure 7.5-04-02-01, Full scale manoeuvring trials.

    >>> law = nw.Zigzag(rudder=0.17, heading=0.17)
    >>> nw.simulate(kcs.in_open_water(), u=6.0, duration=60.0, contact="none", controller=law).grounded
    False
    """

    rudder: Any  #: Angle of the first order, negative for a first turn to port: float or DataArray [rad]
    heading: Any  #: Heading change at which the order is reversed: float or DataArray [rad]

    def __post_init__(self) -> None:
        rudder, heading = real_numbers(self.rudder), real_numbers(self.heading)
        finite = np.isfinite(rudder).all() and np.isfinite(heading).all()
        if not (finite and (heading > 0).all() and (rudder != 0).all()):
            raise InputError("a zigzag needs a rudder angle and a positive change of heading; give both")

    def parameters(self) -> Mapping[str, Any]:
        return {"angle": self.rudder, "change": self.heading, "first": np.sign(self.rudder)}

    def memory(self, start: Named) -> Named:
        # The side of the current order relative to the first, and the heading at the start.
        return {"side": 1.0, "cos_start": start["cos_psi"], "sin_start": start["sin_psi"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        across = at.sin_psi * at.cos_start - at.cos_psi * at.sin_start
        turned = angle(at.cos_psi * at.cos_start + at.sin_psi * at.sin_start, across)
        side = choice(at.change - at.side * at.first * turned, at.side, -at.side)
        return {"rudder": side * at.angle}, {"side": side, "cos_start": at.cos_start, "sin_start": at.sin_start}


@accept_aliases
@dataclass(frozen=True, repr=False)
class Autopilot(WithoutMemory):
    """A track pilot: rudder in proportion to the deviations, added to the rudder of the steady course.

    Its numbers are floats or DataArrays. Raises an InputError if there are not four gains, or a number is not finite.

    >>> pilot = nw.Autopilot(y=0.0, gains=(0.01, 2.0, 0.0, 50.0))
    >>> nw.simulate(kcs, y=10.0, u=6.0, duration=60.0, controller=pilot).grounded
    False
    """

    y: Any  #: Offset to hold [m]
    #: Rudder per deviation of offset [rad/m], heading [1], sway velocity [rad s/m] and yaw rate [s]; positive gains
    #: bring the ship back
    gains: tuple[Any, Any, Any, Any]
    rudder: Any = 0.0  #: Rudder angle of the steady course there [rad]
    psi: Any = 0.0  #: Heading of the steady course there [rad]
    v: Any = 0.0  #: Sway velocity of the steady course there [m/s]

    def __post_init__(self) -> None:
        if len(self.gains) != 4:
            raise InputError(f"an autopilot has four gains, for y, psi, v and r; these are {len(self.gains)}")
        for number in (self.y, *self.gains, self.rudder, self.psi, self.v):
            if not np.isfinite(real_numbers(number)).all():
                raise InputError(f"an autopilot with {shown(number)} steers nothing; give finite numbers")

    def parameters(self) -> Mapping[str, Any]:
        held = {"held_y": self.y, "held_psi": self.psi, "held_v": self.v, "held_rudder": self.rudder}
        return held | dict(zip(("by_y", "by_psi", "by_v", "by_r"), self.gains, strict=True))

    def orders(self, at: Any) -> tuple[Named, Named]:
        off = at.by_y * (at.y - at.held_y) + at.by_psi * (at.psi - at.held_psi)
        return {"rudder": at.held_rudder - (off + at.by_v * (at.v - at.held_v) + at.by_r * at.r)}, {}


@accept_aliases
@dataclass(frozen=True, repr=False)
class PID(_Law):
    """A heading autopilot: rudder against the error of heading, its integral and the yaw rate.

    Its numbers are floats or DataArrays; positive gains bring the ship back. The integral waits while the order is
    beyond the limit of the rudder. Raises an InputError if a number is not finite.

    >>> nw.simulate(kcs, psi=0.05, u=6.0, duration=60.0, controller=nw.PID(kp=1.0, kd=20.0)).grounded
    False
    """

    kp: Any  #: Rudder per error of heading [1]
    kd: Any = 0.0  #: Rudder per yaw rate [s]
    ki: Any = 0.0  #: Rudder per integral of the error [1/s]
    psi: Any = 0.0  #: Heading to hold, relative to the line [rad]

    def __post_init__(self) -> None:
        for name, number in vars(self).items():
            if not np.isfinite(real_numbers(number)).all():
                raise InputError(f"{name} = {shown(number)} of an autopilot is no finite number; give one")

    def parameters(self) -> Mapping[str, Any]:
        return {"by_psi": self.kp, "by_r": self.kd, "by_sum": self.ki, "held_psi": self.psi}

    def memory(self, start: Named) -> Named:
        return {"sum": 0.0}

    def orders(self, at: Any) -> tuple[Named, Named]:
        off = at.psi - at.held_psi
        order = -(at.by_psi * off + at.by_sum * at.sum + at.by_r * at.r)
        return {"rudder": order}, {"sum": choice(abs(order) - at.rudder_limit, at.sum, at.sum + off * at.dt)}


class ExternalOrder(WithoutMemory):
    def parameters(self) -> Mapping[str, Any]:
        return {"order": 0.0}

    def orders(self, at: Any) -> tuple[Named, Named]:
        return {"rudder": at.order}, {}


# Name of a law's last rudder order: other controllers keep it up to date, so that the law takes over without a jump.
LAST_ORDER = "last_order"

# An example of each law for a ship of a length [m], by name: docs list them, the tests run them in every engine.
CONTROLLERS: dict[str, Callable[[float], ControlLaw]] = {
    "constant": lambda length: ConstantRudder(0.12),
    "zigzag": lambda length: Zigzag(0.17, 0.06),
    "pid": lambda length: PID(1.2, 1.5 * length, 0.01),
    "pilot": lambda length: Autopilot(0.075 * length, (0.6 / length, 1.2, 0.4, 2.0), 0.01, 0.005, -0.01),
}
