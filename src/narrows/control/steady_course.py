"""Rudder and drift that hold a ship at an offset in equilibrium; revolutions that hold its speed."""

from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.codegen.cache import compiled_loops, import_generated
from narrows.codegen.choices import Actuated, Law
from narrows.codegen.free_motion import INPUTS as FORCES
from narrows.codegen.trace import trace_of
from narrows.model.model import Model
from narrows.simulation.grid import grid_of
from narrows.simulation.initial_state import self_propulsion
from narrows.simulation.inputs import INPUTS, check_workers
from narrows.simulation.kernel_run import cores, in_threads
from narrows.simulation.outcome import section_notes
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.codegen.system import System


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
    samples : int
        Number of coefficient samples from the fit's covariance, along a dimension ``sample``.
    seed : int
        Seed of the samples.
    workers : int, optional
        Threads; all cores unless given.
    **vary : number, sequence or DataArray
        As in ``ensemble``: y [m], u [m/s], heave [m], Y [N], N [N m], particulars, coefficients.

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
    courses = xr.Dataset(data, coords=grid.coordinates(), attrs={"notes": "\n".join(notes)})
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
    inputs = {**dict.fromkeys((*INPUTS, "path_curvature", "current"), 0.0), **ship.values(), **values}
    inputs |= {FORCES[name]: inputs[name] for name in INPUTS}
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

    from narrows.codegen.derivatives import with_tangents
    from narrows.codegen.free_motion import STATE
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


def with_propulsion(model: Model, vary: dict[str, object]) -> dict[str, object]:
    if not model.terms.propelled or "revolutions" in vary:
        return vary
    speed: Any = vary["u"]
    if not isinstance(speed, xr.DataArray):
        column = np.asarray(speed, float)
        speed = xr.DataArray(column, dims=["u"], coords={"u": column}) if column.ndim else float(column)
    found = xr.apply_ufunc(lambda u: self_propulsion(model, float(u)), speed, vectorize=True, keep_attrs=True)
    return {**vary, "revolutions": found}
