"""The symbolic equation of motion of a free ship, from the trace of a table of terms.

On the rig a force is F(motion, accelerations); for a free ship F plus the inputs vanishes: 0 = F + F_in. With M =
-dF/d(udot, vdot, rdot) and f = F at zero accelerations, M (udot, vdot, rdot) = f + F_in.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from keyword import iskeyword
from typing import Any, Literal

from narrows.base.errors import InputError
from narrows.codegen.trace import Trace
from narrows.quantities.names import FORCES, PARTICULARS, REGRESSOR_INPUTS
from narrows.ship.actuators import STANDARD

Expr = Any  # A SymPy expression

Surge = Literal["held", "free"]

# Arguments of the right-hand side; its result has their derivatives in the same order.
STATE = ("x", "y", "cos_psi", "sin_psi", "u", "v", "r")

ACCELERATIONS = dict(zip(FORCES, ("udot", "vdot", "rdot"), strict=True))

# External force [N, N, N m], by the component that it is added to.
INPUTS = dict(zip(FORCES, ("X_in", "Y_in", "N_in"), strict=True))

SURGE_INERTIA = "surge_inertia"  # Added mass in surge [kg], an argument if the table's own was not identifiable

# Reserved names, which no coefficient may have: quantities, actuators with their limits, forces, walls.
RESERVED = {
    *REGRESSOR_INPUTS, *INPUTS.values(), SURGE_INERTIA, "wall_starboard", "wall_port",
    *(name for actuator in STANDARD for name in (*actuator.controls, *actuator.particulars)),
    *(f"{actuator.name}_{of}" for actuator in STANDARD for of in ("limit", "rate")),
}  # fmt: skip

# Names that the generated text uses itself.
TEMPORARY = re.compile(r"__.*|[kst]\d+|coefficient_\d+|abs|exp|root|power|constants|minimum|maximum|choice|angle")


@dataclass(frozen=True, eq=False)
class FreeMotion:
    # The acceleration ``i`` is the sum over ``basis`` of ``gains[i]`` times it, plus ``pushes[i]`` times the inputs.

    names: Mapping[str, Expr]  # Every coefficient, particular and input, by the caller's name
    components: tuple[str, ...]  # Forces whose accelerations are solved for
    basis: tuple[Expr, ...]  # Functions of the state that the parameters multiply
    gains: tuple[tuple[Expr, ...], ...]  # One row per acceleration, one column per function of the basis
    pushes: tuple[tuple[Expr, ...], ...]  # Inverse of the mass matrix
    # For each coefficient the force that it contributes to, and its regressor with accelerations
    regressors: Mapping[str, tuple[str, Expr]]


@lru_cache(maxsize=64)
def symbol(name: str) -> Expr:
    import sympy

    signed = name == "x_g" or name.startswith(("propeller_", "rudder_"))
    positive = True if name in PARTICULARS and not signed else None
    return sympy.Symbol(name, real=True, positive=positive)


# Control, waterway and contact do not change these equations: systems of one table share them.
@lru_cache(maxsize=32)
def solve_motion(trace: Trace, force_of: tuple[tuple[str, str], ...], surge: Surge, coriolis: bool) -> FreeMotion:
    """Solve the equation of motion for the accelerations; ``force_of`` pairs each term with its force."""

    from narrows.codegen.lines import FUNCTIONS

    forces = dict(force_of)
    components = tuple(FORCES) if surge == "free" else ("Y", "N")
    names = _coefficient_symbols(trace)
    held = {name: 0 for force, name in ACCELERATIONS.items() if force not in components}
    symbols = {name: held.get(name, symbol(name)) for name in trace.inputs}
    expressions = trace.replay(symbols, exact_number, FUNCTIONS)
    regressors = {name: (forces[name], value) for name, value in expressions.items() if forces[name] in components}
    mass = _mass(regressors, names, components)
    columns = _columns(regressors, names, components, coriolis)
    if mass.det() == 0:
        accelerations = [ACCELERATIONS[force] for force in components]
        missing = [name for column, name in enumerate(accelerations) if not any(mass.col(column))] or accelerations
        raise InputError(f"no term resists {' and '.join(missing)}; add one of inertia to the table")
    inverse = mass.adjugate() / mass.det()
    gains = [[(inverse[i, :] * column)[0] for column in columns.values()] for i in range(len(components))]
    others = {*trace.inputs, "mass", SURGE_INERTIA, *INPUTS.values()} - {*STATE, *ACCELERATIONS.values()}
    return FreeMotion(
        names=names | {name: symbol(name) for name in sorted(others)},
        components=components,
        basis=tuple(columns),
        gains=tuple(map(tuple, gains)),
        pushes=tuple(map(tuple, inverse.tolist())),
        regressors=regressors,
    )


def _coefficient_symbols(trace: Trace) -> dict[str, Expr]:
    names = {}
    for number, name in enumerate(trace.results):
        if name in RESERVED:
            raise InputError(f"term {name}: the name already means something else here; rename the coefficient")
        plain = name.isascii() and name.isidentifier() and not iskeyword(name) and not TEMPORARY.fullmatch(name)
        names[name] = symbol(name if plain else f"coefficient_{number}")
    return names


def exact_number(value: int | float) -> Expr:
    """Return an exact number: 0.5 is a half; a number without a short fraction keeps all its bits."""
    import sympy

    if value == math.e:
        return sympy.E
    above, below = value.as_integer_ratio()
    # SymPy cancels and compares fractions exactly; beyond 20 bits they cost more than they save.
    return sympy.Rational(above, below) if below.bit_length() <= 20 else sympy.Float(value)


def _mass(regressors: Mapping[str, tuple[str, Expr]], names: Mapping[str, Expr], components: Sequence[str]) -> Expr:
    import sympy

    from narrows.codegen.lines import symbols_of

    accelerations = [symbol(ACCELERATIONS[force]) for force in components]
    mass = sympy.zeros(len(components))
    for name, (force, regressor) in regressors.items():
        present = symbols_of(sympy.sympify(regressor))
        for column, acceleration in enumerate(accelerations):
            slope = regressor.diff(acceleration) if acceleration in present else sympy.Integer(0)
            if slope.free_symbols & set(accelerations):
                raise InputError(f"term {name}: an acceleration must enter linearly; {acceleration} does not")
            mass[components.index(force), column] -= names[name] * slope
    if "X" in components:
        mass[0, 0] += symbol(SURGE_INERTIA)
    return mass


def _columns(
    regressors: Mapping[str, tuple[str, Expr]], names: Mapping[str, Expr], components: Sequence[str], coriolis: bool
) -> dict[Expr, Expr]:
    """Each function of the state, and its factor in each force."""
    import sympy

    still = {symbol(name): sympy.Integer(0) for name in ACCELERATIONS.values()}
    parts = [(force, names[name], sympy.sympify(r).xreplace(still)) for name, (force, r) in regressors.items()]
    if coriolis:
        mass, u, v, r = (symbol(name) for name in ("mass", "u", "v", "r"))
        parts += [("X", mass, v * r), ("Y", -mass, u * r)]
    moving = [symbol(name) for name in STATE]
    columns: dict[Expr, Expr] = {}
    for force, factor, regressor in parts:
        for addend in sympy.Add.make_args(regressor) if force in components else ():
            fixed, varying = addend.as_independent(*moving, as_Add=False)
            column = columns.setdefault(varying, sympy.zeros(len(components), 1))
            column[components.index(force)] += factor * fixed
    return {basis: column for basis, column in columns.items() if any(column)}


# Hull points that can meet a bank: corners of a rectangle, the side at midship, an outline, or none. Points (forward,
# starboard) [m] are relative to midship; the hull is as wide as their convex hull.
Outline = tuple[tuple[float, float], ...]

CORNERS, MIDSHIP, OPEN = "corners", "midship", "none"


def point_names(count: int) -> list[tuple[str, str]]:
    return [(f"outline_forward_{number}", f"outline_starboard_{number}") for number in range(count)]
