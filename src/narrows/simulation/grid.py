"""The varied quantities of an ensemble with named dimensions, split into blocks."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from narrows.base.errors import InputError, check_count, did_you_mean, reason, shown
from narrows.base.results import answer
from narrows.model.model import Model
from narrows.model.term import TermTable
from narrows.quantities.names import FORCES, PARTICULARS
from narrows.ship.actuators import particulars_with, places_of, with_standard
from narrows.ship.checks import check_angles, check_number, check_particulars, check_rule, place_of
from narrows.simulation.inputs import START, STEADY
from narrows.simulation.kernel_run import OUTPUTS
from narrows.simulation.outcome import KINDS, WAYS
from narrows.simulation.settings import MOST_SAMPLES


class AliasedDataset(xr.Dataset):  # type: ignore[misc]
    """An xarray Dataset that answers to the names of other libraries."""

    __slots__ = ()

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            try:
                return super().__getattr__(name)
            except AttributeError:
                if name.startswith("_"):
                    raise
                return answer(self, name, [str(own) for own in self.variables])


@dataclass(frozen=True)
class Grid:
    """Quantities that may vary from vessel to vessel, by name, each with its own dimensions."""

    values: Mapping[str, xr.DataArray]  # Start, inputs, particulars and coefficients
    sizes: Mapping[str, int]  # Length of each dimension

    @property
    def vessels(self) -> int:
        return math.prod(self.sizes.values())

    @property
    def axis(self) -> str:
        """The longest dimension, along which blocks are cut."""
        return max(self.sizes, key=lambda name: self.sizes[name])

    def blocks(self, vessels: int) -> Iterator[slice]:
        """Yield slices of the longest dimension, of about this many vessels each."""
        rows = max(1, round(vessels * self.sizes[self.axis] / self.vessels))
        for start in range(0, self.sizes[self.axis], rows):
            yield slice(start, min(start + rows, self.sizes[self.axis]))

    def region(self, block: slice) -> tuple[slice, ...]:
        return tuple(block if name == self.axis else slice(None) for name in self.sizes)

    def flat(self, block: slice) -> tuple[dict[str, np.ndarray | float], tuple[int, ...]]:
        """Return every value over one block of vessels: one number, or one per vessel, and the block's shape."""
        shape = tuple(len(range(*block.indices(n))) if name == self.axis else n for name, n in self.sizes.items())
        flat: dict[str, np.ndarray | float] = {}
        for name, value in self.values.items():
            if not value.dims:
                flat[name] = float(value)
                continue
            cut = value.variable.isel({self.axis: block}, missing_dims="ignore")
            flat[name] = cut.set_dims(dict(zip(self.sizes, shape, strict=True))).to_numpy().ravel()
        return flat, shape

    def coordinates(self) -> dict[str, xr.DataArray]:
        pairs = (pair for value in self.values.values() for pair in value.coords.items())
        return {str(name): one for name, one in pairs if set(one.dims) <= set(self.sizes)}


def grid_of(model: Model, vary: Mapping[str, Any], samples: int, seed: int) -> Grid:
    movers, machinery = model.terms.actuators, particulars_with(model.terms.actuators)
    names = {*machinery, *(actuator.name for actuator in with_standard(movers))}
    particulars = {name: value for name, value in model.configuration.values().items() if name in names}
    known = {**START, **dict.fromkeys(FORCES, 0.0), **STEADY, **particulars, **model.coefficients}
    words = {*known, *machinery, *(actuator.name for actuator in movers)}
    for name in vary:
        if name not in words:
            raise InputError(f"an ensemble cannot vary {name!r}{did_you_mean(name, words)}")
    check_count("samples", samples, most=MOST_SAMPLES)
    check_count("seed", seed)
    places = {name: place_of(name) for name in PARTICULARS} | places_of(with_standard(movers))  # In a ship file
    columns = constrained(model.terms, {name: labelled(name, value, places) for name, value in vary.items()})
    values = {name: xr.DataArray(float(value)) for name, value in known.items()}
    values |= sampled(model, samples, seed) if samples else {}
    values |= columns
    check_angles(columns)
    sizes = sizes_of(values)
    check_particulars({name: value for name, value in values.items() if name in places}, places)
    for term in (one for one in model.terms.terms if one.name in columns):
        name, (low, high), value = term.name, term.bound, columns[term.name]
        for right, side in ((value >= low, f"below the {low:g}"), (value <= high, f"above the {high:g}")):
            sentence = f"{{{name}}} is {side} that its term allows; keep to it"
            check_rule(right, sentence, {name: value}, {name: f"coefficient {name}"})
    return Grid(values, sizes or {"vessel": 1})


Columns = Mapping[str, xr.DataArray]


def labelled(name: str, value: Any, places: Mapping[str, str] | None = None) -> xr.DataArray:
    """Return a number, a sequence or a DataArray as a column of finite numbers with named dimensions."""
    try:
        array = value if isinstance(value, xr.DataArray) else np.asarray(value)
        if array.dtype.kind not in "iufO":  # Complex numbers, words or dates
            raise TypeError
        array = array.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} = {shown(value)} is not a finite number; give it in SI units") from None
    if not isinstance(array, xr.DataArray):
        if array.ndim > 1:
            raise InputError(f"{name} has {array.ndim} dimensions; name them in an xarray.DataArray")
        array = xr.DataArray(array, {name: array} if array.ndim else None, [name] * array.ndim)
    if not array.size:
        raise InputError(f"{name} is empty; give at least one value")
    for dimension in array.dims:
        if not isinstance(dimension, str) or dimension in OUTPUTS or array.dims.count(dimension) > 1:
            raise InputError(f"{name} has a dimension {shown(dimension)}, which cannot be one; name it otherwise")
    check_number((places or {}).get(name, name), array)
    return array


def sizes_of(values: Columns) -> dict[str, int]:
    try:
        aligned = xr.align(*(value for value in values.values() if value.dims), join="exact", copy=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"what shares a dimension must have its length and labels: {reason(error)}") from None
    return {str(name): size for value in aligned for name, size in value.sizes.items()}


def constrained(terms: TermTable, varied: Columns) -> dict[str, xr.DataArray]:
    """Return the values with the partners of each tied coefficient, which are the same number."""
    complete = dict(varied)
    for _ in terms.ties:  # A tie may lead to the next
        for one, other in terms.ties:
            if one in complete and other in complete and not complete[one].variable.equals(complete[other].variable):
                raise InputError(f"{one} and {other} are one coefficient of these terms; give one of them, not both")
            either = complete.get(one, complete.get(other))
            if either is not None:
                complete[one], complete[other] = complete.get(one, either), complete.get(other, either)
    return complete


def sampled(model: Model, samples: int, seed: int) -> dict[str, xr.DataArray]:
    if model.covariance is None:
        raise InputError("this model has no covariance to draw coefficients from; identify it from tests, or samples=0")
    names = model.terms.names
    mean = np.array([model.coefficients[name] for name in names])
    drawn = mean + correlated(model.covariance, samples, seed)
    low, high = np.array([term.bound for term in model.terms.terms]).T
    columns = _within(drawn, model.covariance, low, high).T
    coordinate = {"sample": np.arange(samples)}
    return {name: xr.DataArray(c, dims=["sample"], coords=coordinate) for name, c in zip(names, columns, strict=True)}


def correlated(covariance: np.ndarray, samples: int, seed: int | Sequence[int]) -> np.ndarray:
    drawn = np.random.default_rng(seed).standard_normal((samples, len(covariance)))
    return np.asarray(drawn @ symmetric_root(covariance))


def symmetric_root(covariance: np.ndarray) -> np.ndarray:
    """Return a root of a covariance by its correlations: coefficients may differ by many powers of ten."""
    size = np.sqrt(np.diag(covariance))
    scale = np.where(size > 0, size, 1.0)
    share, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    # The symmetric root does not depend on the axes, which rounding on another processor may change.
    return np.asarray((axes * np.sqrt(np.maximum(share, 0.0))) @ axes.T * size)


def _within(sample: np.ndarray, covariance: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Clip samples to their bounds; correlated coefficients move with the clipped one."""
    for _ in range(3):  # Those may leave their own bounds in turn
        for k in np.flatnonzero(np.diag(covariance) > 0):
            shift = np.clip(sample[:, k], low[k], high[k]) - sample[:, k]
            if shift.any():
                sample = sample + shift[:, None] * covariance[k] / covariance[k, k]
    return np.asarray(np.clip(sample, low, high))


# Code of a voyage that was not run.
NOT_RUN = -1
UNITS = {"time": "s", "distance": "m", "y_end": "m", "psi_end": "rad", "u_end": "m/s", "v_end": "m/s", "r_end": "rad/s"}


def attributes_of(name: str) -> dict[str, Any]:
    """Units, and the meaning of codes by the CF conventions."""
    if name == "outcome":
        codes = {NOT_RUN: "not run", **{int(code): kind for code, kind in KINDS.items()}}
        for code, way in WAYS.items():
            codes[int(code)] = f"{KINDS[code]} by its {way}"
        meanings = " ".join(word.replace(" ", "_") for word in codes.values())
        return {"flag_values": list(codes), "flag_meanings": meanings}
    if name == "side":
        return {"flag_values": [-1, 0, 1], "flag_meanings": "port_or_stern none starboard_or_bow"}
    words = {"time": "time of the end", "distance": "distance along the canal"}
    return {"units": UNITS[name], "long_name": words.get(name, f"{name.removesuffix('_end')} at the end")}
