"""Make a regulator for a ship: gains of the rudder's rate by the Riccati equation of the exact linear system."""

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.control.linear_system import LinearSystem
from narrows.control.linearization import linearize
from narrows.control.regulator_law import FELT, HeldLine, Regulator
from narrows.control.settings import (
    DRAWN_SHIPS,
    HELD_SHARE,
    INTEGRAL_TIME,
    LEAD_TIME,
    LEAST_DECAY,
    STROKE_TIME,
    UNWINDING_TIME,
    WEIGHT_LADDER,
    WEIGHTS,
)
from narrows.control.steady_course import check_rudder
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.grid import sampled

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


def regulator(
    model: Model, y: Any, u: float, *, waterway: "Waterway | None" = None,
    at: float | Sequence[float] = 0.0, **values: float,
) -> Regulator:  # fmt: skip
    """Return the regulator that holds a ship on a line: linear-quadratic on the rudder's rate.

    Half a beam off the line, 5 degrees off the course, 10 degrees of rudder off that of the course, these 10 degrees
    put over in a tenth of the time of a ship length, and half a beam off for 1.2 of these times weigh alike; where that
    does not hold nearly all ships that the tests leave possible, less heading and more rudder do. It is told the sway
    velocity, as a track pilot with a good fix is.

    Parameters
    ----------
    model : Model
        With terms of a rudder.
    y : float or pairs (time [s], offset [m])
        To starboard of the middle of the canal, or of the line of the waterway; pairs are held each from its time on.
    u : float [m/s]
        Surge velocity through the water.
    waterway : Waterway, optional
        Where the ship is instead of the model's own canal.
    at : float or sequence of float [m]
        Along it: the section that the regulator is made for; of several, rising, each is held from its place on.
    **values : float [SI]
        As for ``linearize``.

    Raises
    ------
    InputError
        Where no rudder holds the ship on a line, its rudder turns nothing, or both ``y`` and ``at`` are several.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, for weights and integrals; Åström and Hägglund
    (2006), Advanced PID Control, for the back-calculation.
    """
    check_rudder(model)
    about = partial(linearize, model, u=u, waterway=waterway, surge="held", **values)
    if isinstance(at, Sequence | np.ndarray):
        if np.ndim(y):
            raise InputError("a line that changes in time and gains that change along the way are two; give one")
        lines = [held_line(model, about(y=y, at=place), place) for place in at]
    else:
        lines = [held_line(model, about(y=offset, at=at), start) for start, offset in _pairs(y)]
    time = model.configuration.ship.length / u
    return Regulator(tuple(lines), u, LEAD_TIME * time, UNWINDING_TIME * time, along=np.ndim(at) > 0)


def _pairs(y: Any) -> list[tuple[float, float]]:
    if np.ndim(y) == 0:
        return [(0.0, y)]
    try:
        return [(float(time), float(offset)) for time, offset in y]
    except (TypeError, ValueError):
        raise InputError("the line to hold is an offset [m], or pairs of time [s] and offset; mend it") from None


def held_line(model: Model, linear: LinearSystem, start: float = 0.0) -> HeldLine:
    course = {name: float(value) for name, value in linear.course.items()}
    limit = model.configuration.gear.limit
    if not abs(course["rudder"]) <= limit:
        raise InputError(
            f"no rudder to {math.degrees(limit):g} degrees holds this ship {course['y']:g} m off the middle at "
            f"{course['u']:g} m/s; choose a place nearer to it"
        )
    straight, turning = _straight(linear, course)
    return HeldLine(course["y"], regulator_gains(model, linear), *straight, turning, start)


def _straight(
    linear: LinearSystem, course: dict[str, float]
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Rudder, heading and sway velocity of the course without its bend, and what a yaw rate adds to each."""
    A, b = linear.A, linear.B[:, linear.controls.index("rudder")]
    rates = [linear.states.index(name) for name in ("y", "v", "r")]
    columns = [A[rates, linear.states.index("psi")], A[rates, linear.states.index("v")], b[rates]]
    psi, v, rudder = np.linalg.solve(np.stack(columns, axis=1), -A[rates, linear.states.index("r")])
    r = course["r"]
    straight = course["rudder"] - rudder * r, course["psi"] - psi * r, course["v"] - v * r
    return straight, (float(psi), float(v), float(rudder))


def regulator_gains(model: Model, linear: LinearSystem) -> tuple[Any, ...]:
    """Return the gains of a regulator for what ``FELT`` names, [rad/(s m), 1/s, rad/m, 1, 1/s, rad/(s2 m)]."""
    # The gains are made as if the bank's force did not change with the distance: tests determine its slope worst, and
    # gains that trust it lose twice as many ships. They are judged on the ship with its bank, and on ships of
    # coefficients drawn from the covariance: the calmest helm of the ladder that holds nearly all of them by the linear
    # theory, or the one that holds most.
    known = sampled(model, DRAWN_SHIPS, 0) if model.covariance is not None else {}
    A, B = linear.drawn({name: column.to_numpy() for name, column in known.items()}) if known else (linear.A, linear.B)
    ships, (blind, push) = rate_driven(linear, A, B)[0], rate_driven(linear, bank=False)
    best: tuple[float, np.ndarray] | None = None
    for heading, rudder in WEIGHT_LADDER:
        gains = _riccati(model, float(linear.course["u"]), blind, push, heading, rudder)
        if gains is None or not _settles(rate_driven(linear)[0] - np.outer(push, gains)).all():
            continue
        share = float(_settles(ships - np.multiply.outer(push, gains)).mean())
        if best is None or share > best[0]:
            best = share, gains
        if share >= HELD_SHARE:
            break
    if best is None:
        y, u = float(linear.course["y"]), float(linear.course["u"])
        raise InputError(
            f"no regulator holds this ship {y:g} m off the middle at {u:g} m/s: its rudder turns nothing there"
        )
    return tuple(best[1].tolist())


def _settles(closed: np.ndarray) -> np.ndarray:
    """Whether what is off dies out; where nothing stabilises a ship, some releases of SciPy give rounding."""
    poles = np.linalg.eigvals(closed)
    return np.asarray(poles.real.max(axis=-1) < -LEAST_DECAY * np.abs(poles).max(axis=-1))


def _riccati(
    model: Model, speed: float, A: np.ndarray, b: np.ndarray, heading: float, rudder: float
) -> np.ndarray | None:  # fmt: skip
    """The gains that weigh everything alike; None where nothing stabilises the ship."""
    from scipy.linalg import LinAlgError, solve_continuous_are

    ship, gear = model.configuration.ship, model.configuration.gear
    time = ship.length / speed
    # Each state in what weighs as much as the others, and time in ship lengths: the equation is of size 1.
    size = np.array([ship.beam / 2, heading, speed, speed / ship.length, rudder, ship.beam / 2 * INTEGRAL_TIME * time])
    rate = min(rudder / (STROKE_TIME * time), gear.rate)
    push = time * b * rate / size
    try:
        cost = solve_continuous_are(time * A * size / size[:, None], push[:, None], WEIGHTS, np.eye(1))
    except (LinAlgError, ValueError):
        return None
    return np.asarray(push @ cost * rate / size)


def rate_driven(
    linear: LinearSystem, A: np.ndarray | None = None, B: np.ndarray | None = None, *, bank: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Return the system of ``FELT`` whose one input is the rate of the rudder: matrices (..., 6, 6) and (6,)."""
    A, B = (linear.A if A is None else A), (linear.B if B is None else B)
    driven, b = np.zeros((*A.shape[:-2], len(FELT), len(FELT))), np.zeros(len(FELT))
    driven[..., :4, :4] = A
    driven[..., :4, 4] = B[..., linear.controls.index("rudder")]
    driven[..., 5, 0], b[4] = 1.0, 1.0
    driven[..., :4, 0] *= bank
    return driven, b
