"""Trials of an autopilot: ships thrown off their steady courses, at every offset, speed and sample at once."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from narrows.control.self_propulsion import with_propulsion
from narrows.control.steady_course import solved
from narrows.control.track_pilot import track_gains
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.progress import bar
from narrows.quantities.arithmetic import choice, maximum
from narrows.safety.disturbance import Disturbance
from narrows.safety.question import Walls
from narrows.simulation.controllers import Autopilot, Named
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


def trials(
    model: Model, y: np.ndarray, u: np.ndarray, heave: np.ndarray, disturbance: Disturbance, samples: int, seed: int,
    walls: Walls = (math.inf, math.inf), workers: int | None = None, progress: bool = False,
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
    # Off to the other side on the other side of the middle: a canal that mirrors itself gets an answer that does.
    side = xr.DataArray(np.where(np.asarray(y) < 0, -1.0, 1.0), dims="y")
    extra = {f"off_{name}": side * column for name, column in thrown.items()}
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
    tried = xr.Dataset(data, coords={"y": y, "u": u}).transpose("y", "u", "sample")
    return tried.assign(held=tried["held"] > 0)


def _gains(ship: SimulatedShip, grid: Grid, speeds: int) -> np.ndarray:
    """The gains at each speed, (speeds, 4)."""
    felt = [name for name in ("u", "heave", "revolutions") if name in grid.values]
    columns = {name: np.broadcast_to(grid.values[name].to_numpy(), speeds) for name in felt}
    rows = ({name: float(column[index]) for name, column in columns.items()} for index in range(speeds))
    return np.array([track_gains(ship, row.pop("u"), **row) for row in rows])


@dataclass(frozen=True)
class HeldCourse(Autopilot):
    """A track pilot that remembers how far off its line it was from a time on (ours).

    Parameters
    ----------
    y : float or DataArray [m]
        Offset to hold.
    gains : four floats or DataArrays [rad/m, 1, rad s/m, s]
        As of ``Autopilot``.
    rudder, psi, v : float or DataArray [rad, rad, m/s]
        That hold it there.
    late_from : float [s]
        From when.
    """

    late_from: Any = 0.0

    def parameters(self) -> Mapping[str, Any]:
        """Return what is held, the gains, and from when it counts."""
        return {**super().parameters(), "late_from": self.late_from}

    def memory(self, start: Named) -> Named:
        """Return how far off it was so far.

        Parameters
        ----------
        start : mapping of str to number
            The state at the start.
        """
        return {"farthest": 0.0}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the order, and how far off it was.

        Parameters
        ----------
        at : object
            Quantities by name.
        """
        orders, _ = super().orders(at)
        counted = choice(at.t + at.dt / 2 - at.late_from, abs(at.y - at.held_y), 0.0)
        return orders, {"farthest": maximum(at.farthest, counted)}


def _sailed(
    ship: SimulatedShip, values: Mapping[str, Any], count: int, gust_time: float, walls: Walls, workers: int | None
) -> dict[str, np.ndarray]:
    extra = {name: value for name, value in values.items() if name.startswith(("off_", "by_"))}
    course = {name: value for name, value in values.items() if name not in extra}
    v, rudder = solved(ship, course, count, workers)
    hull, gear = ship.model.configuration.ship, ship.model.configuration.gear
    steady = np.abs(rudder) <= gear.limit  # false where there is none
    hold = {
        "held_v": np.where(steady, v, 0.0),
        "held_rudder": np.where(steady, rudder, 0.0),
        "held_y": course["y"],
    }
    psi, pace = (
        -np.arctan(hold["held_v"] / course["u"]),
        hull.length / (STEPS_A_LENGTH * np.asarray(course["u"])),
    )
    gusty = gust_time if np.any(extra["off_Y"]) else 0.0
    # No course to hold: no steps are sailed.
    steps = np.where(steady, np.ceil(gusty / pace) + LENGTHS * STEPS_A_LENGTH, 0)
    law = {**hold, "held_psi": psi, "late_from": (steps - LATE * STEPS_A_LENGTH) * pace}
    law |= dict(zip(("by_y", "by_psi", "by_v", "by_r"), (extra[f"by_{i}"] for i in range(4)), strict=True))
    push = {"X": 0.0, "Y": extra["off_Y"], "N": extra["off_N"], "push_end": gusty} if gusty else {}
    half = np.asarray(course["width"]) / 2
    inputs = {
        **course, **push, **{PARAMETER(name): value for name, value in law.items()}, "rudder": hold["held_rudder"],
        "y": course["y"] + extra["off_y"], "v": hold["held_v"], "psi": psi + extra["off_psi"],
        "wall_port": np.minimum(walls[0], half), "wall_starboard": np.minimum(walls[1], half),
    }  # fmt: skip
    steering = steering_of(HeldCourse(0.0, (0.0, 0.0, 0.0, 0.0)), ship.actuators)
    run = KernelRun(ship, steps * pace, pace, steering=steering)
    prepared = run.prepared(inputs, count, workers)
    prepared()
    ended = run.ended(prepared, inputs)
    late = np.maximum(ended[f"{MEMORY('farthest')}_end"], np.abs(ended["y_end"] - course["y"]))
    held = steady & (ended["outcome"] == Code.AFLOAT) & (late <= hull.beam / 2)
    return {"rudder": rudder, "held": held}
