"""Sections of a waterway for the safe envelope, and the highest safe speeds along it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.safety.envelope import safe_envelope
from narrows.safety.result import SafeEnvelope
from narrows.safety.settings import RESERVE
from narrows.simulation.inputs import check_waterway
from narrows.waterway.current_profile import check_along_only

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


@dataclass(frozen=True)
class Reach:
    model: Model  # The model in the canal of that section
    middle: float  # Middle of that section, to starboard of the line [m]
    asked: dict[str, Any]  # Options of ``safe_envelope`` other than offsets and speeds


def reach_at(model: Model, waterway: "Waterway", at: float) -> Reach:
    """Return a place of a waterway; its curvature is that of the middle of the section."""
    ship = model.configuration.ship
    waterway.check_fits(ship, at)
    check_along_only(waterway, "an envelope")
    section, canal, room = waterway.section(at), waterway.canal(at), waterway.keel_section(at, ship.draft)
    canal = canal if canal.depth else replace(canal, depth=model.configuration.canal.depth)
    middle, bend = float(section.middle), float(section.curvature)
    aside, half = float(room.middle) - middle, float(room.width) / 2
    there = replace(model, configuration=replace(model.configuration, canal=canal))
    asked = {
        "walls": (half - aside, half + aside), "curvature": bend / (1 - bend * middle),
        "current": float(waterway.current_at(at)),
    }  # fmt: skip
    return Reach(there, middle, asked)


def speed_limits(
    model: Model, waterway: "Waterway", places: Sequence[float], *, y: float = 0.0, reserve: float = RESERVE,
    **envelope: Any,
) -> list[tuple[float, float]]:  # fmt: skip
    """Find the highest safe speed of some sections of a waterway, for a speed governor.

    Parameters
    ----------
    model : Model
        A model at the ship's own size, with the terms of a rudder.
    waterway : Waterway
        The waterway.
    places : sequence of float [m]
        Places along it, rising; each section is assumed constant to the next.
    y : float [m]
        Offset to starboard of the line.
    reserve : float [1]
        Rudder in reserve on the steady course (in a bend on the steady turn), for 95 % of the samples.
    **envelope : Any
        Options of ``safe_envelope``.

    Returns
    -------
    list of pairs (x [m], speed [m/s])
        Speeds through the water.

    Raises
    ------
    InputError
        If no speed is safe at a place, or there is none.
    """
    check_waterway(waterway)
    if waterway is None:
        raise InputError("speed limits are along a waterway; give one")
    if not len(places):
        raise InputError("no place is given; name some along the waterway")
    return [(float(place), _highest(model, waterway, float(place), y, reserve, envelope)) for place in places]


def _highest(
    model: Model, waterway: "Waterway", place: float, y: float, reserve: float, asked: dict[str, Any]
) -> float:
    reach = reach_at(model, waterway, place)
    there = safe_envelope(
        reach.model, np.array([y - reach.middle]), reserve=reserve, **{**reach.asked, **asked}
    )  # fmt: skip
    top = float(there.highest_speed()[0])
    if not np.isfinite(top):
        raise InputError(f"no speed is safe {place:g} m along the way: {_why(there)}; hold another line there")
    return top


def _why(straight: SafeEnvelope) -> str:
    return straight.untested or str(straight.limited_by()[0])
