"""The motion of one ship at a moment: its rates, and a single step, from the engine's own lines."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from narrows.codegen.free_motion import INPUTS, STATE, Surge
from narrows.errors import InputError, did_you_mean, shown
from narrows.model.model import Model
from narrows.quantities.names import FORCES, Number
from narrows.simulation.departure import POSE, check_positions, departure
from narrows.simulation.inputs import finite_numbers
from narrows.simulation.ship import SimulatedShip

OF_SHIP = ("surge", "surge_inertia", "coriolis")


def derivative(
    model: Model, state: Any, *, X: Number = 0.0, Y: Number = 0.0, N: Number = 0.0, surge: Surge = "held",
    surge_inertia: float | None = None, coriolis: bool = False, **positions: Number,
) -> np.ndarray:  # fmt: skip
    """Return the rates of x, y, psi, u, v, r of the free ship, from the engine's own lines.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    state : sequence of six numbers, or mapping of str to number
        x, y [m], psi [rad], u, v [m/s], r [rad/s]; floats or columns. What a mapping leaves out is 0.
    X, Y : number [N]
        Surge and sway force from elsewhere.
    N : number [N m]
        Yaw moment from elsewhere.
    surge : str
        ``held``: the speed stays; ``free``: it changes.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force.
    **positions : number
        Of actuators, by their names: rudder [rad], revolutions [1/s]; at rest unless given.

    Returns
    -------
    array (6, ...)
        Rates of x, y [m/s], psi [rad/s], u, v [m/s2], r [rad/s2].

    Raises
    ------
    InputError
        Where the state is not of six numbers, or an actuator is unknown.
    """
    ship = SimulatedShip(model, surge, surge_inertia, coriolis)
    check_positions(positions, ship)
    x, y, psi, u, v, r = (np.asarray(value, float) for value in state_of(state).values())
    system = ship.system(pushed="always")
    pushes = dict(zip(INPUTS.values(), (X, Y, N), strict=True))
    values = {**ship.values(**positions), **pushes}
    constants = {**values, **system.constants(values)}
    inputs = (constants[name] for name in system.columns.RATES_INPUTS)
    found = system.columns.rates(x, y, np.cos(psi), np.sin(psi), u, v, r, *inputs)
    rates = dict(zip(STATE, found, strict=True)) | {"psi": r}
    return np.stack(np.broadcast_arrays(*(rates[name] for name in POSE)))


def step(model: Model, state: Any, dt: float, **given: Any) -> np.ndarray:
    """Return x, y, psi, u, v, r one step of the engine later: Runge and Kutta's of order 4.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    state : sequence of six numbers, or mapping of str to number
        As for ``derivative``, but floats.
    dt : float [s]
        Length of the step.
    **given : Any
        As for ``derivative``.

    Returns
    -------
    array (6,)
        As the state.

    Raises
    ------
    InputError
        Where the state is not of six numbers, the hull is in a bank, or an actuator is unknown.
    """
    numbers = state_of(state)
    options = {name: given.pop(name) for name in OF_SHIP if name in given}
    pushes = {INPUTS[force]: given.pop(force, 0.0) for force in FORCES}
    ship = SimulatedShip(model, **options)
    check_positions(given, ship)
    known = finite_numbers(**numbers, **given)
    finite_numbers(**pushes, dt=dt)
    march, start = departure(ship, None, known, None, any(pushes.values()))
    march.set(**pushes)
    x, y, cosine, sine, *velocities = march.stepped(start, dt)[0][: len(STATE)]
    before = start[STATE.index("cos_psi")], start[STATE.index("sin_psi")]
    turned = math.atan2(sine * before[0] - cosine * before[1], cosine * before[0] + sine * before[1])
    return np.array([x, y, known["psi"] + turned, *velocities])


def state_of(state: Any) -> dict[str, Number]:
    """Return a state by names, in their order."""
    # state [m]
    if isinstance(state, Mapping):
        for name in state:
            if name not in POSE:
                raise InputError(f"a state has no {name!r}{did_you_mean(str(name), POSE)}")
        return {name: state.get(name, 0.0) for name in POSE}
    if np.ndim(state) == 0 or len(state) != len(POSE):
        raise InputError(f"state = {shown(state)} is not {', '.join(POSE)}; give these six, or some of them by name")
    return dict(zip(POSE, state, strict=True))
