"""A plan of speeds along the way: never over a limit, slowed for what lies ahead no faster than the ship loses way."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from narrows.control.linearization import linearize
from narrows.control.self_propulsion import self_propulsion
from narrows.control.speed_governor import SpeedGovernor
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.controllers import ControlLaw
from narrows.simulation.derivative import derivative

# Of what a stopped propeller loses of way, that a plan asks for.
EASE = 0.5
# Times of a ship length in which the governor makes up what is lacking.
SETTLED = 3.0
# Of which a change of speed is made: v2 is a line along the way, v is not.
PIECES = 4


def speed_governor(
    model: Model, helm: ControlLaw, limits: Sequence[tuple[float, float]], *, deceleration: float | None = None,
    most_revolutions: float = math.inf,
) -> SpeedGovernor:  # fmt: skip
    """Return a governor that keeps a ship's speed to limits along its way and slows in time.

    Speed and revolutions are of a ship straight ahead in the model's own water; what a section, a bend or a rudder adds
    to the resistance the governor makes up.

    Parameters
    ----------
    model : Model
        With terms of a propeller and a rudder.
    helm : ControlLaw
        What gives the rudder: a ``regulator``, say.
    limits : sequence of pairs (x [m], speed [m/s])
        From each place along the way on, through the water; the first holds before it too.
    deceleration : float [m/s2], optional
        With which speed is changed; half of what the ship loses at the slowest limit with the propeller stopped, unless
        given.
    most_revolutions : float [1/s]
        Of the engine.

    Raises
    ------
    InputError
        Where the model has no propeller, the limits do not rise along the way, or a speed is none.

    References
    ----------
    Åström and Hägglund (2006), Advanced PID Control, for the gains by placed poles and the integral that rests.
    """
    places, speeds = _checked(limits)
    revolutions = [self_propulsion(model, speed) for speed in speeds]
    slowest = min(speeds)
    loses = -float(derivative(model, {"u": slowest}, surge="free", revolutions=0.0)[3])
    rate = EASE * loses if deceleration is None else deceleration
    if not (math.isfinite(rate) and rate > 0):
        raise InputError(f"deceleration = {rate} slows nothing; give it in m/s2, over 0")
    x = _points(places, speeds, rate)
    u = [planned(place, places, speeds, rate) for place in x]
    known = dict(zip(speeds, revolutions, strict=True))
    turns = [known[speed] if speed in known else self_propulsion(model, speed) for speed in u]
    return SpeedGovernor(helm, tuple(x), tuple(u), tuple(turns), *_gains(model, slowest), most_revolutions)


def _checked(limits: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    try:
        places, speeds = (list(map(float, part)) for part in zip(*limits, strict=True))
    except (TypeError, ValueError):
        raise InputError("limits of the speed are pairs of a place along the way [m] and a speed [m/s]") from None
    if not np.isfinite([*places, *speeds]).all() or not (np.diff(places) > 0).all() or min(speeds) <= 0:
        raise InputError("limits of the speed rise along the way, each with a speed over 0; mend them")
    return places, speeds


def planned(x: float, places: Sequence[float], speeds: Sequence[float], rate: float) -> float:
    """Return the fastest speed at a place that keeps every limit [m/s]."""
    # x [m]; places [m]; speeds [m/s]; rate [m/s2]
    edges = [-math.inf, *places[1:], math.inf]
    away = [max(first - x, x - last, 0.0) for first, last in pairwise(edges)]
    return min(math.sqrt(speed**2 + 2 * rate * gap) for speed, gap in zip(speeds, away, strict=True))


def _points(places: Sequence[float], speeds: Sequence[float], rate: float) -> list[float]:
    """Where the plan bends: at the limits, and along each change between two of their speeds."""
    levels = [*(a + (b - a) * k / PIECES for a, b in pairwise(sorted(set(speeds))) for k in range(PIECES)), max(speeds)]
    gaps = {(fast**2 - slow**2) / (2 * rate) for slow in speeds for fast in levels if fast >= slow}
    bends = sorted({edge + gap * way for edge in places for gap in gaps for way in (-1, 1)})
    points = [bends[0] - 1.0, *bends, bends[-1] + 1.0]
    plan = [planned(x, places, speeds, rate) for x in points]
    inner = range(1, len(points) - 1)
    bent = [points[i] for i in inner if not _straight(points[i - 1 : i + 2], plan[i - 1 : i + 2])]
    return [points[0], *bent, points[-1]]


def _straight(x: Sequence[float], u: Sequence[float]) -> bool:
    line = u[0] + (u[2] - u[0]) * (x[1] - x[0]) / (x[2] - x[0])
    return abs(u[1] - line) <= 1e-9 * u[1]


def _gains(model: Model, u: float) -> tuple[float, float, float]:
    """Proportional and integral gain that place both poles, and revolutions for a surge acceleration."""
    linear = linearize(model, u=u, surge="free")
    row = linear.states.index("u")
    slope, push = linear.A[row, row], linear.B[row, linear.controls.index("revolutions")]
    pole = u / (SETTLED * model.configuration.ship.length)
    return float((2 * pole + slope) / push), float(pole**2 / push), float(1 / push)
