"""What varies over an ensemble: every argument with its own named dimensions, cut into blocks that fit in memory."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from narrows.errors import InputError, did_you_mean
from narrows.model.model import Model
from narrows.ship.actuators import STANDARD, particulars_with
from narrows.simulation.inputs import INPUTS, START, STEADY
from narrows.simulation.samples import check_samples, sampled
from narrows.simulation.variation import check_columns, file_places, labelled, sizes_of, tied


@dataclass(frozen=True)
class Grid:
    """Everything that may vary from vessel to vessel, by name, each with its own dimensions."""

    values: Mapping[str, xr.DataArray]  # Start, inputs, particulars and coefficients
    sizes: Mapping[str, int]  # Length of each dimension

    @property
    def vessels(self) -> int:
        """How many voyages."""
        return math.prod(self.sizes.values())

    @property
    def axis(self) -> str:
        """The longest dimension, along which blocks are cut."""
        return max(self.sizes, key=lambda name: self.sizes[name])

    def blocks(self, vessels: int) -> Iterator[slice]:
        """Yield slices of the longest dimension, of about so many vessels each."""
        rows = max(1, round(vessels * self.sizes[self.axis] / self.vessels))
        for start in range(0, self.sizes[self.axis], rows):
            yield slice(start, min(start + rows, self.sizes[self.axis]))

    def region(self, block: slice) -> tuple[slice, ...]:
        """Return where a block lies among all vessels."""
        return tuple(block if name == self.axis else slice(None) for name in self.sizes)

    def part(self, block: slice) -> "Grid":
        """Return one block as a grid of its own, to send elsewhere."""
        values = {n: v.isel({self.axis: block}) if self.axis in v.dims else v for n, v in self.values.items()}
        return Grid(values, {**self.sizes, self.axis: block.stop - block.start})

    def flat(self, block: slice) -> tuple[dict[str, np.ndarray | float], tuple[int, ...]]:
        """Return every value over one block of vessels: one number, or one a vessel, and the block's shape."""
        shape = tuple(len(range(*block.indices(n))) if name == self.axis else n for name, n in self.sizes.items())
        return {name: self._flat(value, block, shape) for name, value in self.values.items()}, shape

    def coordinates(self) -> dict[str, xr.DataArray]:
        """The labels of the dimensions."""
        return {
            str(name): coordinate
            for value in self.values.values()
            for name, coordinate in value.coords.items()
            if set(coordinate.dims) <= set(self.sizes)
        }

    def _flat(self, value: xr.DataArray, block: slice, shape: tuple[int, ...]) -> np.ndarray | float:
        if not value.dims:
            return float(value)
        cut = value.isel({self.axis: block}) if self.axis in value.dims else value
        order = [name for name in self.sizes if name in cut.dims]
        wide = cut.transpose(*order).to_numpy()
        spread = tuple(n if name in cut.dims else 1 for name, n in zip(self.sizes, shape, strict=True))
        return np.ascontiguousarray(np.broadcast_to(wide.reshape(spread), shape)).ravel()


def grid_of(model: Model, vary: Mapping[str, Any], samples: int, seed: int) -> Grid:
    """Lay out an ensemble."""
    movers, machinery = model.terms.actuators, particulars_with(model.terms.actuators)
    names = {*machinery, *(actuator.name for actuator in (*STANDARD, *movers))}
    particulars = {name: value for name, value in model.configuration.values().items() if name in names}
    known = {**START, **INPUTS, **STEADY, **particulars, **model.coefficients}
    words = {*known, *machinery, *(actuator.name for actuator in movers)}
    for name in vary:
        if name not in words:
            raise InputError(f"an ensemble cannot vary {name!r}{did_you_mean(name, words)}")
    check_samples(samples, seed)
    places = file_places(movers)
    columns = tied(model.terms, {name: labelled(name, value, places) for name, value in vary.items()})
    values = {name: xr.DataArray(float(value)) for name, value in known.items()}
    values |= sampled(model, samples, seed) if samples else {}
    return _grid(model, {**values, **columns}, columns)


def with_values(grid: Grid, more: Mapping[str, Any]) -> Grid:
    """Return a grid with further values, whose dimensions are the grid's or new ones."""
    values = {**grid.values, **{name: labelled(name, value) for name, value in more.items()}}
    return Grid(values, sizes_of(values) or grid.sizes)


def _grid(model: Model, values: Mapping[str, xr.DataArray], varied: Mapping[str, xr.DataArray]) -> Grid:
    sizes = sizes_of(values)
    check_columns(model, values, varied)
    return Grid(values, sizes or {"vessel": 1})
