"""Many voyages at once: grids and samples over anything, labelled in and out, on all cores or on a cluster."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from narrows.compile.kernel import Precision
from narrows.errors import InputError
from narrows.files import path_of
from narrows.model.model import Model
from narrows.simulation.fleet import KEPT, Fleet, Result
from narrows.simulation.grid import Grid, grid_of
from narrows.simulation.inputs import MOST_STEPS, check_precision, check_steps, check_vessels, check_workers
from narrows.simulation.kept import attributes_of, empty_of
from narrows.simulation.progress import bar
from narrows.simulation.ship import Outline, SimulatedShip

BLOCK_VESSELS = 65_536
"""Voyages at a time: a fraction of a second's work, so that bars move and Ctrl-C is heard."""


def ensemble(
    model: Model, *, duration: float = 60.0, dt: float = 0.02, samples: int = 0, seed: int = 0,
    surge: str = "held", surge_inertia: float | None = None, coriolis: bool = False,
    contact: str | Outline = "corners", precision: Precision = "float64", workers: int | None = None,
    progress: bool = False, store: str | Path | None = None, client: Any = None, **vary: Any,
) -> xr.Dataset:  # fmt: skip
    """Simulate a voyage for every combination of what varies.

    Parameters
    ----------
    model : Model
        Gives whatever does not vary.
    duration : float [s]
        Longest time of a voyage.
    dt : float [s]
        Step of the Runge-Kutta method.
    samples : int
        Of the coefficients, from the fit's covariance: a dimension ``sample``.
    seed : int
        Of the samples.
    surge : str
        ``held`` or ``free``.
    surge_inertia : float [kg], optional
        Mass in surge for a free speed where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force.
    contact : str or points [m]
        ``corners``, ``midship`` or an outline.
    precision : str
        ``float64`` or ``float32``.
    workers : int, optional
        Threads; all cores unless given. The answer does not depend on it.
    progress : bool
        Show a bar on stderr.
    store : str or Path, optional
        Zarr folder to write to block by block; a run that was stopped goes on from there.
    client : dask.distributed.Client, optional
        Run on a cluster, with ``store`` where all its workers can reach it.
    **vary : number, sequence or DataArray
        Start (x, y [m], psi [rad], u, v [m/s], r [rad/s]), inputs (X, Y [N], N [N m]), heave [m], rudder [rad],
        particulars (width, depth, length, beam, draft [m], block_coefficient [1], density [kg/m3]) and coefficients
        by name.
        A sequence is a dimension of that name; DataArrays that share a dimension vary together.

    Returns
    -------
    xarray.Dataset
        outcome, side, time [s], distance [m] and the state at the end, over the dimensions of what varies.
        Interrupted, it holds what is done, and ``complete`` is 0.

    Raises
    ------
    InputError
        Where a name is unknown, a value does not fit, or a cluster has no store.
    """
    duration, dt = check_steps(duration, dt, MOST_STEPS)
    check_workers(workers)
    check_precision(precision)
    grid = grid_of(model, vary, samples, seed)
    check_vessels(grid.vessels, stored=store is not None)
    fleet = Fleet(SimulatedShip(model, surge, surge_inertia, coriolis, contact), duration, dt, precision)
    if store is not None:
        from narrows.simulation.store import run_into

        return run_into(path_of("store", store), fleet, grid, client, progress)
    if client is not None:  # One that is none is refused here too.
        raise InputError("a cluster needs a store that its workers can reach: give store='fleet.zarr'")
    return _labelled(grid, *_run_here(fleet, grid, workers, progress))


def _run_here(fleet: Fleet, grid: Grid, workers: int | None, progress: bool) -> tuple[Result, bool]:
    shape = tuple(grid.sizes.values())
    kept: Result = {name: np.full(shape, empty_of(kind), kind) for name, kind in KEPT.items()}
    with bar(grid.vessels, progress) as advance:
        try:
            for block in grid.blocks(BLOCK_VESSELS):
                values, part = grid.flat(block)
                for name, column in fleet.run(values, math.prod(part), workers).items():
                    kept[name][grid.region(block)] = column.reshape(part)
                advance(math.prod(part))
        except KeyboardInterrupt:
            return kept, False
    return kept, True


def _labelled(grid: Grid, kept: Result, complete: bool) -> xr.Dataset:
    data = {name: (list(grid.sizes), column, attributes_of(name)) for name, column in kept.items()}
    return xr.Dataset(data, coords=grid.coordinates(), attrs={"complete": int(complete)})
