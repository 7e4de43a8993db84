"""Linearise the motion about steady courses near a bank, in a bend and in a current."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.aliases import accept_aliases
from narrows.codegen.free_motion import Surge
from narrows.control.linear_system import LinearSystem
from narrows.control.local_motion import MOVED, WATER, LocalMotion, LocalWater, local_water
from narrows.control.steady_course import check_inside, solved
from narrows.errors import InputError, did_you_mean
from narrows.model.model import Model
from narrows.simulation.inputs import finite_numbers
from narrows.simulation.self_propulsion import self_propulsion
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

Columns = dict[str, np.ndarray]
FORCES = {"held": ("Y", "N"), "free": ("X", "Y", "N")}


@accept_aliases
def linearize(
    model: Model, y: Any = 0.0, u: Any = 1.0, *, waterway: "Waterway | None" = None, at: float = 0.0,
    surge: Surge = "held", surge_inertia: float | None = None, **values: float,
) -> LinearSystem:  # fmt: skip
    """Linearise a ship exactly about its steady course at an offset and a speed.

    A ship without a rudder is held on the line, along it, by external forces, which the course gives. In a bend the
    course is the steady turn along it. The section of a waterway is assumed constant at the place.

    Parameters
    ----------
    model : Model
        A model with or without terms of a rudder.
    y : float or array [m]
        Offset to starboard of the canal's centreline or of the waterway's line; an array is a dimension of that name.
    u : float or array [m/s]
        Surge velocity through the water, likewise.
    waterway : Waterway, optional
        Waterway instead of the model's own canal.
    at : float [m]
        Place along it.
    surge : str
        ``held``: constant speed; ``free``: it is a state. The propeller turns as the steady course needs; without one a
        force X drives the ship.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` if a_udot was not identifiable.
    **values : float [SI]
        External forces Y [N] and N [N m], heave [m], revolutions [1/s], particulars and coefficients other than the
        model's, as in ``ensemble``.

    Returns
    -------
    LinearSystem
        ``A``, ``B``, ``G`` with named rows and columns, the course, and conversion to python-control.

    Raises
    ------
    InputError
        If a name is unknown, the hull is in a bank, the ship does not fit, or no rudder angle holds a single course.

    References
    ----------
    Fossen (2021), Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., section 7.2, for the form.
    """
    water, ship = local_water(model, waterway, at), SimulatedShip(model, surge, surge_inertia)
    given = _checked(ship, values)
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
        raise InputError(
            f"no rudder holds this ship {offsets[0]:g} m off the middle at {speeds[0]:g} m/s; choose a place nearer to "
            "it"
        )
    return _system(motion, course, varied)


def _column(name: str, value: Any) -> np.ndarray:
    try:
        column = np.atleast_1d(np.asarray(value, float))
    except (TypeError, ValueError):
        column = np.array([np.nan])
    if column.ndim > 1 or not column.size or not np.isfinite(column).all():
        raise InputError(f"{name} = {value} is neither a finite number nor a sequence of them; mend it")
    return column


def _checked(ship: SimulatedShip, values: Mapping[str, float]) -> dict[str, float]:
    terms = ship.model.terms
    known = {*ship.model.configuration.values(), *terms.names, "heave", "Y", "N", *(a.name for a in terms.actuators)}
    if "rudder" in values:
        raise InputError("the rudder that holds the ship straight is sought: leave it out, or give a moment N")
    for name in values:
        if name not in known:
            raise InputError(f"a linearisation has no {name!r}{did_you_mean(name, known)}")
    if ship.surge == "free" and "revolutions" in values:
        raise InputError("revolutions are sought where the speed is free: leave them out, or hold the speed")
    return finite_numbers(**values)


def steady_courses(
    ship: SimulatedShip, water: LocalWater, y: np.ndarray, u: np.ndarray, given: Mapping[str, float]
) -> tuple[LocalMotion, Columns]:
    """Solve for the steady courses, with the propeller's revolutions if the speed is free."""
    if "sin_rudder" not in ship.model.terms.inputs:
        return _towed(ship, water, y, u, given)
    forces = {name: given.get(name, 0.0) for name in ("Y", "N")}
    movers = {a.name: given.get(a.name, a.rest or 0.0) for a in ship.model.terms.actuators if a.name != "rudder"}
    fixed = {**ship.values(**movers), **water.sections, **{n: v for n, v in given.items() if n not in forces}}
    motion = LocalMotion(ship, water, fixed)
    bend = water.curvature / (1 - water.curvature * y)
    turns = _turns(ship.model, u, given)
    for _ in range(30):  # Newton's method; it takes four or five
        sought = {**fixed, **forces, **turns, "path_curvature": bend, "current": water.current}
        v, rudder = solved(ship, {**sought, "y": y - water.middle, "u": u}, len(y), 1)
        psi = -np.arctan(v / u)
        pace = u * np.cos(psi) - v * np.sin(psi) + water.current
        course = {"y": y, "u": u, "psi": psi, "v": v, "r": bend * pace, "rudder": rudder, **movers, **turns, **forces}
        course |= {"current": water.current, "curvature": water.curvature}
        course = {name: np.broadcast_to(np.asarray(value, float), y.shape) for name, value in course.items()}
        change = _to_balance(motion, course) if ship.surge == "free" and turns else np.zeros(1)
        if not (np.abs(change) > 1e-11 * np.abs(course.get("revolutions", change))).any():
            break
        turns = {"revolutions": turns["revolutions"] + np.nan_to_num(change)}
    if ship.surge == "free":
        course["X"] = np.zeros(len(y))
        if not turns:  # Without a propeller a force keeps the ship's speed
            course["X"] = -motion.rates(course)["u"] / motion.slopes(course)["X"][..., MOVED.index("u")]
    return motion, course


def _towed(
    ship: SimulatedShip, water: LocalWater, y: np.ndarray, u: np.ndarray, given: Mapping[str, float]
) -> tuple[LocalMotion, Columns]:
    """Hold ships without a rudder along their lines by sway force and yaw moment, and at a free speed surge force."""
    held = FORCES[ship.surge]
    for name in held:
        if name in given:
            raise InputError(f"{name} is what holds a ship without a rudder on its line: it is sought; leave it out")
    movers: dict[str, Any] = {a.name: given.get(a.name, a.rest or 0.0) for a in ship.model.terms.actuators}
    movers |= _turns(ship.model, u, given)
    motion = LocalMotion(ship, water, {**ship.values(**movers), **water.sections, **given})
    turn = water.curvature / (1 - water.curvature * y) * (u + water.current)
    course = {"y": y, "u": u, "psi": 0.0, "v": 0.0, "r": turn, **movers, **dict.fromkeys(("Y", "N", *held), 0.0)}
    course |= {"current": water.current, "curvature": water.curvature}
    course = {name: np.broadcast_to(np.asarray(value, float), y.shape) for name, value in course.items()}
    rows = [MOVED.index(name) for name in ("u", "v", "r")[-len(held) :]]
    slopes, rates = motion.slopes(course), motion.rates(course)
    matrix = np.stack([slopes[name][:, rows] for name in held], axis=-1)
    away = np.stack([np.broadcast_to(rates[MOVED[row]], y.shape) for row in rows], axis=-1)
    forces = -np.linalg.solve(matrix, away[..., None])[..., 0]
    return motion, {**course, **dict(zip(held, forces.T, strict=True))}


def _turns(model: Model, u: np.ndarray, given: Mapping[str, float]) -> Columns:
    """Revolutions that keep the speed straight ahead, if the terms use any."""
    if not model.terms.propelled:
        return {}
    if "revolutions" in given:
        return {"revolutions": np.full(len(u), given["revolutions"])}
    speeds, index = np.unique(u, return_inverse=True)
    return {"revolutions": np.array([self_propulsion(model, float(speed)) for speed in speeds])[index]}


def _to_balance(motion: LocalMotion, course: Mapping[str, Any]) -> np.ndarray:
    """Newton's step of the revolutions towards a steady speed; drift, heading and rudder follow."""
    slopes, free = motion.slopes(course), [MOVED.index(name) for name in ("u", "v", "r")]
    u, v = course["u"], course["v"]
    # On a course there is no sway over the ground: psi = -arctan(v / u).
    by_drift = slopes["v"] - slopes["psi"] * (u / (u**2 + v**2))[:, None]
    matrix = np.stack([column[:, free] for column in (slopes["revolutions"], by_drift, slopes["rudder"])], axis=-1)
    rates = motion.rates(course)
    residual = np.stack(np.broadcast_arrays(*(rates[name] for name in ("u", "v", "r"))), axis=-1)
    known = np.isfinite(matrix).all(axis=(1, 2))
    change = np.full(len(u), np.nan)
    change[known] = -np.linalg.solve(matrix[known], residual[known, :, None])[:, 0, 0]
    return change


def _system(motion: LocalMotion, course: Columns, varied: Columns) -> LinearSystem:
    ship, shape = motion.ship, tuple(len(column) for column in varied.values())
    states = tuple(name for name in MOVED if name != "u" or ship.surge == "free")
    controls = tuple(actuator.name for actuator in ship.actuators)
    disturbances = (*FORCES[ship.surge], *WATER)
    slopes, rows = motion.slopes(course), [MOVED.index(name) for name in states]

    def matrix(names: Sequence[str]) -> np.ndarray:
        none = np.zeros((len(course["y"]), len(rows), 0))
        columns = np.stack([slopes[name][:, rows] for name in names], axis=-1) if names else none
        return columns.reshape(*shape, len(states), len(names))

    gear = ship.model.configuration.gear
    beyond = int((np.abs(course.get("rudder", np.zeros(1))) > gear.limit).sum())
    notes = [*ship.model.bank_notes]
    if beyond:
        notes.append(f"{beyond} of these courses need more than the {gear.limit_deg:g} degrees that the rudder turns")
    if ship.surge == "held" and "revolutions" in controls:
        notes.append("the speed is held, so that revolutions change the flow over the rudder alone")
    courses = {name: column.reshape(shape) for name, column in course.items()}
    return LinearSystem(
        matrix(states), matrix(controls), matrix(disturbances), states, controls, disturbances,
        courses, tuple(varied), motion,
        ship.model.configuration.ship.length, tuple(notes),
    )  # fmt: skip
