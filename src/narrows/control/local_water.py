"""The water at a place, as steady courses and helms ask for it: a section, the curvature of the line, the current."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.inputs import check_waterway, finite_numbers

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


@dataclass(frozen=True)
class LocalWater:
    """The water at a place, taken to go on as it is there.

    Parameters
    ----------
    width : float [m]
        Of the section.
    sections : mapping of str to float
        What the terms are told of it instead of the model's own canal: width and depth [m].
    middle : float [m]
        Of the section, to starboard of the line that offsets count from.
    curvature : float [1/m]
        Of that line, to starboard.
    current : float [m/s]
        Along it.
    """

    width: float
    sections: Mapping[str, float] = field(default_factory=dict)
    middle: float = 0.0
    curvature: float = 0.0
    current: float = 0.0


def local_water(model: Model, waterway: "Waterway | None", at: float) -> LocalWater:
    """Return the water at a place of a waterway, or the model's own canal (ours).

    Parameters
    ----------
    model : Model
        Its canal gives the depth where the waterway has none.
    waterway : Waterway, optional
        Where the ship is instead of that canal.
    at : float [m]
        Along the line.

    Raises
    ------
    InputError
        Where the place is beyond the waterway, or the ship does not fit there.
    """
    finite_numbers(at=at)
    check_waterway(waterway)
    if waterway is None:
        if at:
            raise InputError(f"at = {at:g} m is a place along a waterway; give one, or leave it out")
        return LocalWater(model.configuration.canal.width)
    if not 0 <= at <= waterway.line.length:
        raise InputError(f"at = {at:g} m is beyond {waterway.name}, 0 to {waterway.line.length:.0f} m; choose a place")
    waterway.check_fits(model.configuration.ship, at)
    canal, section = waterway.canal(at), waterway.section(at)
    depth = canal.depth if canal.depth is not None else model.configuration.canal.depth
    sections = {"width": canal.width} | ({} if depth is None else {"depth": depth})
    return LocalWater(canal.width, sections, float(section.middle), float(section.curvature), waterway.current)
