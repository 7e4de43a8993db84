"""Hands on the wheel: orders to the rudder, and the steering gear that follows them at its own rate."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from narrows.errors import InputError
from narrows.ship.actuators import SteeringGear
from narrows.simulation.integrate import Motion, Rate, State

Order = Callable[[float, State], float]
"""The rudder angle [rad] that is asked for at a time [s] in a state."""


class Helm(Protocol):
    """Whoever gives orders to the rudder."""

    def begin(self) -> Order:
        """Return what gives the orders of one voyage, with a memory of its own."""


@dataclass(frozen=True)
class Held:
    """One rudder angle, ordered at the start: a turning circle.

    Parameters
    ----------
    rudder : float [rad]
        Positive where it turns the bow to starboard.

    Raises
    ------
    InputError
        Where it is not finite.
    """

    rudder: float

    def __post_init__(self) -> None:
        if not math.isfinite(self.rudder):
            raise InputError(f"a rudder held at {self.rudder} is no order; give its angle")

    def begin(self) -> Order:
        """Return what gives the orders of one voyage."""
        return lambda time, state: self.rudder


@dataclass(frozen=True)
class Zigzag:
    """The zigzag test: the rudder is put over each time the heading has come as far to the other side.

    Parameters
    ----------
    rudder : float [rad]
        Of the first order; negative for a first turn to port.
    heading : float [rad]
        Change of heading at which the order is reversed.

    Raises
    ------
    InputError
        Where an angle is zero, or the heading is negative.

    References
    ----------
    ITTC (2017), Recommended procedure 7.5-04-02-01, Full scale manoeuvring trials.
    """

    rudder: float
    heading: float

    def __post_init__(self) -> None:
        if not (0 < self.heading < math.inf and self.rudder and math.isfinite(self.rudder)):
            raise InputError("a zigzag needs a rudder angle and a positive change of heading; give both")

    def begin(self) -> Order:
        """Return what gives the orders of one voyage; it remembers the last order."""
        start: float | None = None
        side = 1.0

        def order(time: float, state: State) -> float:
            nonlocal start, side
            heading = math.atan2(state[3], state[2])
            start = heading if start is None else start
            turned = math.remainder(heading - start, 2 * math.pi)
            if side * math.copysign(1.0, self.rudder) * turned >= self.heading:
                side = -side
            return side * self.rudder

        return order


@dataclass(frozen=True)
class Autopilot:
    """A track pilot: rudder in proportion to what is off, from the rudder that holds the ship.

    Parameters
    ----------
    y : float [m]
        Offset to hold.
    gains : four floats [rad/m, 1, rad s/m, s]
        Rudder for offset, heading, sway velocity and yaw rate off; positive ones bring her back.
    rudder : float [rad]
        That holds her there.
    psi : float [rad]
        Heading that holds her there.
    v : float [m/s]
        Sway velocity that holds her there.
    """

    y: float
    gains: tuple[float, float, float, float]
    rudder: float = 0.0
    psi: float = 0.0
    v: float = 0.0

    def begin(self) -> Order:
        """Return what gives the orders of one voyage."""
        by_y, by_psi, by_v, by_r = self.gains

        def order(time: float, state: State) -> float:
            _, y, c, s, _, v, r, _ = state
            off = by_y * (y - self.y) + by_psi * (math.atan2(s, c) - self.psi) + by_v * (v - self.v) + by_r * r
            return self.rudder - off

        return order


def turning_rate(gear: SteeringGear, rudder: float, order: float, time: float) -> float:
    """Return how fast the rudder turns towards an order over a step [rad/s], to reach it at most (ours).

    Parameters
    ----------
    gear : SteeringGear
        Its limits.
    rudder : float [rad]
        Now.
    order : float [rad]
        Cut to the limit of the gear.
    time : float [s]
        Length of the step.
    """
    wanted = min(max(order, -gear.limit), gear.limit) - rudder
    reach = gear.rate * time
    return min(max(wanted, -reach), reach) / time


def steered(rate: Callable[[float], Rate], helm: Helm | None, gear: SteeringGear) -> Motion:
    """Return what moves a ship under a helm, a new order each step; without one the rudder stays (ours).

    Parameters
    ----------
    rate : callable
        Gives the right-hand side by the rate of the rudder [rad/s].
    helm : Helm, optional
        Gives the orders.
    gear : SteeringGear
        Follows them.
    """
    if helm is None:
        still = rate(0.0)
        return lambda time, state, h: still
    order = helm.begin()
    return lambda time, state, h: rate(turning_rate(gear, state[-1], order(time, state), h))
