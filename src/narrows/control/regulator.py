"""Linear-quadratic regulator (LQR) and autopilot: gains of the rudder by the Riccati equation of the linear ship."""

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.aliases import accept_aliases
from narrows.codegen.linearisation import LINEARISED
from narrows.control.linear_system import LinearSystem
from narrows.control.linearization import linearize
from narrows.control.regulator_gains import DEFAULT_WEIGHTS, RegulatorWeights, best_gains, regulator_gains
from narrows.control.regulator_law import HeldLine, Regulator
from narrows.control.settings import LEAD_TIME, OFF_HEADING, OFF_RUDDER
from narrows.control.steady_course import check_holds, check_inside, check_rudder, solved
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.controllers import Autopilot
from narrows.simulation.self_propulsion import self_propulsion
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


@accept_aliases
def regulator(
    model: Model, y: Any, u: float, *, waterway: "Waterway | None" = None,
    at: float | Sequence[float] = 0.0, weights: RegulatorWeights = DEFAULT_WEIGHTS, **values: float,
) -> Regulator:  # fmt: skip
    """Return the regulator that holds a ship on a line: linear-quadratic on the rudder's rate.

    ``weights`` holds the weights: defaults tuned by simulated voyages, or those of ``design``. The law needs the sway
    velocity, as a track pilot with a good position fix has it.

    Parameters
    ----------
    model : Model
        A model with terms of a rudder.
    y : float or pairs (time [s], offset [m])
        Offset to starboard of the canal's centreline or of the waterway's line; each pair holds from its time on.
    u : float [m/s]
        Surge velocity through the water.
    waterway : Waterway, optional
        Waterway instead of the model's own canal.
    at : float or sequence of float [m]
        Place along it for which the gains are computed; with several, rising, each holds from its place on.
    weights : RegulatorWeights
        Weights of the cost.
    **values : float [SI]
        As for ``linearize``.

    Raises
    ------
    InputError
        If no rudder angle holds the ship on a line, its rudder has no effect, or both ``y`` and ``at`` are several.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, for weights and integrals; Åström and Hägglund
    (2006), Advanced PID Control, for the back-calculation.
    """
    check_rudder(model)
    about = partial(linearize, model, u=u, waterway=waterway, surge="held", **values)
    if isinstance(at, Sequence | np.ndarray):
        if np.ndim(y):
            raise InputError("y changes in time and the gains change along the way; give one of the two")
        lines = [held_line(model, about(y=y, at=place), place, weights) for place in at]
    else:
        lines = [held_line(model, about(y=offset, at=at), start, weights) for start, offset in _pairs(y)]
    time = model.configuration.ship.length / u
    return Regulator(tuple(lines), u, LEAD_TIME * time, weights.unwinding_time * time, along=np.ndim(at) > 0)


def _pairs(y: Any) -> list[tuple[float, float]]:
    if np.ndim(y) == 0:
        return [(0.0, y)]
    try:
        return [(float(time), float(offset)) for time, offset in y]
    except (TypeError, ValueError):
        raise InputError("the line to hold is an offset [m], or pairs of time [s] and offset; mend it") from None


def held_line(
    model: Model, linear: LinearSystem, start: float = 0.0, weights: RegulatorWeights = DEFAULT_WEIGHTS
) -> HeldLine:  # fmt: skip
    course = {name: float(value) for name, value in linear.course.items()}
    check_holds(model, course["rudder"], course["y"], course["u"])
    straight, turning = _straight(linear, course)
    return HeldLine(course["y"], regulator_gains(model, linear, weights), *straight, turning, start)


def _straight(
    linear: LinearSystem, course: dict[str, float]
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Rudder, heading and sway velocity of the straight course, and the change of each per yaw rate."""
    A, b = linear.A, linear.B[:, linear.controls.index("rudder")]
    rates = [linear.states.index(name) for name in ("y", "v", "r")]
    columns = [A[rates, linear.states.index("psi")], A[rates, linear.states.index("v")], b[rates]]
    psi, v, rudder = np.linalg.solve(np.stack(columns, axis=1), -A[rates, linear.states.index("r")])
    r = course["r"]
    straight = course["rudder"] - rudder * r, course["psi"] - psi * r, course["v"] - v * r
    return straight, (float(psi), float(v), float(rudder))


TRACKED = ("y", "psi", "v", "r")
IN_VAIN = "no autopilot holds this ship on the centreline: its rudder has no effect"


def track_pilot(model: Model, y: float, u: float, **values: float) -> Autopilot:
    """Return the autopilot that holds a ship at an offset, about the rudder and drift of the steady course.

    Parameters
    ----------
    model : Model
        A model with terms of a rudder.
    y : float [m]
        Offset to starboard of the centreline.
    u : float [m/s]
        Surge velocity.
    **values : float [SI]
        Particulars and coefficients other than the model's, as in ``ensemble``.

    Raises
    ------
    InputError
        If no rudder angle holds it there, or no autopilot on the centreline.

    Examples
    --------
    >>> nw.track_pilot(kcs, y=0.0, u=6.0).y
    0.0
    """
    check_rudder(model)
    check_inside(y, model.configuration.canal.width, model.configuration.ship.beam)
    ship = SimulatedShip(model)
    propulsion = {"revolutions": self_propulsion(model, u)} if "revolutions" in model.terms.inputs else {}
    (v,), (rudder,) = solved(ship, {"y": y, "u": u, **propulsion, **values}, 1, 1)
    check_holds(model, rudder, y, u)
    by_y, by_psi, by_v, by_r = track_gains(ship, u, **propulsion, **values).tolist()
    return Autopilot(y, (by_y, by_psi, by_v, by_r), float(rudder), -math.atan(v / u), float(v))


def track_gains(ship: SimulatedShip, speed: float, **values: float) -> np.ndarray:
    """Return the rudder per deviation of offset, heading, sway velocity and yaw rate: [rad/m, 1, rad s/m, s]."""
    # Linear-quadratic, by Bryson's rule. Bryson and Ho (1975), Applied optimal control, section 5.2.
    inputs = {**ship.values(), **values}
    linear = ship.linearisation(inputs)
    at = {"u": speed, "revolutions": inputs.get("revolutions", 0.0)}
    indices = [LINEARISED.index(name) for name in TRACKED]
    motion = linear.state(at)[np.ix_(indices, indices)]
    push = OFF_RUDDER * linear.controls(at)[indices, linear.controlled.index("rudder")]
    half_beam = ship.model.configuration.ship.beam / 2
    weights = np.diag([half_beam**-2, OFF_HEADING**-2, 0.0, 0.0])
    gains = np.asarray(OFF_RUDDER * best_gains(motion[None], push[None], weights)[0])
    if not np.isfinite(gains).all():
        raise InputError(IN_VAIN)
    return gains
