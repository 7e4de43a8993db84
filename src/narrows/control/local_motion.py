"""Rates of the motion at a place along a waterway, with exact derivatives."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.codegen.free_motion import INPUTS, STATE
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.system import System
from narrows.control.steady_course import moving
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.quantities.names import FORCES, Number
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.simulation.ship import SimulatedShip
from narrows.waterway.current_profile import check_along_only

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

MOVED = ("y", "psi", "u", "v", "r")
WATER = ("current", "curvature")


@dataclass(frozen=True)
class LocalWater:
    """The water at a place, or at many, assumed constant along the line."""

    width: Any  # Width of the section [m]
    # Width and depth for the terms instead of the model's own canal [m]
    sections: Mapping[str, Any] = field(default_factory=dict)
    middle: Any = 0.0  # Middle of the section, to starboard of the line [m]
    curvature: Any = 0.0  # Curvature of that line, to starboard [1/m]
    current: Any = 0.0  # Current along it [m/s]


@dataclass(frozen=True)
class LocalMotion:
    """Rates of y, psi, u, v, r of one ship, or of many if values are columns."""

    # ``at`` has these five, positions of actuators, external forces X, Y, N, and ``current`` and ``curvature`` of the
    # line that y and psi refer to; the default is 0.

    ship: SimulatedShip  # The model, and whether its speed is constant
    water: LocalWater  # The local water
    values: Mapping[str, Number]  # Particulars and coefficients by name

    @cached_property
    def _system(self) -> System:
        return self.ship.system(law=moving(self.ship.actuators), pushed="until")

    @cached_property
    def _constants(self) -> dict[str, Number]:
        return self._system.constants(self.values)

    def rates(self, at: Mapping[str, Any]) -> dict[str, Any]:
        """Return the rates, computed by the engine's own lines."""
        columns, inputs = self._system.columns, dict(self._constants)
        inputs |= {INPUTS[force]: at.get(force, 0.0) for force in FORCES}
        for actuator in self.ship.model.terms.actuators:
            inputs |= actuator.placed(at.get(actuator.name, 0.0))
        psi, y = at["psi"], at["y"]
        state = (0.0, y - self.water.middle, np.cos(psi), np.sin(psi), at["u"], at["v"], at["r"])
        found = columns.rates(*state, *(inputs[name] for name in columns.RATES_INPUTS))
        rates = dict(zip(STATE, found, strict=True))
        along = (rates["x"] + at.get("current", 0.0)) / (1 - at.get("curvature", 0.0) * y)
        return {"psi": at["r"] - at.get("curvature", 0.0) * along, **{n: rates[n] for n in MOVED if n != "psi"}}

    def slopes(self, at: Mapping[str, Any]) -> dict[str, np.ndarray]:
        """Return the derivatives of the five rates by each quantity: a column (..., 5) by each name."""
        shifted = {**at, "y": at["y"] - self.water.middle} | {INPUTS[f]: at.get(f, 0.0) for f in FORCES}
        matrix = along_line(self.ship.linearisation(self.values).linear(shifted), at)
        names = (*LINEARISED, *FORCES, *(actuator.name for actuator in self.ship.actuators))
        rows = [LINEARISED.index(name) for name in MOVED]
        columns = {name: matrix[..., rows, index] for index, name in enumerate(names)}
        curvature, pace, room = _along(at)
        for name, slope in (("current", -curvature / room), ("curvature", -pace / room)):
            columns[name] = np.zeros((*matrix.shape[:-2], len(MOVED)))
            columns[name][..., MOVED.index("psi")] = slope
        return columns


def along_line(matrix: np.ndarray, at: Mapping[str, Any]) -> np.ndarray:
    """Return derivatives of the rates in the frame of a curved line, (..., 6, n), from those in a straight frame."""
    # The line turns under the ship by its curvature times the speed along it.
    curvature, pace, room = _along(at)
    if not np.any(curvature):
        return matrix
    x, y, psi = (LINEARISED.index(name) for name in ("x", "y", "psi"))
    matrix = matrix.copy()
    matrix[..., psi, :] -= np.asarray(curvature / room)[..., None] * matrix[..., x, :]
    matrix[..., psi, y] -= curvature**2 * pace / room
    return matrix


def _along(at: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Curvature of the line, speed along it, and the share of its radius between centre and ship."""
    curvature, current = (np.asarray(at.get(name, 0.0), float) for name in WATER[::-1])
    room = 1 - curvature * at["y"]
    return curvature, (at["u"] * np.cos(at["psi"]) - at["v"] * np.sin(at["psi"]) + current) / room, room


def local_water(model: Model, waterway: "Waterway | None", at: float) -> LocalWater:
    finite_numbers(at=at)
    check_waterway(waterway)
    if waterway is None:
        if at:
            raise InputError(f"at = {at:g} m is a place along a waterway; give one, or leave it out")
        return LocalWater(model.configuration.canal.width)
    if not 0 <= at <= waterway.line.length:
        raise InputError(f"at = {at:g} m is beyond {waterway.name}, 0 to {waterway.line.length:.0f} m; choose a place")
    waterway.check_fits(model.configuration.ship, at)
    check_along_only(waterway, "a steady course")
    canal, section = waterway.canal(at), waterway.section(at)
    depth = canal.depth if canal.depth is not None else model.configuration.canal.depth
    sections = {"width": canal.width} | ({} if depth is None else {"depth": depth})
    current = float(waterway.current_at(at))
    return LocalWater(canal.width, sections, float(section.middle), float(section.curvature), current)
