"""Steady courses near a bank, in a bend and in a current: rudder, drift and revolutions, and the linear motion."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean
from narrows.codegen.cache import compiled_loops, import_generated
from narrows.codegen.free_motion import INPUTS, STATE, Actuated, Law, Surge
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.trace import trace_of
from narrows.control.linear_system import LinearSystem
from narrows.model.model import Model
from narrows.quantities.names import FORCES, Number
from narrows.simulation.grid import AliasedDataset, grid_of, labelled
from narrows.simulation.initial_state import self_propulsion
from narrows.simulation.inputs import check_waterway, check_workers, finite_numbers
from narrows.simulation.kernel_run import cores, in_threads
from narrows.simulation.outcome import section_notes
from narrows.simulation.ship import SimulatedShip
from narrows.waterway.centreline import check_along_only

if TYPE_CHECKING:
    from narrows.codegen.system import System
    from narrows.waterway.waterway import Waterway


RUDDER = "rudder"
BLOCK = 16_384  # Courses per task of a thread


@accept_aliases
def steady_course(
    model: Model, *, samples: int = 0, seed: int = 0, workers: int | None = None, **vary: Any
) -> xr.Dataset:  # fmt: skip
    """Find the rudder, heading and drift that hold a ship steady on a straight course along the canal.

    The speed is constant; a propeller turns as it must straight ahead. If no angle below 69 degrees holds the ship,
    there is no such course: the result is NaN. It has ``rudder``, ``psi`` [rad] and ``v`` [m/s] over the dimensions of
    what varies; ``notes`` names models without a bank force and sections outside the tested range.

    Raises an InputError if the model has no terms of a rudder, a value does not fit, or an unknown is given.

    Parameters
    ----------
    model : Model
        A model with terms of a rudder.
    samples, seed, workers, **vary : int, int, int, number or sequence or DataArray
        As for ``ensemble``: y [m], u [m/s], heave [m], Y [N], N [N m], particulars, coefficients.

    Examples
    --------
    >>> course = nw.steady_course(kcs, y=20.0, u=6.0)
    >>> bool(abs(course.rudder) < np.radians(35.0))
    True
    """
    check_rudder(model)
    for name in ("x", "psi", "v", "r", RUDDER, "X"):
        if name in vary:
            raise InputError(f"a steady course does not take {name!r}: it is computed, or has no effect; leave it out")
    check_workers(workers)
    ship, grid = SimulatedShip(model), grid_of(model, with_propulsion(model, {"u": 1.0, **vary}), samples, seed)
    check_inside(grid.values["y"], grid.values["width"], grid.values["beam"])
    if not (grid.values["u"] > 0).all():
        raise InputError("a steady course needs a speed over 0; give u in m/s")
    values, shape = grid.flat(slice(0, grid.sizes[grid.axis]))
    v, rudder = solve_courses(ship, values, grid.vessels, workers)
    psi = -np.arctan(v / values["u"])
    columns = {"rudder": (rudder, "rad"), "psi": (psi, "rad"), "v": (v, "m/s")}
    data = {name: (list(grid.sizes), c.reshape(shape), {"units": unit}) for name, (c, unit) in columns.items()}
    notes = (*model.bank_notes, *section_notes(model, {**ship.values(), **values}))
    courses = AliasedDataset(data, coords=grid.coordinates(), attrs={"notes": "\n".join(notes)})
    return courses.squeeze("vessel") if list(grid.sizes) == ["vessel"] else courses


def check_rudder(model: Model) -> None:
    if "sin_rudder" not in model.terms.inputs:
        raise InputError(
            "this model has no terms of a rudder; take a ship that has them, such as estimated_kcs (see narrows "
            "ships), make one from main dimensions (narrows estimate), or fit tests with the rudder (--terms steered)"
        )


def check_holds(model: Model, rudder: float, y: float, u: float) -> None:
    """Raise if the rudder of a steady course is beyond its limit, or NaN."""
    gear = model.configuration.gear
    if not abs(rudder) <= gear.limit:
        held = f"no rudder up to {gear.limit_deg:g} degrees holds this ship at y = {y:g} m and {u:g} m/s"
        raise InputError(f"{held}; choose a smaller offset")


def check_inside(y: Any, width: Any, beam: Any) -> None:
    if not np.all(np.abs(y) < (width - beam) / 2):
        far, room = float(np.abs(y).max()), float(np.min((width - beam) / 2))
        raise InputError(f"an offset of {far:g} m has the hull in the bank; stay within {room:.4g} m of the middle")


def solve_courses(
    ship: SimulatedShip, values: Mapping[str, Any], count: int, workers: int | None
) -> tuple[np.ndarray, np.ndarray]:
    """Solve for the sway velocity [m/s] and the rudder angle [rad] of many steady courses."""
    # Newton's method with exact derivatives, compiled. With ``path_curvature`` [1/m] and ``current`` [m/s] the
    # course is a steady turn along a bend.
    from narrows.codegen.addresses import entry
    from narrows.codegen.kernels import loops

    rudder = tuple(actuator for actuator in ship.actuators if actuator.name == RUDDER)
    system = ship.system(law=law_moving(rudder), pushed="until")
    module = import_generated("balance", system.key, lambda: _balance_text(system))
    balance = entry(module, "balance")
    inputs = {**dict.fromkeys((*FORCES, "path_curvature", "current"), 0.0), **ship.values(), **values}
    inputs |= {INPUTS[name]: inputs[name] for name in FORCES}
    drift, angle = np.empty(count), np.empty(count)

    def run(rows: slice) -> None:
        part = {name: value[rows] if np.size(value) > 1 else value for name, value in inputs.items()}
        part |= system.constants(part)
        size = rows.stop - rows.start
        columns = [np.broadcast_to(np.asarray(part[name], float), size) for name in module.COLUMNS]
        compiled_loops(loops).solve(balance, np.ascontiguousarray(np.stack(columns, axis=1)), drift[rows], angle[rows])

    workers = workers or cores()
    in_threads(run, [slice(i, min(i + BLOCK, count)) for i in range(0, count, BLOCK)], workers)
    return drift * np.asarray(inputs["u"], float), angle


@lru_cache(maxsize=16)
def law_moving(actuators: tuple[Actuated, ...]) -> Law:
    """Return a law that makes the positions of actuators variables; its orders are not used."""
    names = {actuator.name: actuator.name for actuator in actuators}
    return Law(trace_of(vars, names, "what moves"), (), actuators)


def _balance_text(system: "System") -> str:
    """Write the module of a ship's ``balance`` on a steady course, with the names of its inputs in ``COLUMNS``."""
    import sympy

    from narrows.codegen.kernel import with_tangents
    from narrows.codegen.lines import FUNCTIONS, Lines, real
    from narrows.codegen.printers.python import Arithmetic, module_text

    lines, (drift, angle) = Lines(), (real("drift"), real("angle"))
    cosine = lines.put("cos_psi", (1 + drift * drift) ** sympy.Rational(-1, 2))
    at = {name: real(name) for name in (*STATE, *system.rates.moving)}
    sway = lines.put("v", drift * real("u"))
    pace = lines.put("pace", real("u") * cosine + sway * drift * cosine + real("current"))
    at |= {"cos_psi": cosine, "sin_psi": lines.put("sin_psi", -drift * cosine), "v": sway}
    at |= {
        "r": lines.put("r", real("path_curvature") * pace),
        f"cos_{RUDDER}": lines.put("cos_angle", FUNCTIONS["cosine"](angle)),
        f"sin_{RUDDER}": lines.put("sin_angle", FUNCTIONS["sine"](angle)),
    }
    rates = system.rates.written(lines, "", at)
    unit = {drift: [sympy.Integer(1), sympy.Integer(0)], angle: [sympy.Integer(0), sympy.Integer(1)]}
    more, slopes = with_tangents(lines, unit, 2)
    out = [rates["v"], rates["r"], *slopes(rates["v"]), *slopes(rates["r"])]
    program, printer = more.needed_for(out), Arithmetic()
    inputs = tuple(name for name in program.inputs if name not in ("drift", "angle"))
    body = [f"{name} = inputs[{number}]" for number, name in enumerate(inputs)]
    body += [f"{name} = {printer.doprint(value)}" for name, value in program.assignments]
    body.append(f"return {', '.join(printer.doprint(value) for value in out)}")
    text = "\n    ".join(["@quiet\ndef balance(drift, angle, inputs):", *body]) + "\n"
    return module_text(16, f"COLUMNS = {inputs!r}", text)


def revolutions_ahead(model: Model, u: np.ndarray) -> np.ndarray:
    """Return the revolutions that keep each speed straight ahead [1/s]."""
    speeds, index = np.unique(u, return_inverse=True)
    return np.array([self_propulsion(model, float(speed)) for speed in speeds])[index].reshape(np.shape(u))


def with_propulsion(model: Model, vary: dict[str, object]) -> dict[str, object]:
    if not model.terms.propelled or "revolutions" in vary:
        return vary
    speed = labelled("u", vary["u"])
    return {**vary, "revolutions": speed.copy(data=revolutions_ahead(model, speed.to_numpy()))}


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

    def rates(self, at: Mapping[str, Any]) -> dict[str, Any]:
        y, curvature = at["y"], at.get("curvature", 0.0)
        rates = self.ship.rates(self.values, {"x": 0.0, **at, "y": y - self.water.middle})
        along = (rates["x"] + at.get("current", 0.0)) / (1 - curvature * y)
        return {name: rates[name] for name in MOVED} | {"psi": at["r"] - curvature * along}

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
    model: Model, y: float = 0.0, u: float = 1.0, *, waterway: "Waterway | None" = None, at: float = 0.0,
    surge: Surge = "held", surge_inertia: float | None = None, **values: float,
) -> LinearSystem:  # fmt: skip
    """Linearise a ship exactly about its steady course at an offset and a speed.

    A ship without a rudder is held on the line, along it, by external forces, which the course gives. In a bend the
    course is the steady turn along it. The section of a waterway is assumed constant at the place.

    Source: Fossen (2021), Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., section 7.2.

    Parameters
    ----------
    model, y, u : Model, float, float
        Offset to starboard of the canal's centreline or of the waterway's line [m], surge velocity through the water
        [m/s].
    waterway, at : Waterway, float [m], optional
        Waterway instead of the model's own canal, and the place along it.
    surge, surge_inertia : str, float [kg], optional
        As for ``simulate``. With a ``free`` speed, a state, the propeller keeps the revolutions of this speed straight
        ahead; a force X, part of the course, balances the remaining resistance.
    **values : float [SI]
        External forces Y [N] and N [N m], heave [m], revolutions [1/s], other particulars and coefficients.
    """
    water, ship = local_water(model, waterway, at), SimulatedShip(model, surge, surge_inertia)
    terms = model.terms
    if "rudder" in values:
        raise InputError("the rudder that holds the ship straight is sought: leave it out, or give a moment N")
    known = {*model.configuration.values(), *terms.names, "heave", "Y", "N", *(one.name for one in terms.actuators)}
    for name in values:
        if name not in known:
            raise InputError(f"a linearisation has no {name!r}{did_you_mean(name, known)}")
    given, (y, u) = finite_numbers(**values), finite_numbers(y=y, u=u).values()
    if not u > 0:
        raise InputError("a steady course needs a speed over 0; give u in m/s")
    width, beam = given.get("width", water.width), given.get("beam", model.configuration.ship.beam)
    check_inside(y - water.middle, width, beam)
    motion, courses = steady_courses(ship, water, np.array([y]), np.array([u]), given)
    course = {name: float(column[0]) for name, column in courses.items()}
    if np.isnan(course.get("rudder", 0.0)):
        raise InputError(f"no rudder holds this ship at y = {y:g} m and {u:g} m/s; choose a smaller offset")
    states = tuple(name for name in MOVED if name != "u" or surge == "free")
    controls = tuple(actuator.name for actuator in ship.actuators)
    disturbances, slopes = (*HOLDING[surge], *WATER), motion.slopes(courses)
    rows = [MOVED.index(name) for name in states]
    A, B, G = (
        np.array([slopes[name][0, rows] for name in names]).reshape(-1, len(rows)).T
        for names in (states, controls, disturbances)
    )
    gear, notes = model.configuration.gear, [*model.bank_notes]
    if abs(course.get("rudder", 0.0)) > gear.limit:
        notes.append(f"this course needs more than the {gear.limit_deg:g} degrees that the rudder turns")
    if surge == "held" and "revolutions" in controls:
        notes.append("the speed is held, so that revolutions change the flow over the rudder alone")
    length = model.configuration.ship.length
    return LinearSystem(A, B, G, states, controls, disturbances, course, length, tuple(notes))


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
    movers: dict[str, Any] = {a.name: given.get(a.name, a.rest or 0.0) for a in terms.actuators if a.name != "rudder"}
    fixed = {**ship.values(**movers), **water.sections, **{n: v for n, v in given.items() if n not in forces}}
    if terms.propelled and "revolutions" not in given:
        movers["revolutions"] = revolutions_ahead(ship.model, u)
    motion, bend, v = LocalMotion(ship, water, fixed), water.curvature / (1 - water.curvature * y), np.zeros(len(y))
    if is_steered:
        known = {**fixed, **forces, **movers, "path_curvature": bend, "current": water.current}
        v, movers["rudder"] = solve_courses(ship, {**known, "y": y - water.middle, "u": u}, len(y), 1)
    psi = 0.0 - np.arctan(v / u)
    speed_along = u * np.cos(psi) - v * np.sin(psi) + water.current
    found = {"y": y, "u": u, "psi": psi, "v": v, "r": bend * speed_along, **movers, **dict.fromkeys(sought, 0.0)}
    found |= {**forces, "current": water.current, "curvature": water.curvature}
    course = {name: np.broadcast_to(np.asarray(value, float), y.shape) for name, value in found.items()}
    if sought:
        rows = [MOVED.index(rate) for rate in sought.values()]
        slopes, rates = motion.slopes(course), motion.rates(course)
        matrix = np.stack([slopes[name][:, rows] for name in sought], axis=-1)
        residual_rates = np.stack([np.broadcast_to(rates[name], y.shape) for name in sought.values()], axis=-1)
        course |= dict(zip(sought, -np.linalg.solve(matrix, residual_rates[..., None])[..., 0].T, strict=True))
    return motion, course
