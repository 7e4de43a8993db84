"""The rudder and the drift that hold a ship at an offset: steady, straight along the canal, every force in balance."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from narrows.compile.fleet import on_all_cores
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.safety.propulsion import with_propulsion
from narrows.ship.actuators import RUDDER
from narrows.simulation.grid import INPUTS, grid_of
from narrows.simulation.ship import SimulatedShip

SOUGHT = ("x", "psi", "v", "r", "rudder", "X")
"""What a steady course answers or does not feel."""
ROUNDS = 40
SMALL = 1e-7
"""Step of the central differences, in drift over speed [1] and in the rudder's angle [rad]."""
DONE = 1e-11
FURTHEST = 1.2
"""Beyond this size of drift over speed, or of rudder angle [rad], nothing is looked for."""
LARGEST = 0.25
"""Step of the search."""

Residual = Callable[[np.ndarray, np.ndarray, slice | np.ndarray], tuple[np.ndarray, np.ndarray]]


def steady_course(
    model: Model, *, samples: int = 0, seed: int = 0, workers: int | None = None, **vary: Any
) -> xr.Dataset:  # fmt: skip
    """Find the rudder, heading and drift that hold a ship steady on a straight course along the canal (ours).

    The speed is held; a propeller turns as the speed asks straight ahead. Where no angle below 69 degrees holds her,
    there is no such course: the answer is NaN.

    Parameters
    ----------
    model : Model
        With terms of a rudder.
    samples : int
        Of the coefficients, from the fit's covariance: a dimension ``sample``.
    seed : int
        Of the samples.
    workers : int, optional
        Threads; all cores unless given.
    **vary : number, sequence or DataArray
        As in ``ensemble``: y [m], u [m/s], heave [m], Y [N], N [N m], particulars, coefficients.

    Returns
    -------
    xarray.Dataset
        ``rudder`` [rad], ``psi`` [rad] and ``v`` [m/s] over the dimensions of what varies.

    Raises
    ------
    InputError
        Where the model has no terms of a rudder, a value does not fit, or what is given is what is sought.
    """
    check_rudder(model)
    for name in SOUGHT:
        if name in vary:
            raise InputError(f"a steady course does not take {name!r}: it is sought, or plays no part; leave it out")
    ship, grid = SimulatedShip(model), grid_of(model, with_propulsion(model, {"u": 1.0, **vary}), samples, seed)
    check_inside(grid.values["y"], grid.values["width"], grid.values["beam"])
    if not (grid.values["u"] > 0).all():
        raise InputError("a steady course needs a speed over 0; give u in m/s")
    values, shape = grid.flat(slice(0, grid.sizes[grid.axis]))
    v, rudder = solved(ship, values, grid.vessels, workers)
    psi = -np.arctan(v / values["u"])
    columns = {"rudder": (rudder, "rad"), "psi": (psi, "rad"), "v": (v, "m/s")}
    data = {name: (list(grid.sizes), c.reshape(shape), {"units": unit}) for name, (c, unit) in columns.items()}
    found = xr.Dataset(data, coords=grid.coordinates())
    return found.squeeze("vessel") if list(grid.sizes) == ["vessel"] else found


def check_rudder(model: Model) -> None:
    """Raise where a model cannot be steered (ours).

    Parameters
    ----------
    model : Model
        The model.

    Raises
    ------
    InputError
        Where it has no terms of a rudder.
    """
    if RUDDER not in model.terms.actuators:
        raise InputError(
            "this model has no terms of a rudder; identify it with the terms steered, or borrow a rudder from one"
        )


def check_inside(y: Any, width: Any, beam: Any) -> None:
    """Raise where a hull beside her line is in a bank (ours).

    Parameters
    ----------
    y : array [m]
        From the middle.
    width, beam : array [m]
        Of canal and ship.

    Raises
    ------
    InputError
        Names the farthest offset.
    """
    if not np.all(np.abs(y) < (width - beam) / 2):
        far, room = float(np.abs(y).max()), float(np.min((width - beam) / 2))
        raise InputError(f"an offset of {far:g} m has the hull in the bank; stay within {room:.4g} m of the middle")


def solved(
    ship: SimulatedShip, values: Mapping[str, Any], count: int, workers: int | None
) -> tuple[np.ndarray, np.ndarray]:
    """Solve for the sway velocity [m/s] and the rudder angle [rad] of many steady courses (ours).

    Parameters
    ----------
    ship : SimulatedShip
        The model.
    values : mapping of str to float or array (count,)
        As ``Grid.flat`` gives them.
    count : int
        How many.
    workers : int, optional
        Threads.
    """
    v, rudder = np.empty(count), np.empty(count)

    def run(rows: slice) -> None:
        part = {name: value[rows] if np.size(value) > 1 else value for name, value in values.items()}
        drift, angle = _newton(_residual(ship, part), rows.stop - rows.start)
        v[rows], rudder[rows] = drift * np.broadcast_to(part["u"], drift.shape), angle

    on_all_cores(run, count, workers)
    return v, rudder


def _residual(ship: SimulatedShip, values: Mapping[str, Any]) -> Residual:
    """Accelerations in sway and yaw, by the drift (v over u) and the rudder's angle of some of the vessels."""
    given = {**dict.fromkeys(INPUTS, 0.0), "revolutions": 0.0, **ship.values(), **values}
    constants = ship.program.constants(given)

    def residual(drift: np.ndarray, angle: np.ndarray, rows: slice | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        def own(value: Any) -> Any:
            return value[rows] if np.size(value) > 1 else value

        cosine = 1 / np.sqrt(1 + drift * drift)
        u = own(given["u"])
        state = (0.0, own(given["y"]), cosine, -drift * cosine, u, drift * u, 0.0)
        controls = (*(own(given[name]) for name in INPUTS), np.cos(angle), np.sin(angle), own(given["revolutions"]))
        rate = ship.program.rhs(*state, *controls, *map(own, constants))
        return rate[5], rate[6]

    return residual


def _newton(residual: Residual, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Newton's method from a straight course and the rudder amidships, in steps that are not too long."""
    z = np.zeros((2, count))
    left, done = np.arange(count), np.zeros(count, bool)
    with np.errstate(all="ignore"):
        for _ in range(ROUNDS):
            step = _step(residual, z[:, left], left)
            z[:, left] += np.clip(step, -LARGEST, LARGEST)
            near = np.abs(step).max(axis=0) < DONE
            lost = ~(np.abs(z[:, left]).max(axis=0) < FURTHEST)
            done[left[near & ~lost]] = True
            left = left[~(near | lost)]
            if not left.size:
                break
    z[:, ~done] = math.nan
    return z[0], z[1]


def _step(residual: Residual, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
    drift, angle = z
    a, b = residual(drift, angle, rows)
    slopes = []
    for move in ((SMALL, 0.0), (0.0, SMALL)):
        ahead = residual(drift + move[0], angle + move[1], rows)
        behind = residual(drift - move[0], angle - move[1], rows)
        slopes.append([(p - q) / (2 * SMALL) for p, q in zip(ahead, behind, strict=True)])
    (a_drift, b_drift), (a_angle, b_angle) = slopes
    determinant = a_drift * b_angle - a_angle * b_drift
    return np.asarray([(a_angle * b - b_angle * a) / determinant, (b_drift * a - a_drift * b) / determinant])
