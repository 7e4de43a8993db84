"""What varies over an ensemble: every argument with its own named dimensions, cut into blocks that fit in memory."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from narrows.errors import InputError, did_you_mean
from narrows.model.model import Model
from narrows.quantities.names import PARTICULARS

START = {"x": 0.0, "y": 0.0, "psi": 0.0, "u": 1.0, "v": 0.0, "r": 0.0}
"""State at the start, and what it is unless said otherwise."""
INPUTS = {"X": 0.0, "Y": 0.0, "N": 0.0}
"""Constant surge force, sway force and yaw moment."""
PASSES = 3
"""Over the coefficients, to bring samples back to their bounds."""
STEADY = {"heave": 0.0, "rudder": 0.0}
"""Sinkage and rudder angle, held through a voyage."""


@dataclass(frozen=True)
class Grid:
    """Everything that may vary from vessel to vessel, by name, each with its own dimensions.

    Parameters
    ----------
    values : mapping of str to DataArray
        Start, inputs, particulars and coefficients.
    sizes : mapping of str to int
        Length of each dimension.
    """

    values: Mapping[str, xr.DataArray]
    sizes: Mapping[str, int]

    @property
    def vessels(self) -> int:
        """How many voyages."""
        return math.prod(self.sizes.values())

    @property
    def axis(self) -> str:
        """The longest dimension, along which blocks are cut."""
        return max(self.sizes, key=lambda name: self.sizes[name])

    def blocks(self, vessels: int) -> Iterator[slice]:
        """Yield slices of the longest dimension, of about so many vessels each.

        Parameters
        ----------
        vessels : int
            At least one row of the longest dimension is taken.
        """
        rows = max(1, round(vessels * self.sizes[self.axis] / self.vessels))
        for start in range(0, self.sizes[self.axis], rows):
            yield slice(start, min(start + rows, self.sizes[self.axis]))

    def region(self, block: slice) -> tuple[slice, ...]:
        """Return where a block lies among all vessels.

        Parameters
        ----------
        block : slice
            Of the longest dimension.
        """
        return tuple(block if name == self.axis else slice(None) for name in self.sizes)

    def part(self, block: slice) -> "Grid":
        """Return one block as a grid of its own, to send elsewhere.

        Parameters
        ----------
        block : slice
            Of the longest dimension.
        """
        values = {n: v.isel({self.axis: block}) if self.axis in v.dims else v for n, v in self.values.items()}
        return Grid(values, {**self.sizes, self.axis: block.stop - block.start})

    def flat(self, block: slice) -> tuple[dict[str, np.ndarray | float], tuple[int, ...]]:
        """Return every value over one block of vessels: one number, or one a vessel, and the block's shape.

        Parameters
        ----------
        block : slice
            Of the longest dimension.
        """
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


def grid_of(model: Model, given: Mapping[str, Any], samples: int, seed: int) -> Grid:
    """Lay out an ensemble.

    Parameters
    ----------
    model : Model
        Gives what is not given.
    given : mapping of str to number, sequence or DataArray
        A sequence is a dimension of its own name; DataArrays that share a dimension vary together.
    samples : int
        Of the coefficients from the model's covariance; 0 for none.
    seed : int
        Of the samples.

    Raises
    ------
    InputError
        Where a name is unknown, a value is not finite, or the model has no covariance to draw from.
    """
    known_here = {*PARTICULARS, "revolutions"}
    particulars = {name: value for name, value in model.configuration.values().items() if name in known_here}
    known = {**START, **INPUTS, **STEADY, **particulars, **model.coefficients}
    words = {*known, *PARTICULARS}
    for name in given:
        if name not in words:
            raise InputError(f"an ensemble cannot vary {name!r}{did_you_mean(name, words)}")
    values = {name: xr.DataArray(float(value)) for name, value in known.items()}
    if samples or seed < 0:
        values |= _drawn(model, samples, seed)
    values |= {name: _labelled(name, value) for name, value in given.items()}
    if (values["width"] <= values["beam"]).any():
        raise InputError("the ship is wider than the canal in some of these voyages; check width and beam")
    sizes = dict(xr.broadcast(*[v.isel({d: slice(0, None) for d in v.dims}) for v in _slim(values)])[0].sizes)
    return Grid(values, {str(name): n for name, n in sizes.items()} or {"vessel": 1})


def with_values(grid: Grid, more: Mapping[str, Any]) -> Grid:
    """Return a grid with further values, whose dimensions are the grid's or new ones.

    Parameters
    ----------
    grid : Grid
        What varies already.
    more : mapping of str to number or DataArray
        Numbers of a controller, by the names of the lines.

    Raises
    ------
    InputError
        Where one is no number, or a dimension has another size.
    """
    values = {**grid.values, **{name: _labelled(name, value) for name, value in more.items()}}
    try:
        sizes = dict(xr.broadcast(*[v.isel({d: slice(0, None) for d in v.dims}) for v in _slim(values)])[0].sizes)
    except ValueError as error:
        raise InputError(f"what varies does not fit together: {error}") from None
    return Grid(values, {str(name): n for name, n in sizes.items()} or grid.sizes)


def _slim(values: Mapping[str, xr.DataArray]) -> list[xr.DataArray]:
    """One array a set of dimensions: enough to know every size, and to refuse sizes that disagree."""
    return list({value.dims: value for value in values.values()}.values())


def _labelled(name: str, value: Any) -> xr.DataArray:
    array = value if isinstance(value, xr.DataArray) else _from_plain(name, value)
    if not array.size:
        raise InputError(f"{name} is empty; give at least one value")
    return array.astype(float)


def _from_plain(name: str, value: Any) -> xr.DataArray:
    plain = np.asarray(value, dtype=float)
    if plain.ndim == 0:
        return xr.DataArray(float(plain))
    if plain.ndim > 1:
        raise InputError(f"{name} has {plain.ndim} dimensions; name them in an xarray.DataArray")
    return xr.DataArray(plain, dims=[name], coords={name: plain})


def _drawn(model: Model, samples: int, seed: int) -> dict[str, xr.DataArray]:
    """Coefficients from their covariance, tied ones together, brought back to their bounds."""
    if samples < 0 or seed < 0:
        raise InputError(f"samples = {samples} and seed = {seed}: give numbers from 0")
    if model.covariance is None:
        raise InputError("this model has no covariance to draw coefficients from; identify it from tests, or samples=0")
    names = model.terms.names
    mean = np.array([model.coefficients[name] for name in names])
    sample = mean + _correlated(model.covariance, samples, seed)
    low, high = np.array([term.bound for term in model.terms.terms]).T
    columns = _within(sample, model.covariance, low, high).T
    coordinate = {"sample": np.arange(samples)}
    return {name: xr.DataArray(c, dims=["sample"], coords=coordinate) for name, c in zip(names, columns, strict=True)}


def _correlated(covariance: np.ndarray, samples: int, seed: int) -> np.ndarray:
    """Draw normal errors, by the correlations: coefficients of a ship differ in size by many powers of ten."""
    size = np.sqrt(np.diag(covariance))
    scale = np.where(size > 0, size, 1.0)
    share, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    normal = np.random.default_rng(seed).standard_normal((samples, len(size)))
    return np.asarray((normal * np.sqrt(np.maximum(share, 0.0))) @ axes.T * size)


def _within(sample: np.ndarray, covariance: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Bring samples back to their bounds; what is correlated with a coefficient that moves, moves along."""
    for _ in range(PASSES):
        for k in np.flatnonzero(np.diag(covariance) > 0):
            shift = np.clip(sample[:, k], low[k], high[k]) - sample[:, k]
            if shift.any():
                sample = sample + shift[:, None] * covariance[k] / covariance[k, k]
    return np.asarray(np.clip(sample, low, high))
