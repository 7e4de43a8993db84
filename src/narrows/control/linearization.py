"""Linearise the motion about steady courses near a bank, in a bend and in a current."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean
from narrows.codegen.free_motion import INPUTS, STATE, Surge
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.system import System
from narrows.control.linear_system import LinearSystem
from narrows.control.steady_course import check_inside, law_moving, solve_courses
from narrows.model.model import Model
from narrows.quantities.names import FORCES, Number
from narrows.simulation.initial_state import self_propulsion
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.simulation.ship import SimulatedShip
from narrows.waterway.centreline import check_along_only

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

Columns = dict[str, np.ndarray]
MOVED = ("y", "psi", "u", "v", "r")
WATER = ("current", "curvature")
# External forces by surge, and the rates that they keep at 0.
HOLDING = {"held": {"Y": "v", "N": "r"}, "free": {"X": "u", "Y": "v", "N": "r"}}


@dataclass(frozen=True)
class LocalWater:
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
        return self.ship.system(law=law_moving(self.ship.actuators), pushed="until")

    @cached_property
    def _constants(self) -> dict[str, Number]:
        return self._system.constants(self.values)

    def rates(self, at: Mapping[str, Any]) -> dict[str, Any]:
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
        curvature, speed_along, radius_share = _line_motion(at)
        for name, slope in (("current", -curvature / radius_share), ("curvature", -speed_along / radius_share)):
            columns[name] = np.zeros((*matrix.shape[:-2], len(MOVED)))
            columns[name][..., MOVED.index("psi")] = slope
        return columns


def along_line(matrix: np.ndarray, at: Mapping[str, Any]) -> np.ndarray:
    """Return derivatives of the rates in the frame of a curved line, (..., 6, n), from those in a straight frame."""
    # The line turns under the ship by its curvature times the speed along it.
    curvature, speed_along, radius_share = _line_motion(at)
    if not np.any(curvature):
        return matrix
    x, y, psi = (LINEARISED.index(name) for name in ("x", "y", "psi"))
    matrix = matrix.copy()
    matrix[..., psi, :] -= np.asarray(curvature / radius_share)[..., None] * matrix[..., x, :]
    matrix[..., psi, y] -= curvature**2 * speed_along / radius_share
    return matrix


def _line_motion(at: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the line's curvature [1/m], the speed along it [m/s], and the ship's radius over the line's [1]."""
    curvature, current = (np.asarray(at.get(name, 0.0), float) for name in WATER[::-1])
    radius_share = 1 - curvature * at["y"]
    return curvature, (at["u"] * np.cos(at["psi"]) - at["v"] * np.sin(at["psi"]) + current) / radius_share, radius_share


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


@accept_aliases
def linearize(
    model: Model, y: Any = 0.0, u: Any = 1.0, *, waterway: "Waterway | None" = None, at: float = 0.0,
    surge: Surge = "held", surge_inertia: float | None = None, **values: float,
) -> LinearSystem:  # fmt: skip
    """Linearise a ship exactly about its steady course at an offset and a speed.

    A ship without a rudder is held on the line, along it, by external forces, which the course gives. In a bend the
    course is the steady turn along it. The section of a waterway is assumed constant at the place.

    Source: Fossen (2021), Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., section 7.2, for the
    form.

    Parameters
    ----------
    model : Model
        A model with or without terms of a rudder.
    y, u : float or array
        Offset to starboard of the canal's centreline or of the waterway's line [m], surge velocity through the water
        [m/s]; an array is a dimension of that name.
    waterway, at : Waterway, float [m], optional
        Waterway instead of the model's own canal, and the place along it.
    surge : str
        ``held``: constant speed; ``free``: it is a state. The propeller keeps the revolutions of this speed straight
        ahead; a force X, part of the course, balances the remaining resistance.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` if a_udot was not identifiable.
    **values : float [SI]
        External forces Y [N] and N [N m], heave [m], revolutions [1/s], particulars and coefficients other than the
        model's, as in ``ensemble``.
    """
    water, ship = local_water(model, waterway, at), SimulatedShip(model, surge, surge_inertia)
    given = _check_values(ship, values)
    asked = {"y": _column("y", y), "u": _column("u", u)}
    if not (asked["u"] > 0).all():
        raise InputError("a steady course needs a speed over 0; give u in m/s")
    width, beam = given.get("width", water.width), given.get("beam", model.configuration.ship.beam)
    check_inside(asked["y"] - water.middle, width, beam)
    offsets, speeds = (part.ravel() for part in np.meshgrid(asked["y"], asked["u"], indexing="ij"))
    motion, course = steady_courses(ship, water, offsets, speeds, given)
    varied = {name: column for (name, column), number in zip(asked.items(), (y, u), strict=True) if np.ndim(number)}
    known = np.isfinite(course["rudder"]) if "rudder" in course else np.ones(1, bool)
    if not varied and not known.any():
        where = f"at y = {offsets[0]:g} m and {speeds[0]:g} m/s"
        raise InputError(f"no rudder holds this ship {where}; choose a smaller offset")
    return _system(motion, course, varied)


def _column(name: str, value: Any) -> np.ndarray:
    try:
        column = np.atleast_1d(np.asarray(value, float))
    except (TypeError, ValueError):
        column = np.array([np.nan])
    if column.ndim > 1 or not column.size or not np.isfinite(column).all():
        raise InputError(f"{name} = {value} is neither a finite number nor a sequence of them; mend it")
    return column


def _check_values(ship: SimulatedShip, values: Mapping[str, float]) -> dict[str, float]:
    terms = ship.model.terms
    known = {*ship.model.configuration.values(), *terms.names, "heave", "Y", "N", *(a.name for a in terms.actuators)}
    if "rudder" in values:
        raise InputError("the rudder that holds the ship straight is sought: leave it out, or give a moment N")
    for name in values:
        if name not in known:
            raise InputError(f"a linearisation has no {name!r}{did_you_mean(name, known)}")
    return finite_numbers(**values)


def steady_courses(
    ship: SimulatedShip, water: LocalWater, y: np.ndarray, u: np.ndarray, given: Mapping[str, float]
) -> tuple[LocalMotion, Columns]:
    """Solve for the steady courses: the propeller turns as straight ahead, and a force X holds a free speed."""
    # A ship without a rudder is held along its line by sway force and yaw moment too.
    terms = ship.model.terms
    is_steered = "sin_rudder" in terms.inputs
    sought = {force: rate for force, rate in HOLDING[ship.surge].items() if force == "X" or not is_steered}
    for name in sought:
        if name in given:
            raise InputError(f"{name} is what holds a ship without a rudder on its line: it is sought; leave it out")
    forces = {name: given.get(name, 0.0) for name in ("Y", "N")}
    movers = {a.name: given.get(a.name, a.rest or 0.0) for a in terms.actuators if a.name != "rudder"}
    fixed = {**ship.values(**movers), **water.sections, **{n: v for n, v in given.items() if n not in forces}}
    motion, moved = LocalMotion(ship, water, fixed), {**movers, **_revolutions_ahead(ship.model, u, given)}
    bend, v = water.curvature / (1 - water.curvature * y), np.zeros(len(y))
    if is_steered:
        known = {**fixed, **forces, **moved, "path_curvature": bend, "current": water.current}
        v, moved["rudder"] = solve_courses(ship, {**known, "y": y - water.middle, "u": u}, len(y), 1)
    psi = 0.0 - np.arctan(v / u)
    speed_along = u * np.cos(psi) - v * np.sin(psi) + water.current
    found = {"y": y, "u": u, "psi": psi, "v": v, "r": bend * speed_along, **moved, **dict.fromkeys(sought, 0.0)}
    found |= {**forces, "current": water.current, "curvature": water.curvature}
    course = {name: np.broadcast_to(np.asarray(value, float), y.shape) for name, value in found.items()}
    if sought:
        rows = [MOVED.index(rate) for rate in sought.values()]
        slopes, rates = motion.slopes(course), motion.rates(course)
        matrix = np.stack([slopes[name][:, rows] for name in sought], axis=-1)
        residual_rates = np.stack([np.broadcast_to(rates[name], y.shape) for name in sought.values()], axis=-1)
        course |= dict(zip(sought, -np.linalg.solve(matrix, residual_rates[..., None])[..., 0].T, strict=True))
    return motion, course


def _revolutions_ahead(model: Model, u: np.ndarray, given: Mapping[str, float]) -> Columns:
    """Return the revolutions that keep the speed straight ahead, if the terms use any."""
    if not model.terms.propelled:
        return {}
    if "revolutions" in given:
        return {"revolutions": np.full(len(u), given["revolutions"])}
    speeds, index = np.unique(u, return_inverse=True)
    return {"revolutions": np.array([self_propulsion(model, float(speed)) for speed in speeds])[index]}


def _system(motion: LocalMotion, course: Columns, varied: Columns) -> LinearSystem:
    ship, shape = motion.ship, tuple(len(column) for column in varied.values())
    states = tuple(name for name in MOVED if name != "u" or ship.surge == "free")
    controls = tuple(actuator.name for actuator in ship.actuators)
    disturbances = (*HOLDING[ship.surge], *WATER)
    slopes, rows = motion.slopes(course), [MOVED.index(name) for name in states]

    def matrix(names: Sequence[str]) -> np.ndarray:
        columns = [slopes[name][:, rows] for name in names]
        whole = np.stack(columns, axis=-1) if columns else np.zeros((len(course["y"]), len(rows), 0))
        return whole.reshape(*shape, len(states), len(names))

    gear = ship.model.configuration.gear
    beyond = int((np.abs(course.get("rudder", np.zeros(1))) > gear.limit).sum())
    notes = [*ship.model.bank_notes]
    if beyond:
        notes.append(f"{beyond} of these courses need more than the {gear.limit_deg:g} degrees that the rudder turns")
    if ship.surge == "held" and "revolutions" in controls:
        notes.append("the speed is held, so that revolutions change the flow over the rudder alone")
    return LinearSystem(
        matrix(states), matrix(controls), matrix(disturbances), states, controls, disturbances,
        {name: column.reshape(shape) for name, column in course.items()}, tuple(varied), motion.rates,
        ship.model.configuration.ship.length, tuple(notes),
    )  # fmt: skip
