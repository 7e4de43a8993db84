"""A course-keeping autopilot: the best linear one for the ship on the centreline, with the gear that the ship has."""

import math

import numpy as np

from narrows.codegen.linearisation import LINEARISED
from narrows.control.settings import LEAST_DECAY_OF_PILOT, OFF_HEADING, OFF_RUDDER
from narrows.control.steady_course import check_inside, check_rudder, self_propulsion, solved
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.controllers import Autopilot
from narrows.simulation.ship import SimulatedShip

FELT = ("y", "psi", "v", "r")
IN_VAIN = "no autopilot holds this ship on the centreline: its rudder turns nothing"


def track_pilot(model: Model, y: float, u: float, **values: float) -> Autopilot:
    """Return the autopilot that holds a ship at an offset, about the rudder and drift that hold it there.

    Parameters
    ----------
    model : Model
        With terms of a rudder.
    y : float [m]
        To starboard of the middle.
    u : float [m/s]
        Surge velocity.
    **values : float [SI]
        Particulars and coefficients other than the model's, as in ``ensemble``.

    Raises
    ------
    InputError
        Where no rudder holds it there, or no autopilot on the centreline.
    """
    check_rudder(model)
    check_inside(y, model.configuration.canal.width, model.configuration.ship.beam)
    ship, limit = SimulatedShip(model), model.configuration.gear.limit
    propulsion = {"revolutions": self_propulsion(model, u)} if "revolutions" in model.terms.inputs else {}
    (v,), (rudder,) = solved(ship, {"y": y, "u": u, **propulsion, **values}, 1, 1)
    if not abs(rudder) <= limit:
        raise InputError(
            f"no rudder to {math.degrees(limit):g} degrees holds this ship {y:g} m off the middle at {u:g} m/s; choose "
            "a place nearer to it"
        )
    gains = track_gains(ship, u, **propulsion, **values)
    by_y, by_psi, by_v, by_r = gains.tolist()
    return Autopilot(y, (by_y, by_psi, by_v, by_r), float(rudder), -math.atan(v / u), float(v))


def track_gains(ship: SimulatedShip, speed: float, **values: float) -> np.ndarray:
    """Return the rudder for offset, heading, sway velocity and yaw rate off: [rad/m, 1, rad s/m, s]."""
    # Linear-quadratic, by Bryson's rule. Bryson and Ho (1975), Applied optimal control, section 5.2.
    from scipy.linalg import LinAlgError, solve_continuous_are

    inputs = {**ship.values(), **values}
    linear = ship.linearisation(inputs)
    at = {"u": speed, "revolutions": inputs.get("revolutions", 0.0)}
    indices = [LINEARISED.index(name) for name in FELT]
    motion = linear.state(at)[np.ix_(indices, indices)]
    push = linear.controls(at)[indices][:, [linear.controlled.index("rudder")]]
    half_beam = ship.model.configuration.ship.beam / 2
    weights = np.diag([half_beam**-2, OFF_HEADING**-2, 0.0, 0.0])
    try:
        cost = solve_continuous_are(motion, push, weights, np.array([[OFF_RUDDER**-2]]))
    except (LinAlgError, ValueError):
        raise InputError(IN_VAIN) from None
    gains = np.asarray(OFF_RUDDER**2 * (push.T @ cost)[0])
    # Where nothing stabilises it, SciPy gives an error or a matrix of rounding, by its release.
    poles = np.linalg.eigvals(motion - push * gains)
    if not poles.real.max() < -LEAST_DECAY_OF_PILOT * np.abs(poles).max():
        raise InputError(IN_VAIN)
    return gains
