"""How fast a ship may be along a waterway: what the envelope of each section leaves safe, and what its bend does."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.control.linearization import linearize
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.safety.envelope import safe_envelope
from narrows.safety.result import SafeEnvelope
from narrows.safety.settings import BEND_SPEEDS, RESERVE
from narrows.simulation.inputs import check_waterway

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


def speed_limits(
    model: Model, waterway: "Waterway", places: Sequence[float], *, y: float = 0.0, reserve: float = RESERVE,
    **envelope: Any,
) -> list[tuple[float, float]]:  # fmt: skip
    """Find the highest safe speed of some sections of a waterway, as a governor of the speed takes them.

    Parameters
    ----------
    model : Model
        Of the ship at its own size, with the terms of a rudder.
    waterway : Waterway
        Where it is.
    places : sequence of float [m]
        Along it, rising: each section is taken to go on to the next.
    y : float [m]
        To starboard of the line.
    reserve : float [1]
        Of the rudder, to be left on the steady course, that of the bend too.
    **envelope : Any
        As for ``safe_envelope``.

    Returns
    -------
    list of pairs (x [m], speed [m/s])
        Through the water.

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
    section, canal = waterway.section(place), waterway.canal(place)
    canal = canal if canal.depth is not None else replace(canal, depth=model.configuration.canal.depth)
    local = replace(model, configuration=replace(model.configuration, canal=canal))
    straight = safe_envelope(local, np.array([y - float(section.middle)]), reserve=reserve, **asked)
    top = float(straight.highest_speed()[0])
    if not np.isfinite(top):
        raise InputError(f"no speed is safe {place:g} m along the way: {_why(straight)}; hold another line there")
    speeds = np.linspace(top / BEND_SPEEDS, top, BEND_SPEEDS)
    turning = linearize(model, y, speeds, waterway=waterway, at=place).course["rudder"].ravel()
    left = np.abs(turning) <= (1 - reserve) * model.configuration.gear.limit
    if not left.any():
        raise InputError(f"the bend {place:g} m along the way asks for more rudder than its reserve leaves")
    return float(speeds[left].max())


def _why(straight: SafeEnvelope) -> str:
    return straight.untested or str(straight.limited_by()[0])
