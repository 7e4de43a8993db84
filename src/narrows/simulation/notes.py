"""Notes of voyages, fleets and states outside the tested range of the model: one table for all."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import reduce
from typing import Any

import numpy as np

from narrows.model.data_range import MEASURES, DataRange, Measure, extrapolation
from narrows.model.model import Model
from narrows.quantities.names import Number

# Motion astern, if the model does not give the speeds of its tests: bank and rudder forces are known ahead only.
ASTERN = Measure("way astern", "m/s")

# A sentence on a measure: its words, the range of the data in words, a mask of values outside, the values.
Sentence = Callable[[Measure, str, Any, Any], str]


def measured(at: Mapping[str, Any], ship: Mapping[str, Any], banks: bool) -> dict[str, Any]:
    """Return the quantities that notes compare with the data, by the names of ``MEASURES``."""
    motion = {"speed": at["u"], "abs_y": abs(at["y"]), "abs_psi": abs(at["psi"]), "abs_r": abs(at["r"])}
    return {**motion, **section_ratios(ship, banks)}


def section_ratios(values: Mapping[str, Number], banks: bool) -> dict[str, Number]:
    """Return h/T if the depth is known, and W/B between banks."""
    depth = values.get("depth")
    ratios = {} if depth is None else {"depth_to_draft": depth / values["draft"]}
    return {**ratios, "width_to_beam": values["width"] / values["beam"]} if banks else ratios


def section_notes(model: Model, values: Mapping[str, Number], banks: bool = True) -> tuple[str, ...]:
    """Return notes on a section outside the tested range, for results that are no voyage."""
    return extrapolation(model.data_range, section_ratios(values, banks))


def outside_notes(known: DataRange, moments: Sequence[Mapping[str, Any]], sentence: Sentence) -> Iterator[str]:
    """Yield a sentence for each measure that leaves the tested range."""
    for name, values in moments[0].items():
        outside = reduce(np.logical_or, [known.outside(name, moment[name]) for moment in moments])
        if np.any(outside):
            yield sentence(MEASURES[name], MEASURES[name].shown(*getattr(known, name)), outside, values)
    astern = reduce(np.logical_or, [moment["speed"] < 0 for moment in moments])
    if known.speed is None and np.any(astern):
        yield sentence(ASTERN, "ahead alone", astern, moments[0]["speed"])
