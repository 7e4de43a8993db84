"""Trials of an autopilot: ships thrown off their steady courses, at every offset, speed and sample at once."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from narrows.compile import Outcome
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.safety.autopilot import track_gains
from narrows.safety.disturbance import Disturbance
from narrows.safety.equilibrium import solved
from narrows.safety.propulsion import with_propulsion
from narrows.simulation.grid import Grid, grid_of
from narrows.simulation.progress import bar
from narrows.simulation.ship import SimulatedShip

LENGTHS, LATE = 15.0, 3.0
"""Ship lengths that a trial lasts after a gust, and the last of them, through which she is to be back."""
STEPS_A_LENGTH = 40
BLOCK = 65_536
MOST = 50_000_000
"""Points of one call: beyond it the answer does not fit in memory."""
KEPT = ("rudder", "held")
Walls = tuple[float, float]
"""Where a keel meets the banks [m]: to port and to starboard of the middle."""


def trials(
    model: Model, y: np.ndarray, u: np.ndarray, heave: np.ndarray, disturbance: Disturbance, samples: int, seed: int,
    walls: Walls = (math.inf, math.inf), workers: int | None = None, progress: bool = False,
) -> xr.Dataset:  # fmt: skip
    """Hold a ship at offsets and speeds against disturbances, her coefficients drawn where their covariance is known.

    Every sample starts from the steady course that its own coefficients ask for, and is thrown off it. She is held
    where she touches no bank, stays within 85 degrees of the canal, and is back within half a beam of her line for the
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
        What throws her off.
    samples : int
        Of coefficients and disturbance.
    seed : int
        Of the samples.
    walls : pair of float [m]
        Where her keel meets the banks, to port and to starboard of the middle, if nearer than the walls of the canal.
    workers : int, optional
        Threads; all cores unless given.
    progress : bool
        Show a bar.

    Returns
    -------
    xarray.Dataset
        Over y, u and sample: ``rudder`` [rad] of the steady course (NaN where there is none), and ``held``.

    Raises
    ------
    InputError
        Where the model has no rudder, there is no sample, or there are more points than fit.
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
    gains = _gains(ship, grid, len(u))
    extra = {f"off_{name}": column for name, column in thrown.items()}
    extra |= {f"by_{i}": xr.DataArray(gains[:, i], dims="u") for i in range(4)}
    whole = Grid({**grid.values, **extra}, grid.sizes)
    kept = {name: np.empty(tuple(grid.sizes.values())) for name in KEPT}
    with bar(grid.vessels, progress) as advance:
        for block in whole.blocks(BLOCK):
            values, shape = whole.flat(block)
            for name, column in _sailed(ship, values, math.prod(shape), disturbance.gust_time, walls, workers).items():
                kept[name][whole.region(block)] = column.reshape(shape)
            advance(math.prod(shape))
    data = {name: (list(grid.sizes), column) for name, column in kept.items()}
    found = xr.Dataset(data, coords={"y": y, "u": u}).transpose("y", "u", "sample")
    return found.assign(held=found["held"] > 0)


def _gains(ship: SimulatedShip, grid: Grid, speeds: int) -> np.ndarray:
    """The gains at each speed, (speeds, 4)."""
    felt = [name for name in ("u", "heave", "revolutions") if name in grid.values]
    columns = {name: np.broadcast_to(grid.values[name].to_numpy(), speeds) for name in felt}
    rows = ({name: float(column[place]) for name, column in columns.items()} for place in range(speeds))
    return np.array([track_gains(ship, row.pop("u"), **row) for row in rows])


def _sailed(
    ship: SimulatedShip, values: Mapping[str, Any], count: int, gust_time: float, walls: Walls, workers: int | None
) -> dict[str, np.ndarray]:
    extra = {name: value for name, value in values.items() if name.startswith(("off_", "by_"))}
    own = {name: value for name, value in values.items() if name not in extra}
    v, rudder = solved(ship, own, count, workers)
    hull, gear = ship.model.configuration.ship, ship.model.configuration.gear
    steady = np.abs(rudder) <= gear.limit  # false where there is none
    hold = {"v": np.where(steady, v, 0.0), "rudder": np.where(steady, rudder, 0.0)}
    psi, pace = -np.arctan(hold["v"] / own["u"]), hull.length / (STEPS_A_LENGTH * np.asarray(own["u"]))
    gusty = gust_time if np.any(extra["off_Y"]) else 0.0
    pilot = {
        "hold_y": own["y"], "hold_psi": psi, "hold_v": hold["v"], "hold_rudder": hold["rudder"],
        "by_y": extra["by_0"], "by_psi": extra["by_1"], "by_v": extra["by_2"], "by_r": extra["by_3"],
        "limit": gear.limit, "rate": gear.rate, "revolutions": own.get("revolutions", 0.0),
        "push_Y": extra["off_Y"], "push_N": extra["off_N"], "push_time": gusty,
        "wall_port": walls[0], "wall_starboard": walls[1], "half_length": hull.length / 2, "half_beam": hull.beam / 2,
        "late": LATE * STEPS_A_LENGTH,
    }  # fmt: skip
    # No course to hold: no steps are sailed.
    steps = np.where(steady, np.ceil(gusty / pace) + LENGTHS * STEPS_A_LENGTH, 0)
    ended = ship.program.helmed(
        {**ship.values(), **own}, pilot, y=own["y"] + extra["off_y"], u=own["u"], v=hold["v"],
        psi=psi + extra["off_psi"], dt=pace, steps=steps, workers=workers,
    )  # fmt: skip
    held = steady & (ended.outcome == Outcome.AFLOAT) & (ended.late <= hull.beam / 2)
    return {"rudder": rudder, "held": held}
