"""What varies over an ensemble: read with its dimensions, tied where coefficients are one, held to every rule."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from narrows.errors import InputError, reason, shown
from narrows.model.model import Model
from narrows.quantities.names import PARTICULARS
from narrows.ship.actuator import Actuator, places_of
from narrows.ship.actuators import STANDARD
from narrows.ship.checks import Rule, check_number, check_particulars, check_rule, place_of
from narrows.terms.term import Term, TermTable

Columns = Mapping[str, xr.DataArray]
# Names of what comes out.
TAKEN = ("outcome", "side", "time", "distance", "y_end", "psi_end", "u_end", "v_end", "r_end", "block")
NOWHERE: Mapping[str, str] = {}


def file_places(actuators: Iterable[Actuator]) -> dict[str, str]:
    """Return where a ship file gives each particular, whose rules ensembles keep too."""
    return {name: place_of(name) for name in PARTICULARS} | places_of((*STANDARD, *actuators))


def labelled(name: str, value: Any, places: Mapping[str, str] = NOWHERE) -> xr.DataArray:
    """Return a number, a sequence or a DataArray as a column of finite numbers with named dimensions."""
    array = value if isinstance(value, xr.DataArray) else _from_plain(name, value)
    if not array.size:
        raise InputError(f"{name} is empty; give at least one value")
    if array.dtype.kind not in "iuf":
        array = array.copy(data=_floats(name, array.to_numpy()))
    for dimension in array.dims:
        if not isinstance(dimension, str) or dimension in TAKEN or array.dims.count(dimension) > 1:
            raise InputError(f"{name} has a dimension {shown(dimension)}, which cannot be one; name it otherwise")
    array = array.astype(float)
    check_number(places.get(name, name), array)
    return array


def _from_plain(name: str, value: Any) -> xr.DataArray:
    try:
        plain = np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} = {shown(value)} is neither a number nor a list of numbers; give one") from None
    if plain.ndim > 1:
        raise InputError(f"{name} has {plain.ndim} dimensions; name them in an xarray.DataArray")
    plain = _floats(name, plain)
    return xr.DataArray(plain, dims=[name], coords={name: plain}) if plain.ndim else xr.DataArray(float(plain))


def _floats(name: str, values: np.ndarray) -> np.ndarray:
    """Numbers as floats; objects one by one, but nothing complex, no words and no dates."""
    try:
        if values.dtype.kind in "iufO":
            return values.astype(float)
    except (TypeError, ValueError, OverflowError):
        pass
    raise InputError(f"{name} = {shown(values.tolist())} is not a finite number; give it in SI units")


def sizes_of(values: Columns) -> dict[str, int]:
    """Return the length of each dimension."""
    try:
        aligned = xr.align(*(value for value in values.values() if value.dims), join="exact", copy=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"what shares a dimension must have its length and labels: {reason(error)}") from None
    return {str(name): size for value in aligned for name, size in value.sizes.items()}


def tied(terms: TermTable, varied: Columns) -> dict[str, xr.DataArray]:
    """Return what is given with each tied coefficient's partners, which are the same number."""
    complete = dict(varied)
    for _ in terms.ties:  # A tie may lead to the next.
        for one, other in terms.ties:
            if one in complete and other in complete and not _are_one(complete[one], complete[other]):
                raise InputError(f"{one} and {other} are one coefficient of these terms; give one of them, not both")
            either = complete.get(one, complete.get(other))
            if either is not None:
                complete[one], complete[other] = complete.get(one, either), complete.get(other, either)
    return complete


def _are_one(one: xr.DataArray, other: xr.DataArray) -> bool:
    return one.dims == other.dims and one.shape == other.shape and bool((one.to_numpy() == other.to_numpy()).all())


def check_columns(model: Model, values: Columns, varied: Columns) -> None:
    """Raise where particulars break a rule that a ship file must keep, or a coefficient leaves its bounds."""
    places = file_places(model.terms.actuators)
    check_particulars({name: value for name, value in values.items() if name in places}, places)
    for term in model.terms.terms:
        if term.name in varied:
            _check_bound(term, varied[term.name])


def _check_bound(term: Term, value: xr.DataArray) -> None:
    name, (low, high) = term.name, term.bound
    sides = ((value >= low, f"below the {low:g}"), (value <= high, f"above the {high:g}"))
    for right, side in sides:
        rule = Rule((name,), lambda _, right=right: right, f"{{{name}}} is {side} that its term allows; keep to it")
        check_rule(rule, {name: value}, {name: f"coefficient {name}"})
