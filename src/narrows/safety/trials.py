"""Trials of an autopilot: ships thrown off their steady courses, at every offset, speed and draw at once."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from narrows.compile import Outcome
from narrows.errors import InputError
from narrows.model import Model
from narrows.safety.autopilot import track_gains
from narrows.safety.disturbance import Disturbance
from narrows.safety.equilibrium import solved
from narrows.simulation.fleets import bar
from narrows.simulation.grid import Grid, grid_of
from narrows.simulation.ship import SimulatedShip

LENGTHS = 15.0
"""Ship lengths that a trial lasts."""
STEPS_A_LENGTH = 40
BLOCK = 65_536
KEPT = ("rudder", "psi", "held", "farthest", "most_rudder")


def trials(
    model: Model, y: np.ndarray, u: np.ndarray, heave: np.ndarray, disturbance: Disturbance, draws: int, seed: int,
    workers: int | None = None, progress: bool = False,
) -> xr.Dataset:  # fmt: skip
    """Hold a ship at offsets and speeds against disturbances, her coefficients drawn where their covariance is known.

    Every draw starts from the steady course that its own coefficients ask for, and is thrown off it. She is held where
    she touches no bank, stays within 85 degrees of the canal, and ends within half a beam of her line (ours).

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
        What throws her off.
    draws : int
        Of coefficients and disturbance.
    seed : int
        Of the draws.
    workers : int, optional
        Threads; all cores unless given.
    progress : bool
        Show a bar.

    Returns
    -------
    xarray.Dataset
        Over y, u and draw: ``rudder`` [rad] and ``psi`` [rad] of the steady course (NaN where there is none), ``held``,
        ``farthest`` [m] off her line, ``most_rudder`` [rad].

    Raises
    ------
    InputError
        Where the model has no rudder, or there is no draw.
    """
    if draws < 1:
        raise InputError(f"draws = {draws}: a trial needs one disturbance at least")
    ship = SimulatedShip(model)
    drawn = draws if model.covariance is not None else 0
    thrown = disturbance.drawn(draws, seed)
    steady = {"y": y, "u": u, "heave": xr.DataArray(heave, dims="u"), "x": xr.DataArray(np.zeros(draws), dims="draw")}
    grid = grid_of(model, steady, drawn, seed)
    gains = np.array([track_gains(ship, float(speed), heave=float(z)) for speed, z in zip(u, heave, strict=True)])
    extra = {f"off_{name}": column for name, column in thrown.items()}
    extra |= {f"by_{i}": xr.DataArray(gains[:, i], dims="u") for i in range(4)}
    whole = Grid({**grid.values, **extra}, grid.sizes)
    kept = {name: np.empty(tuple(grid.sizes.values())) for name in KEPT}
    with bar(grid.vessels, progress) as advance:
        for block in whole.blocks(BLOCK):
            values, shape = whole.flat(block)
            for name, column in _sailed(ship, values, math.prod(shape), disturbance, workers).items():
                kept[name][whole.region(block)] = column.reshape(shape)
            advance(math.prod(shape))
    data = {name: (list(grid.sizes), column) for name, column in kept.items()}
    found = xr.Dataset(data, coords={"y": y, "u": u}).transpose("y", "u", "draw")
    return found.assign(held=found["held"] > 0)


def _sailed(
    ship: SimulatedShip, values: Mapping[str, Any], count: int, disturbance: Disturbance, workers: int | None
) -> dict[str, np.ndarray]:
    extra = {name: value for name, value in values.items() if name.startswith(("off_", "by_"))}
    own = {name: value for name, value in values.items() if name not in extra}
    v, rudder = solved(ship, own, count, workers)
    psi = -np.arctan(v / own["u"])
    gear, setting = ship.model.setting.gear, ship.model.setting
    limit = gear.limit
    steady = np.isfinite(rudder) & (np.abs(rudder) <= limit)
    hold = {"y": own["y"], "psi": np.nan_to_num(psi), "v": np.nan_to_num(v), "rudder": np.nan_to_num(rudder)}
    pilot = {f"hold_{name}": value for name, value in hold.items()} | {
        "by_y": extra["by_0"], "by_psi": extra["by_1"], "by_v": extra["by_2"], "by_r": extra["by_3"],
        "limit": limit, "rate": gear.rate, "revolutions": ship.controls(0.0)[2],
        "push_Y": extra["off_Y"], "push_N": extra["off_N"], "push_time": disturbance.gust_time,
    }  # fmt: skip
    pace = setting.ship.length / (STEPS_A_LENGTH * np.asarray(own["u"]))
    # No course to hold: no steps are sailed.
    steps = np.where(steady, LENGTHS * STEPS_A_LENGTH, 0)
    ended = ship.program.helmed(
        {**ship.values(), **own}, pilot, y=own["y"] + extra["off_y"], u=own["u"], v=hold["v"],
        psi=hold["psi"] + extra["off_psi"], dt=pace, steps=steps, workers=workers,
    )  # fmt: skip
    back = np.abs(ended.end) <= setting.ship.beam / 2
    held = steady & (ended.outcome == Outcome.AFLOAT) & back
    return {"rudder": rudder, "psi": psi, "held": held, "farthest": ended.farthest, "most_rudder": ended.rudder}
