"""What bounds a safe envelope before any trial: the keel, the choking of the canal, the engine, the tests."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from narrows.control.self_propulsion import with_propulsion
from narrows.control.steady_course import steady_course
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.safety.question import EnvelopeQuestion
from narrows.safety.tested import within_tests
from narrows.safety.underkeel import Keel, keel_at


@dataclass(frozen=True)
class Bounds:
    """Where keel, canal, engine and tests leave a ship."""

    under: Keel  # Water under the keel at each speed
    driven: np.ndarray  # (speeds,) Whether the engine turns the propeller as fast as the speed asks
    clear: np.ndarray  # (speeds,) The same, and whether the keel is clear and the canal not choked
    tested: np.ndarray  # (offsets, speeds) Whether the tests covered it

    def columns(self) -> dict[str, tuple[object, ...]]:
        """Return them as variables of the answer, with their dimensions."""
        return {
            "clearance": ("u", self.under.clearance, {"units": "m"}),
            "clear": ("u", self.clear),
            "driven": ("u", self.driven),
            "tested": (("y", "u"), self.tested),
        }


def bounds_of(question: EnvelopeQuestion) -> Bounds:
    """Return what bounds the answer to a question before any trial."""
    model, speeds = question.model, question.speeds
    under, driven = keel_at(model, speeds), _driven(model, speeds, question.most_revolutions)
    floating = (under.clearance >= question.clearance) | (model.configuration.canal.depth is None)
    clear = floating & (speeds < under.choke) & driven
    return Bounds(under, driven, clear, within_tests(model, question.offsets, speeds))


def _driven(model: Model, speeds: np.ndarray, most: float | None) -> np.ndarray:
    """Whether the engine turns the propeller as fast as each speed asks; true where nothing says how fast it turns."""
    if most is None:
        return np.ones(len(speeds), bool)
    if not model.terms.propelled:
        raise InputError(f"most_revolutions = {most} 1/s, but this model has no terms of a propeller; leave it out")
    if not 0 < most < math.inf:
        raise InputError(f"most_revolutions = {most} 1/s drive no ship; give a number over 0")
    asked: object = with_propulsion(model, {"u": speeds})["revolutions"]
    return np.asarray(asked, float) <= most


def rudder_of_a_kick(question: EnvelopeQuestion, under: Keel) -> xr.DataArray:
    """Return the steady rudder with the engine at its most, over offsets and speeds [rad]."""
    course = steady_course(
        question.model, y=question.offsets, u=question.speeds, heave=xr.DataArray(under.midship, dims="u"),
        revolutions=question.most_revolutions,
    )  # fmt: skip
    return course["rudder"].transpose("y", "u").drop_vars(["y", "u"], errors="ignore")
