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
    """The water at a place, taken to go on as it is there."""

    width: float  # Of the section [m]
    # What the terms are told of it instead of the model's own canal: width and depth [m]
    sections: Mapping[str, float] = field(default_factory=dict)
    middle: float = 0.0  # Of the section, to starboard of the line that offsets count from [m]
    curvature: float = 0.0  # Of that line, to starboard [1/m]
    current: float = 0.0  # Along it [m/s]


def local_water(model: Model, waterway: "Waterway | None", at: float) -> LocalWater:
    """Return the water at a place of a waterway, or the model's own canal."""
    # at [m]
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
