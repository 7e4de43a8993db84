"""Outcomes of a voyage: a value with a sentence, never an exception."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import reduce
from typing import Any

import numpy as np

from narrows.base.results import Aliased, equal_to
from narrows.model.data_range import ASTERN, MEASURES, DataRange, Measure, extrapolation
from narrows.model.model import Model
from narrows.quantities.names import GRAVITY, Number
from narrows.simulation.settings import MOST_FROUDE
from narrows.waterway.waterway import Waterway


class Code(IntEnum):
    """Outcome of a voyage as a code in compiled results and data files."""

    AFLOAT = 0
    GROUNDED = 1
    DIVERGED = 2
    OUTSIDE = 3
    ASTERN = 4
    PASSED = 5
    TOUCHED = 7
    CHOKED = 8


# Meaning of the codes; a waterway is left by its beginning or by its end.
KINDS = {
    Code.AFLOAT: "afloat", Code.GROUNDED: "grounded", Code.DIVERGED: "diverged", Code.OUTSIDE: "left validity",
    Code.ASTERN: "left the waterway", Code.PASSED: "left the waterway", Code.TOUCHED: "touched bottom",
    Code.CHOKED: "choked",
}  # fmt: skip
# End of the waterway by which a voyage leaves it.
WAYS = {Code.ASTERN: "beginning", Code.PASSED: "end"}
# Side of the ship that meets a bank or the bottom, by the sign in the column ``side``.
SIDES = {Code.GROUNDED: {1: "starboard", -1: "port"}, Code.TOUCHED: {1: "bow", -1: "stern"}}


@dataclass(frozen=True)
class Outcome(Aliased):
    """Outcome of a voyage.

    >>> nw.simulate(model, y=0.5, u=1.0).outcome.side
    'port'
    """

    #: ``grounded``, ``afloat``, ``left validity``, ``diverged``, ``left the waterway``, ``touched bottom``, ``choked``
    kind: str
    time: float  #: Time of the end [s]
    distance: float  #: Distance along the canal from the start [m]
    #: ``starboard`` or ``port`` if it grounded; ``bow`` or ``stern`` if it touched bottom; ``beginning`` or ``end`` if
    #: it left the waterway
    side: str | None = None
    state: dict[str, float] = field(default_factory=dict)  #: x, y [m], psi [rad], u, v [m/s], r [rad/s] at that moment
    #: Quantities in which it left the tested range of the model (the voyage continued); the track's error if the time
    #: step was too long
    notes: tuple[str, ...] = ()
    lengths: float = math.nan  #: The distance in ship lengths [1]
    clearance: float | None = None  #: Least distance to the banks, if it reached the end of a waterway [m]
    largest_rudder: float | None = None  #: Largest rudder angle to either side, likewise [rad]
    __eq__ = equal_to("kind")

    @property
    def impact_speed(self) -> float:
        """Speed at the end [m/s]."""
        return math.hypot(self.state["u"], self.state["v"])

    @property
    def ending(self) -> str:
        """The end in words."""
        where = f"after {self.time:.2f} s and {self.distance:.2f} m along the canal"
        heading = math.degrees(self.state["psi"])
        clear = "" if self.clearance is None else f", least clearance {self.clearance:.3g} m"
        most = self.largest_rudder
        helm = "" if most is None else f", largest rudder {math.degrees(most):.1f} deg"
        return {
            "grounded": f"Grounded to {self.side} {where}, at {self.impact_speed:.2f} m/s, heading {heading:+.1f} deg.",
            "afloat": f"Still afloat when the time was up, {where}, {self.lengths:.1f} ship lengths.",
            "left validity": f"Turned across the canal {where}, heading {heading:+.1f} deg: the model ends there.",
            "diverged": f"The motion diverged {where}: shorten the time step or look at the coefficients.",
            "left the waterway": f"Reached the end of the waterway {where}{clear}{helm}."
            if self.side == "end" else f"Left the waterway by its beginning {where}.",
            "touched bottom": f"Touched bottom with the {self.side} {where}, at {self.impact_speed:.2f} m/s.",
            "choked": f"Choked the section {where}: the water cannot pass the ship at {self.impact_speed:.2f} m/s.",
        }[self.kind]  # fmt: skip

    @property
    def sentence(self) -> str:
        """The outcome in words, with its notes."""
        return " ".join([self.ending, *(f"{note.removesuffix('.')}." for note in self.notes)])

    def to_dict(self) -> dict[str, Any]:
        """The outcome as plain values, in the documented JSON shape."""
        values = {name: getattr(self, name) for name in ("side", "time", "distance", "impact_speed", "state")}
        return {"outcome": self.kind, **values, "summary": self.sentence, "notes": list(self.notes)}


# A sentence on a measure: its words, the range of the data in words, a mask of values outside, the values.
Sentence = Callable[[Measure, str, Any, Any], str]


def measured(at: Mapping[str, Any], ship: Mapping[str, Any], banks: bool) -> dict[str, Any]:
    """Return the quantities that notes compare with the data, by the names of ``MEASURES``."""
    motion = {"speed": at["u"], "abs_y": abs(at["y"]), "abs_psi": abs(at["psi"]), "abs_r": abs(at["r"])}
    return {**motion, **section_ratios(ship, banks)}


def section_ratios(values: Mapping[str, Number], banks: bool) -> dict[str, Number]:
    depth = values.get("depth")
    ratios = {} if depth is None else {"depth_to_draft": depth / values["draft"]}
    return {**ratios, "width_to_beam": values["width"] / values["beam"]} if banks else ratios


def section_notes(model: Model, values: Mapping[str, Number], banks: bool = True) -> tuple[str, ...]:
    astern = np.minimum(np.asarray(values.get("u", 0.0)), 0.0)
    backwards = {"speed": astern} if astern.any() else {}
    return extrapolation(model.data_range, {**section_ratios(values, banks), **backwards})


def outside_notes(known: DataRange, moments: Sequence[Mapping[str, Any]], sentence: Sentence) -> Iterator[str]:
    for name, values in moments[0].items():
        outside = reduce(np.logical_or, [known.outside(name, moment[name]) for moment in moments])
        backwards = reduce(np.logical_or, [moment[name] < 0 for moment in moments]) & (name == "speed")
        for measure, where in ((MEASURES[name], outside & np.logical_not(backwards)), (ASTERN, outside & backwards)):
            if np.any(where):
                yield sentence(measure, known.describe(name), where, values)


def froude_notes(u: np.ndarray, length: float) -> tuple[str, ...]:
    """Return a note if a displacement ship does not reach a speed: one of another scale, or in knots."""
    fastest = float(np.abs(u).max())
    froude = fastest / math.sqrt(GRAVITY * length)
    doubt = f"{fastest:.3g} m/s is a Froude number of {froude:.2g}, and displacement ships do not reach {MOST_FROUDE:g}"
    return (f"{doubt}: is it the speed of the ship at full scale, or in knots?",) if froude > MOST_FROUDE else ()


def water_notes(waterway: Waterway | None, depth: float | None) -> tuple[str, ...]:
    """Notes on a passage: where the waterway lies, and the depth of the model if the waterway has none."""
    if waterway is None:
        return () if depth else ("The depth of the canal is not known, so squat and the bottom are not counted.",)
    place = f"The waterway {waterway.name} lies {waterway.place_check}." if waterway.place else ""
    own = f"The waterway {waterway.name} has no depth; that of the model, {depth or 0:.4g} m, is used."
    none = f"The depth of the waterway {waterway.name} is not known, so squat and the bottom are not counted."
    return tuple(filter(None, (place, (own if depth else none) if waterway.depths is None else "")))
