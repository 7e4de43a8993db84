"""Exact derivatives by forward-mode automatic differentiation, line by line of a program.

Each line depends on few earlier ones, so its derivatives stay short; those of whole formulas do not.
"""

from collections.abc import Callable, Mapping, Sequence

from sympy import Integer, sign, sympify

from narrows.codegen.choices import DIRECTIONS, LENGTH, Actuated, Choices
from narrows.codegen.free_motion import ACCELERATIONS, STATE, Expr, FreeMotion, symbol
from narrows.codegen.linearisation import LINEARISED, arguments, controlled
from narrows.codegen.lines import Assignment, Lines, asked_by, positive, real, straight_lines, symbols_of
from narrows.codegen.printers.python import constants_text, function_text, module_text, plain
from narrows.codegen.step import Rates, step_of
from narrows.quantities.names import FORCES


def with_tangents(
    lines: Lines, inputs: Mapping[Expr, Sequence[Expr]], directions: int
) -> tuple[Lines, Callable[[Expr], list[Expr]]]:
    out = Lines(_taken={str(name) for name, _ in lines.assignments})
    slopes = {name: [sympify(slope) for slope in along] for name, along in inputs.items()}

    def through(value: Expr, name: str) -> list[Expr]:
        moving = [s for s in sorted(symbols_of(value), key=str) if s in slopes]
        partial = {s: out.put(f"{name}_by_{s}", slope(value, s)) for s in moving}
        totals = [sum((d * slopes[s][k] for s, d in partial.items()), Integer(0)) for k in range(directions)]
        return [out.put(f"{name}_d{k}", total) for k, total in enumerate(totals)]

    for line in lines.program:
        out.program.append(line)
        if line is not None:
            name, value = line
            if any(s in slopes for s in symbols_of(value)):
                slopes[name] = through(value, str(name))

    def of(value: Expr) -> list[Expr]:
        value = sympify(value)
        if value.is_Symbol:
            return slopes.get(value, [Integer(0)] * directions)
        return through(value, "out")

    return out, of


def slope(value: Expr, by: Expr) -> Expr:
    return value.diff(by).replace(sign, lambda one: positive(one) - positive(-one))


# Exact derivatives of the motion from the same trace: by state, by control, by coefficient.
def jacobian_text(
    motion: FreeMotion, names: Sequence[str], actuators: Sequence[Actuated], section: Sequence[str]
) -> str:
    rates = Rates(motion, arguments(actuators, section)[len(STATE) :], pushed=True)
    lines = Lines()
    values = {name: real(name) for name in (*STATE, *rates.moving)}
    program, results = rates.program()
    linear = linear_slopes(program, {**results, "psi": real("r")}, actuators)
    slopes = coefficient_slopes(lines, rates, names, values)
    # Both define constants of their own, so the texts come after them.
    texts = [_jacobian("linear", rates, *linear), _jacobian("coefficients", rates, lines, slopes)]
    return module_text(0, constants_text(rates.parameters, rates.constants), *texts)


def _jacobian(name: str, rates: Rates, lines: Lines, results: Sequence[Expr]) -> str:
    head = [f"{own} = values[{index}]" for index, own in enumerate((*STATE, *rates.moving))]
    head += [f"{own} = constants[{index}]" for index, own in enumerate(rates.constants.names)]
    text = function_text(name, ("values", "constants"), lines.needed_for(results).assignments, results, head)
    return f"@quiet\n{text}"


def linear_slopes(lines: Lines, rates: Mapping[str, Expr], actuators: Sequence[Actuated]) -> tuple[Lines, list[Expr]]:
    """Write the derivatives of the rates of ``LINEARISED`` by state and by control, row by row."""
    angles = {"psi", *(actuator.name for actuator in actuators if actuator.angle)}
    directions = (*LINEARISED, *controlled(actuators))
    slopes: dict[Expr, list[Expr]] = {}
    for number, name in enumerate(directions):
        cosine, sine = f"cos_{name}", f"sin_{name}"
        moved = {cosine: -real(sine), sine: real(cosine)} if name in angles else {name: 1}
        for component, slope in moved.items():
            slopes[real(component)] = [slope if k == number else 0 for k in range(len(directions))]
    more, slopes_of = with_tangents(lines, slopes, len(directions))
    return more, [entry for name in LINEARISED for entry in slopes_of(rates[name])]


def coefficient_slopes(lines: Lines, rates: Rates, names: Sequence[str], values: Mapping[str, Expr]) -> list[Expr]:
    """Write the derivatives of the accelerations by coefficients, row by row."""
    # With F(accelerations) + F_in = 0 a coefficient moves the accelerations by M^-1 times its regressor.
    motion = rates.motion
    solved = rates.written(lines, "", values)
    known = list(motion.regressors)
    columns = [rates.constants.lift(sympify(motion.regressors[name][1])) for name in known]
    where = {symbol(name): solved[state] for name, state in zip(ACCELERATIONS.values(), ("u", "v", "r"), strict=True)}
    where |= {symbol(name): value for name, value in values.items()}
    regressors = dict(zip(known, lines.inline("g_", *straight_lines(columns), where), strict=True))
    rows = dict(zip(motion.components, motion.pushes, strict=True))

    def entry(force: str, name: str) -> Expr:
        if name not in regressors or force not in rows:
            return Integer(0)
        return rates.constants.lift(rows[force][motion.components.index(motion.regressors[name][0])]) * regressors[name]

    return [entry(force, name) for force in FORCES for name in names]


# The tangent of a voyage: a step with the derivatives of its whole state; lanes are directions. The lines of the step
# and their partial derivatives are floats, computed once. The derivatives along the directions are one loop over a
# block of lanes, which LLVM vectorises: a direction costs a few additions and products per line.
SLOPE = "d_{}".format


def tangent_text(choices: Choices, rates: Rates, moving: Sequence[str]) -> str:
    """Write the module of the function ``step(z, block, inputs, table)``, in place."""
    kept, fields, whole = choices.kept, (*choices.kept, *moving), step_of(rates, choices, whole=True)
    out, seeds = [whole.out[name] for name in kept], {real(name): [real(SLOPE(name))] for name in fields}
    lines, slopes_of = with_tangents(whole.lines.needed_for(out), seeds, 1)
    slopes = [slopes_of(value)[0] for value in out]
    program = lines.needed_for([*out, *slopes]).assignments
    rest = {LENGTH, *asked_by(program, out)} - {*fields, *map(SLOPE, fields)}
    inputs = (*moving, *sorted(rest))
    numbers = {"INPUTS": inputs, "KEPT": len(kept), "MOVING": len(moving)}
    names = "\n".join(f"{name} = {value!r}" for name, value in numbers.items())
    # The lines split into floats, and lanes: those that depend on a derivative.
    lanes, parts = {real(SLOPE(name)) for name in fields}, {False: list[Assignment](), True: list[Assignment]()}
    for name, value in program:
        parts[bool(symbols_of(value) & lanes)].append((name, value))
        lanes |= {name} if symbols_of(value) & lanes else set()
    body = [
        *(f"{name} = z[{i}]" for i, name in enumerate(kept)),
        *(f"{name} = inputs[{i}]" for i, name in enumerate(inputs)),
        *(f"{name} = {plain.doprint(value)}" for name, value in parts[False]),
        *(f"z[{i}] = {plain.doprint(value)}" for i, value in enumerate(out)),
        f"for lane in range({DIRECTIONS}):",
        *(f"    {SLOPE(name)} = block[{i * DIRECTIONS} + lane]" for i, name in enumerate(fields)),
        *(f"    {name} = {plain.doprint(value)}" for name, value in parts[True]),
        *(f"    block[{i * DIRECTIONS} + lane] = {plain.doprint(value)}" for i, value in enumerate(slopes)),
    ]
    text = "\n    ".join(["@quiet\ndef step(z, block, inputs, table):", *body])
    return module_text(choices.row, names, f"{text}\n")
