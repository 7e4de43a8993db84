"""What of an envelope lies within the tests behind its model."""

from dataclasses import replace

import numpy as np

from narrows.model.data_range import MEASURES, DataRange, Measure, extrapolation
from narrows.model.model import Model
from narrows.quantities.constants import KNOT

# How ranges of the data are spoken of on a bridge.
IN_KNOTS = {**MEASURES, "speed": Measure("speed", "knots", 1 / KNOT)}
SECTION = ("depth_to_draft", "width_to_beam")


def within_tests(model: Model, offsets: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Return which offsets and speeds the tests covered, (offsets, speeds); all where they do not say."""
    # offsets (n,) [m]; speeds (m,) [m/s]
    # A place nearer to the middle than the tests were is inside.
    known = _to_the_middle(model)
    off, fast = known.outside("abs_y", np.abs(offsets)), known.outside("speed", speeds)
    return np.asarray(~np.asarray(off)[:, None] & ~np.asarray(fast)[None])


def _to_the_middle(model: Model) -> DataRange:
    """What the tests covered, the offsets nearer to the middle than theirs with them."""
    known = model.data_range
    return replace(known, abs_y=known.abs_y and (0.0, known.abs_y[1]))


def tested_ranges(model: Model) -> dict[str, list[float]]:
    """Return the speeds [m/s] and offsets [m] that the tests covered, as far as they are known."""
    ranges = {"tested_speed": model.data_range.speed, "tested_offset": model.data_range.abs_y}
    return {name: list(covered) for name, covered in ranges.items() if covered is not None}


def beyond_tests(model: Model, offsets: np.ndarray, speeds: np.ndarray) -> tuple[str, ...]:
    """Say in what a question goes beyond the tests, or that they do not say what they covered."""
    # offsets (n,) [m]; speeds (m,) [m/s]
    asked = {"speed": speeds, "abs_y": np.abs(offsets).max(), **_section(model)}
    return extrapolation(_to_the_middle(model), asked, IN_KNOTS, unknown=True)


def untested_section(model: Model) -> str:
    """Say in what the section of water is none that was tested; nothing where it is one, or that is not known."""
    known = model.data_range
    there = [
        f"{IN_KNOTS[name].words} {IN_KNOTS[name].shown(value, value)} ({IN_KNOTS[name].shown(*getattr(known, name))} "
        "was tested)"
        for name, value in _section(model).items()
        if known.outside(name, value)
    ]
    return " and ".join(there)


def _section(model: Model) -> dict[str, float]:
    ship, canal = model.configuration.ship, model.configuration.canal
    depth = {} if canal.depth is None else {"depth_to_draft": canal.depth / ship.draft}
    return {**depth, "width_to_beam": canal.width / ship.beam}
