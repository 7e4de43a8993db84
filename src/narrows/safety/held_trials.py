"""Trials of a helm: ships thrown off their steady courses, at every offset, speed and sample at once."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from narrows.control.self_propulsion import with_propulsion
from narrows.control.steady_course import solved
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.progress import bar
from narrows.safety.disturbance import Disturbance
from narrows.safety.question import Walls
from narrows.safety.trial_helms import REGULATOR, TrialHelm, Watched, trial_helm
from narrows.simulation.grid import Grid, grid_of
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import MEMORY, PARAMETER, steering_of

LENGTHS, LATE = 15.0, 3.0
"""Ship lengths that a trial lasts after a gust, and the last of them, through which the ship is to be back."""
STEPS_A_LENGTH = 40
BLOCK = 65_536
MOST = 50_000_000
"""Points of one call: beyond it the answer does not fit in memory."""
KEPT = ("rudder", "held")
OF_THE_HELM = "helm_"


def trials(
    model: Model, y: np.ndarray, u: np.ndarray, heave: np.ndarray, disturbance: Disturbance, samples: int, seed: int,
    walls: Walls = (math.inf, math.inf), workers: int | None = None, progress: bool = False,
    controller: str = REGULATOR,
) -> xr.Dataset:  # fmt: skip
    """Hold a ship at offsets and speeds against disturbances, its coefficients drawn where their covariance is known.

    Every sample starts from the steady course that its own coefficients ask for, and is thrown off it. A ship is held
    where it touches no bank, stays within 85 degrees of the canal, and is back within half a beam of its line for the
    last three ship lengths of the trial (ours).

    Parameters
    ----------
    model : Model
        With terms of a rudder.
    y : array (offsets,) [m]
        To hold.
    u : array (speeds,) [m/s]
        Held.
    heave : array (speeds,) [m]
        Midship sinkage at each speed.
    disturbance : Disturbance
        What throws the ship off.
    samples : int
        Of coefficients and disturbance.
    seed : int
        Of the samples.
    walls : pair of float [m]
        Where the keel meets the banks, to port and to starboard of the middle, if nearer than the walls of the canal.
    workers : int, optional
        Threads; all cores unless given.
    progress : bool
        Show a bar.
    controller : str
        The helm: ``regulator``, or ``track`` for the track pilot without an integral.

    Returns
    -------
    xarray.Dataset
        Over y, u and sample: ``rudder`` [rad] of the steady course (NaN where there is none), and ``held``.

    Raises
    ------
    InputError
        Where the model has no rudder, there is no sample, there are more points than fit, or no helm of that name holds
        the ship.
    """
    if samples * len(y) * len(u) > MOST:
        points = samples * len(y) * len(u)
        raise InputError(f"{points} points are more than {MOST}; take fewer samples, offsets or speeds")
    ship = SimulatedShip(model)
    drawn = samples if model.covariance is not None else 0
    thrown = disturbance.drawn(samples, seed)
    along = xr.DataArray(np.zeros(samples), dims="sample")
    steady = {"y": y, "u": u, "heave": xr.DataArray(heave, dims="u"), "x": along}
    grid = grid_of(model, with_propulsion(model, steady), drawn, seed)
    helm = trial_helm(controller, ship, grid, y, u)
    # Off to the other side on the other side of the middle: a canal that mirrors itself gets an answer that does.
    side = xr.DataArray(np.where(np.asarray(y) < 0, -1.0, 1.0), dims="y")
    extra = {f"off_{name}": side * column for name, column in thrown.items()}
    extra |= {f"{OF_THE_HELM}{name}": column for name, column in helm.numbers.items()}
    whole = Grid({**grid.values, **extra}, grid.sizes)
    kept = {name: np.empty(tuple(grid.sizes.values())) for name in KEPT}
    with bar(grid.vessels, progress) as advance:
        for block in whole.blocks(BLOCK):
            values, shape = whole.flat(block)
            sailed = _sailed(ship, helm, values, math.prod(shape), disturbance.gust_time, walls, workers)
            for name, column in sailed.items():
                kept[name][whole.region(block)] = column.reshape(shape)
            advance(math.prod(shape))
    data = {name: (list(grid.sizes), column) for name, column in kept.items()}
    tried = xr.Dataset(data, coords={"y": y, "u": u}).transpose("y", "u", "sample")
    return tried.assign(held=tried["held"] > 0)


def _sailed(
    ship: SimulatedShip, helm: TrialHelm, values: Mapping[str, Any], count: int, gust_time: float, walls: Walls,
    workers: int | None,
) -> dict[str, np.ndarray]:  # fmt: skip
    extra = {name: value for name, value in values.items() if name.startswith(("off_", OF_THE_HELM))}
    course = {name: value for name, value in values.items() if name not in extra}
    v, rudder = solved(ship, course, count, workers)
    hull, gear = ship.model.configuration.ship, ship.model.configuration.gear
    steady = np.abs(rudder) <= gear.limit  # false where there is none
    hold = {"v": np.where(steady, v, 0.0), "rudder": np.where(steady, rudder, 0.0), "y": course["y"]}
    hold["psi"] = -np.arctan(hold["v"] / course["u"])
    pace = hull.length / (STEPS_A_LENGTH * np.asarray(course["u"]))
    gusty = gust_time if np.any(extra["off_Y"]) else 0.0
    # No course to hold: no steps are sailed.
    steps = np.where(steady, np.ceil(gusty / pace) + LENGTHS * STEPS_A_LENGTH, 0)
    law = {"watched_y": hold["y"], "late_from": (steps - LATE * STEPS_A_LENGTH) * pace}
    law |= {called: hold[name] for name, called in helm.line.items()}
    law |= {name: extra[f"{OF_THE_HELM}{name}"] for name in helm.numbers}
    push = {"X": 0.0, "Y": extra["off_Y"], "N": extra["off_N"], "push_end": gusty} if gusty else {}
    half = np.asarray(course["width"]) / 2
    inputs = {
        **course, **push, **{PARAMETER(name): value for name, value in law.items()}, "rudder": hold["rudder"],
        "y": course["y"] + extra["off_y"], "v": hold["v"], "psi": hold["psi"] + extra["off_psi"],
        "wall_port": np.minimum(walls[0], half), "wall_starboard": np.minimum(walls[1], half),
    }  # fmt: skip
    steering = steering_of(Watched(helm.law), ship.actuators)
    run = KernelRun(ship, steps * pace, pace, steering=steering)
    prepared = run.prepared(inputs, count, workers)
    prepared()
    ended = run.ended(prepared, inputs)
    late = np.maximum(ended[f"{MEMORY('farthest')}_end"], np.abs(ended["y_end"] - course["y"]))
    held = steady & (ended["outcome"] == Code.AFLOAT) & (late <= hull.beam / 2)
    return {"rudder": rudder, "held": held}
