"""What an ensemble says of itself, as single voyages do: a step too long, data left, time that ran out."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from narrows.codegen.shapes import OPEN
from narrows.model.data_range import DataRange
from narrows.simulation.grid import Grid
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.outcome import Code
from narrows.terms.about import TermKind

TAKEN_AGAIN = 64
"""Voyages that are sailed again at half the step."""
COARSE = 0.02
"""Of the beam, by which the place of an end may move without a word."""


def notes_of(run: KernelRun, grid: Grid, voyages: xr.Dataset) -> tuple[str, ...]:
    """Say what voyages rest on that their numbers do not show (ours).

    Parameters
    ----------
    run : KernelRun
        How they were run.
    grid : Grid
        What varied.
    voyages : Dataset
        Their ends.
    """
    model = run.ship.model
    varied = any(grid.values[term.name].dims for term in model.terms.terms if term.kind == TermKind.BANK)
    bank = () if run.ship.shape == OPEN or varied or not model.bank_note else (model.bank_note,)
    return (*bank, *_coarse(run, grid, voyages), *_diverged(voyages), *_beyond(model.data_range, grid, voyages))


def _coarse(run: KernelRun, grid: Grid, voyages: xr.Dataset) -> tuple[str, ...]:
    """A sample retaken at half the step, and the share of it that changed."""
    flat = {name: voyages[name].to_numpy().ravel() for name in ("outcome", "side", "distance", "y_end")}
    places = np.unique(np.linspace(0, len(flat["outcome"]) - 1, TAKEN_AGAIN).round().astype(int))
    places = places[flat["outcome"][places] >= 0]
    if not places.size:
        return ()
    values = _at(grid, places)
    again = replace(run, dt=np.asarray(run.dt) / 2).run(values, len(places), 1)
    far = COARSE * run.ship.model.configuration.ship.beam
    same_end = (again["outcome"] == flat["outcome"][places]) & (again["side"] == flat["side"][places])
    moved = np.hypot(again["distance"] - flat["distance"][places], again["y_end"] - flat["y_end"][places])
    changed = ~same_end | (moved > far)
    if not changed.any():
        return ()
    return (
        f"A time step of {float(np.max(run.dt)):g} s is too long for {changed.mean():.0%} of these voyages: at half of "
        f"it they end otherwise, or more than {COARSE:.0%} of the beam off; shorten it.",
    )


def _at(grid: Grid, places: np.ndarray) -> dict[str, Any]:
    """Every value at some vessels."""
    shape = tuple(grid.sizes.values())
    index = dict(zip(grid.sizes, np.unravel_index(places, shape), strict=True))
    found: dict[str, Any] = {}
    for name, value in grid.values.items():
        cut = value.isel({d: xr.DataArray(index[str(d)], dims="vessel") for d in value.dims})
        found[name] = np.broadcast_to(cut.to_numpy(), len(places)) if value.dims else float(value)
    return found


def _diverged(voyages: xr.Dataset) -> tuple[str, ...]:
    share = float((voyages["outcome"] == Code.DIVERGED).mean())
    if not share:
        return ()
    return (f"The motion diverged in {share:.1%} of these voyages: shorten the time step or look at the coefficients.",)


def _beyond(known: DataRange, grid: Grid, voyages: xr.Dataset) -> tuple[str, ...]:
    """In what some voyages begin or end outside the data of the model."""
    values: Mapping[str, xr.DataArray] = grid.values
    asked = {
        "speed": (values["u"], voyages["u_end"], "m/s", "a surge velocity"),
        "abs_y": (abs(values["y"]), abs(voyages["y_end"]), "m", "an offset from the centreline"),
        "abs_r": (abs(values["r"]), abs(voyages["r_end"]), "rad/s", "a yaw rate"),
    }
    found = []
    for name, (first, last, unit, word) in asked.items():
        covered = getattr(known, name)
        if covered is None:
            continue
        slack = 1e-6 * max(map(abs, covered))
        out = _outside(first, covered, slack) | _outside(last, covered, slack)
        share = float(out.broadcast_like(voyages["outcome"]).mean())
        if share and math.isfinite(share):
            low, high = covered
            found.append(
                f"{share:.1%} of these voyages begin or end with {word} outside the data ({low:.3g} to "
                f"{high:.3g} {unit})."
            )
    return tuple(found)


def _outside(values: xr.DataArray, covered: tuple[float, float], slack: float) -> xr.DataArray:
    return (values < covered[0] - slack) | (values > covered[1] + slack)
