"""The symbolic equation of motion of a free ship, from the trace of a table of terms; the choices of a step.

On the rig a force is F(motion, accelerations); for a free ship F plus the inputs vanishes: 0 = F + F_in. With M =
-dF/d(udot, vdot, rdot) and f = F at zero accelerations, M (udot, vdot, rdot) = f + F_in.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from keyword import iskeyword
from typing import Any, Literal, NamedTuple

from narrows.base.errors import InputError
from narrows.codegen.trace import Trace
from narrows.quantities.names import ACCELERATIONS, FORCES, PARTICULARS, REGRESSOR_INPUTS
from narrows.ship.actuators import STANDARD

Expr = Any  # A SymPy expression

Surge = Literal["held", "free"]

# Arguments of the right-hand side; its result has their derivatives in the same order.
STATE = ("x", "y", "cos_psi", "sin_psi", "u", "v", "r")

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

# Choices of a step: contact, section, control law, external forces. No symbol is made here.
# Columns of a waterway's table at each place: distances of the walls, depth and curvature of the line; the current over
# the number ``current``; the least distance at which a hull can meet a bank; the distances at which the keel does.
COLUMNS = (
    "starboard", "port", "depth", "curvature", "flow", "near_starboard", "near_port", "keel_starboard", "keel_port",
)  # fmt: skip
ROW = 2 * len(COLUMNS)  # Numbers per cell: for each column the value at its start and the rise to the next
# Further columns where the current is not along the line alone: its speed across, and the rise of that along it to
# starboard.
FIELD = ("across", "shear")
# Speed through the water at which a ship touches the bottom or chokes the section [m/s]: an input in a straight canal,
# the last column of the table of a waterway with known depths.
AFLOAT_SPEED = "afloat_speed"
# Water quantities available to a control law at a place, by their name in its trace: the curvature of the line and the
# distances at which the keel meets the banks.
WATER = {"water_curvature": "curvature", "water_starboard": "keel_starboard", "water_port": "keel_port"}
# Time at the start of a step [s], length of a whole step [s], and the share of it that is taken: 1 unless a contact is
# located or an output lies within the step.
TIME, LENGTH, SHARE = "t", "step_length", "share"
# Heading with whole turns [rad], used where heading across the canal does not end a voyage.
COUNTED = "counted_psi"
MIDSHIP_LEAVES = 0.9

# Inputs that all vessels share, in their order in an array: the queue reads the last three too. Every other input is
# per vessel, so that one kernel serves fleets in which other things vary; a lane reads both equally fast.
SHARED = ("least_cos", "x_last", "x_first", "cells_a_metre", "most_speed", "most_rate")

# First fields of a lane, before its state: the queue of vessels reads and writes them.
BOOK = ("step_length", "share", "left", "flag", "clearance", "side", "clearance_before")

# Lanes of a block of vessels; those of a block of derivatives, where more directions need more passes.
LANES, DIRECTIONS = 64, 32
CACHE_LINE = 8  # numbers: 64 bytes

AFTER = "{}_after".format  # An external force from ``push_end`` on, by its name before it

Pushed = Literal["never", "always", "until"]
CURRENT_ACROSS = "current_across"
# A current across: none; the same everywhere, an input of each vessel; or by place in a waterway's table, with a shear.
Across = Literal["none", "uniform", "field"]


# First-order stages that approximate the dead time of a gear: more make the delay sharper and each step dearer.
STAGES = 4


@dataclass(frozen=True)
class Actuated:
    name: str  # Name of its position
    angle: bool  # True if it enters the terms as cosine and sine
    late: bool = False  # True if it has a dead time, a lag or a dead band besides its limit and its rate

    @property
    def controls(self) -> tuple[str, ...]:
        return (f"cos_{self.name}", f"sin_{self.name}") if self.angle else (self.name,)

    @property
    def stages(self) -> tuple[str, ...]:
        """Names of the stored orders on their way to the actuator, the earliest last."""
        return tuple(f"{self.name}_delayed_{stage}" for stage in range(STAGES)) if self.late else ()


def stages_at(actuators: Iterable[Actuated], position: Callable[[str], Any]) -> dict[str, Any]:
    """Return the stored orders when the last one equals the position."""
    return {stage: position(actuator.name) for actuator in actuators for stage in actuator.stages}


class Law(NamedTuple):
    trace: Trace  # Results: orders by actuator name, new memory by its names
    memory: tuple[str, ...]  # Numbers stored from step to step
    ordered: tuple[Actuated, ...]  # Actuators that it orders


@dataclass(frozen=True)
class Choices:
    contact: str | int = "corners"  # ``corners``, ``midship``, ``none``, or the number of points of an outline
    waterway: bool = False  # True if the section of the water changes
    law: Law | None = None  # Control law; without one the actuators stay where they are
    pushed: Pushed = "never"  # External forces: none, constant, or changing ones that end at ``push_end`` [s]
    bottom: bool = False  # True if bottom contact or a choked section ends a voyage
    across: Across = "none"

    @property
    def columns(self) -> tuple[str, ...]:
        return (*COLUMNS, *FIELD * (self.across == "field"), *(AFLOAT_SPEED,) * self.bottom)

    @property
    def row(self) -> int:
        """Numbers per cell of a waterway's table: for each column the value at its start and the rise to the next."""
        return 2 * len(self.columns)

    @property
    def kept(self) -> tuple[str, ...]:
        """Quantities carried from step to step: state, optional turns and time, actuators, memory."""
        law = self.law
        timed = self.pushed == "until" or (law is not None and TIME in law.trace.inputs)
        state = (*STATE, *(COUNTED,) * (self.contact == OPEN), *(TIME,) * timed)
        if law is None:
            return state
        stages = (stage for actuator in law.ordered for stage in actuator.stages)
        return (*state, *(actuator.name for actuator in law.ordered), *stages, *law.memory)

    @property
    def gear(self) -> tuple[str, ...]:
        """Those of the actuators and the law."""
        return tuple(name for name in self.kept if name not in (*STATE, COUNTED))

    @property
    def exact(self) -> bool:
        """True if the exact clearance is computed once its lower bound reaches zero."""
        return self.waterway and self.contact not in (MIDSHIP, OPEN)

    @property
    def leaves(self) -> float:
        """Least share of the clearance that a step leaves [1]: at midship contact the suction becomes infinite."""
        return MIDSHIP_LEAVES if self.contact == MIDSHIP else 0.0

    @property
    def moving(self) -> tuple[str, ...]:
        """Quantities of the terms that change within a voyage, besides the state."""
        law = self.law.ordered if self.law else ()
        controls = [name for actuator in law for name in actuator.controls]
        return (
            *controls,
            *(("width", "depth") if self.waterway else ()),
            *(INPUTS.values() if self.pushed == "until" or self.across == "field" else ()),
        )
