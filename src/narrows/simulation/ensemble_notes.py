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

# Voyages that are sailed again at half the step.
TAKEN_AGAIN = 64
# Of the beam, by which the place of an end may move without a word.
COARSE = 0.02


def notes_of(run: KernelRun, grid: Grid, voyages: xr.Dataset) -> tuple[str, ...]:
    """Say what voyages rest on that their numbers do not show."""
    model = run.ship.model
    varied = any(grid.values[term.name].dims for term in model.terms.terms if term.kind == TermKind.BANK)
    bank = () if run.ship.shape == OPEN or (varied and not model.feels_bank) else model.bank_notes
    coarse = _coarse(run, grid, voyages) if voyages.attrs["complete"] else ()  # Who interrupts wants no more sailed.
    return (*bank, *coarse, *_diverged(voyages), *_beyond(model.data_range, grid, voyages))


def _coarse(run: KernelRun, grid: Grid, voyages: xr.Dataset) -> tuple[str, ...]:
    """A sample retaken at half the step, and the share of it that changed."""
    places = np.unique(np.linspace(0, grid.vessels - 1, TAKEN_AGAIN).round().astype(int))
    first = {name: _picked(voyages[name], grid, places) for name in ("outcome", "side", "distance", "y_end")}
    values = {name: _picked(value, grid, places) for name, value in grid.values.items()}
    again = replace(run, dt=np.asarray(run.dt) / 2).run(values, len(places), 1)
    far = COARSE * run.ship.model.configuration.ship.beam
    same_end = (again["outcome"] == first["outcome"]) & (again["side"] == first["side"])
    moved = np.hypot(again["distance"] - first["distance"], again["y_end"] - first["y_end"])
    changed = ~same_end | (moved > far)
    if not changed.any():
        return ()
    return (
        f"A time step of {float(np.max(run.dt)):g} s is too long for {changed.mean():.0%} of these voyages: at half of "
        f"it they end otherwise, or more than {COARSE:.0%} of the beam off; shorten it.",
    )


def _picked(value: xr.DataArray, grid: Grid, places: np.ndarray) -> Any:
    """A value at some vessels; one number where it does not vary."""
    if not value.dims:
        return float(value)
    index = dict(zip(grid.sizes, np.unravel_index(places, tuple(grid.sizes.values())), strict=True))
    cut = value.isel({name: xr.DataArray(index[str(name)], dims="vessel") for name in value.dims})
    return np.broadcast_to(cut.to_numpy(), len(places))


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
    notes = []
    for name, (first, last, unit, word) in asked.items():
        covered = getattr(known, name)
        if covered is None:
            continue
        out = known.outside(name, first) | known.outside(name, last)
        share = float(out.broadcast_like(voyages["outcome"]).mean())
        if share and math.isfinite(share):
            low, high = covered
            notes.append(
                f"{share:.1%} of these voyages begin or end with {word} outside the data ({low:.3g} to "
                f"{high:.3g} {unit})."
            )
    return tuple(notes)
