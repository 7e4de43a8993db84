"""How the tests sail with the package: by its public functions, in the words of the cases."""

from typing import Any

import numpy as np
import xarray as xr
from cases import Case

import narrows as nw


def voyage(case: Case, number: int, **changed: Any) -> nw.Voyage:
    """Sail one start by itself."""
    told = {
        **case.start(number), **case.push, **case.options, "duration": case.duration, "dt": case.dt,
        "contact": case.shape, "waterway": case.waterway, "controller": case.law,
    }  # fmt: skip
    return nw.simulate(case.model, **{**told, **changed})


def fleet(case: Case, **changed: Any) -> xr.Dataset:
    """Sail every start at once."""
    starts = {name: xr.DataArray(column, dims="start") for name, column in case.starts.items()}
    told = {
        **starts, **case.push, **case.options, "duration": case.duration, "dt": case.dt, "contact": case.shape,
        "waterway": case.waterway, "controller": case.law,
    }  # fmt: skip
    return nw.ensemble(case.model, **{**told, **changed})


def kinds(ended: xr.Dataset) -> list[str]:
    """The outcomes in words, as voyages say them; by which end of a waterway is told in the sentence."""
    attributes = ended["outcome"].attrs
    words = dict(zip(attributes["flag_values"], attributes["flag_meanings"].split(), strict=True))
    return [words[int(code)].replace("_", " ").partition(" by its ")[0] for code in np.ravel(ended["outcome"])]


def sides(ended: xr.Dataset) -> list[str | None]:
    """The sides in words."""
    return [{1: "starboard", -1: "port", 0: None}[int(side)] for side in np.ravel(ended["side"])]
