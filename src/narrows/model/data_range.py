"""Ranges covered by a model's data, and the one rule for values outside."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from narrows.base.results import Aliased
from narrows.quantities.names import Number

Range = tuple[float, float]
SLACK = 0.01  # Tolerance relative to an end of a range [1]: the accuracy of a depth or a speed


class Measure(NamedTuple):
    words: str  # Name in words
    unit: str  # Unit in print; empty for none
    scale: float = 1.0  # Factor from the unit of the data to that unit [1]
    short: str = ""  # Short name in lists of untested quantities
    bit: int = 0  # Bit of the quantity in ``sum_beyond``

    def describe(self, low: float, high: float) -> str:
        ends = dict.fromkeys(f"{self.scale * end:.3g}" for end in (low, high))
        return " ".join([" to ".join(ends), self.unit]).rstrip()


MEASURES = {
    "speed": Measure("surge velocity", "m/s", 1.0, "speed", 1),
    "abs_y": Measure("offset from the centreline", "m", 1.0, "offset", 2),
    "abs_psi": Measure("heading", "deg", math.degrees(1.0), "heading", 4),
    "abs_r": Measure("yaw rate", "deg/s", math.degrees(1.0), "yaw rate", 8),
    "depth_to_draft": Measure("h/T", "", 1.0, "depth", 32),
    "width_to_beam": Measure("W/B", "", 1.0, "width", 16),
}
# Motion astern: terms of hull and rudder hold ahead only. So an unknown range of speeds is all speeds ahead [m/s].
ASTERN = Measure("way astern", "m/s", 1.0, "speed", 1)
AHEAD = (0.0, 1000.0)


@dataclass(frozen=True)
class DataRange(Aliased):
    """Ranges covered by the data; None if unknown.

    >>> bool(nw.DataRange(speed=(0.5, 1.0)).outside("speed", 1.2))
    True
    """

    speed: Range | None = None  #: Surge velocity [m/s]
    abs_y: Range | None = None  #: Distance off the centreline [m]
    abs_psi: Range | None = None  #: Absolute heading [rad]
    abs_r: Range | None = None  #: Absolute yaw rate [rad/s]
    depth_to_draft: Range | None = None  #: h/T [1]
    width_to_beam: Range | None = None  #: W/B [1]

    def describe(self, name: str, measures: Mapping[str, Measure] = MEASURES) -> str:
        """Return the range called ``name`` in words, with words and units by name of ``measures``."""
        covered = range_of(self, name) or (-math.inf, math.inf)
        return "ahead alone" if covered == AHEAD else measures[name].describe(*covered)

    def outside(self, name: str, values: Number) -> Number:
        """Return whether each of the ``values`` lies outside the range ``name``; False if the range is unknown."""
        low, high = tolerated(range_of(self, name) or (-np.inf, np.inf))
        return np.logical_or(values < low, values > high)


def range_of(known: DataRange, name: str) -> Range | None:
    """Return a range; None if it is unknown. An unknown range of speeds is that of all speeds ahead."""
    covered: Range | None = getattr(known, name)
    return AHEAD if covered is None and name == "speed" else covered


def unknown_ranges(known: DataRange, names: Iterable[str]) -> list[str]:
    return [name for name in names if getattr(known, name) is None]


def unknown_note(known: DataRange, has_bank: bool) -> str:
    """Return a note on the tested ranges that are not known; empty if all are."""
    asked = ("speed", "depth_to_draft", *(("abs_y", "width_to_beam") if has_bank else ()))
    missing = [MEASURES[name].short for name in unknown_ranges(known, asked)]
    return f"The model gives no tested range of {', '.join(missing)}." if missing else ""


def tolerated(covered: Range) -> Range:
    """Return the ends of a range with their tolerance."""
    low, high = covered
    return low - SLACK * abs(low), high + SLACK * abs(high)


def sum_beyond(known: DataRange, asked: Mapping[str, Number]) -> Number:
    """Return the quantities outside the data, as a sum of the bits of ``MEASURES``."""
    bits: Number = 0
    for name, values in asked.items():
        bits = bits + MEASURES[name].bit * np.asarray(known.outside(name, values), int)
    return bits


def extrapolation(
    known: DataRange, asked: Mapping[str, Number], measures: Mapping[str, Measure] = MEASURES, unknown: bool = False
) -> tuple[str, ...]:
    """Return one sentence for each quantity outside the data."""
    sentences = []
    for name, values in ((name, np.asarray(value, float)) for name, value in asked.items()):
        measure = ASTERN if name == "speed" and np.any(values < 0) else measures[name]
        if getattr(known, name) is None and unknown and measure is not ASTERN:
            sentences.append(
                f"Not known whether tested: the model gives no range of {measure.words} that its data covered."
            )
        elif np.any(known.outside(name, values)):
            found = measure.describe(float(np.min(values)), float(np.max(values)))
            covered = known.describe(name, measures)
            sentences.append(f"Beyond the data: {measure.words} {found}; they covered {covered}.")
    return tuple(sentences)
