"""Functions of a model as text: those of floats or columns, and those of fleets as loops over a block of lanes.

Each round of a step is a loop of its own, since a long loop is a longer chain than a processor looks ahead. No loop
branches on data, so that it is written as vectors.

Derivatives are exact, by forward-mode automatic differentiation, line by line of a program: each line depends on few
earlier ones, so its derivatives stay short; those of whole formulas do not.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import chain

from sympy import Integer, sign, sympify

from narrows.codegen.free_motion import BOOK, DIRECTIONS, LANES, LENGTH, SHARED, STATE, Actuated, Choices, symbol
from narrows.codegen.linearisation import LINEARISED, arguments, controlled
from narrows.codegen.lines import Expr, LaneLoops, Lines, asked_by, positive, real, rounds, straight_lines, symbols_of
from narrows.codegen.printers.python import constants_text, function_text, module_text, plain
from narrows.codegen.printers.translation import Language
from narrows.codegen.step import Rates, ends_left, least_clearance, step_of
from narrows.quantities.names import FORCES

SPEED_LIMITS = {"u": "most_speed", "v": "most_speed", "r": "most_rate"}
# Margin [m] to an end that a voyage cannot meet, and the ends but a bank.
UNREACHED = Integer(10) ** 9
ENDS = ("heading", "ahead", "astern", "afloat")


def plain_text(choices: Choices, rates: Rates) -> str:
    """Write constants, rates, step and clearance of a system as functions of floats or columns."""
    kept, lines, ends, state = choices.kept, Lines(), Lines(), {name: real(name) for name in STATE}
    step, after = step_of(rates, choices)
    parts = [
        '"""Made by narrows from a table of terms: made again where it is missing, so do not edit."""\n',
        *_rate_texts(rates),
        _function("step", step, [after[name] for name in (*kept, "clearance", "side")], kept, "table"),
        _function("least_clearance", lines, least_clearance(lines, choices, state), STATE[:5], "table"),
        _function("ends", ends, ends_of(ends, choices, state), STATE[:5], "table"),
    ]
    return "\n\n".join(parts)


@lru_cache(maxsize=32)
def _rate_texts(rates: Rates) -> tuple[str, str]:
    """Constants and rates: the same for every law and contact."""
    program, derivatives = rates.program()
    constants = constants_text(rates.parameters, rates.constants)
    return constants, _function("rates", program, [derivatives[name] for name in STATE], STATE)


def _function(name: str, lines: Lines, results: Sequence[Expr], first: tuple[str, ...], *table: str) -> str:
    program = lines.needed_for(results).assignments
    rest = tuple(sorted({*asked_by(program, results)} - {*first}))
    text = function_text(name, (*table, *first, *rest), program, results)
    return f"{name.upper()}_INPUTS = {rest!r}\n\n\n{text}"


def ends_of(lines: Lines, choices: Choices, state: Mapping[str, Expr]) -> tuple[Expr, ...]:
    left = ends_left(lines, choices, state)
    return tuple(left.get(name, UNREACHED) for name in ENDS)


class Kernel(Language):
    TABLE, DECLARED, ASSIGNED = "table", "{} = {}", "{} = {}"


def kernel_text(choices: Choices, rates: Rates) -> str:
    """Write the function ``step(block, table, shared)`` of a block of vessels, (fields, lanes), and its ends."""
    (lines, after), kept = step_of(rates, choices, whole=True), choices.kept
    out = tuple(after.values())
    needed = lines.needed_for(out)
    loops = LaneLoops(rounds(needed), out)
    inputs = {*asked_by(needed.assignments, out), *SPEED_LIMITS.values()} - {*kept, *BOOK}
    vessel_inputs = tuple(sorted(inputs - {*SHARED}))
    stored = chain.from_iterable(loops.stored)
    fields = (*BOOK, *kept, *(f"old {name}" for name in kept), *vessel_inputs, *stored)
    places = {name: f"block[{field}, lane]" for field, name in enumerate(fields)}
    places |= {name: f"shared[{place}]" for place, name in enumerate(SHARED)}
    numbers = {
        "LANES": LANES, "FIELDS": len(fields), "KEPT_NAMES": kept, "VESSEL_INPUTS": vessel_inputs,
        "EXACT": choices.exact, "LEAVES": choices.leaves,
    }  # fmt: skip
    names = "\n".join(f"{name} = {value!r}" for name, value in numbers.items())
    body = [*(f"{name} = {places[name]}" for name in sorted(inputs & {*SHARED})), "all_well = True"]
    for number in range(len(loops.parts)):
        inside = Kernel().loop_body(loops, number, places)
        if number == len(loops.parts) - 1:
            own = (f"{name} = {places[name]}" for name in sorted({*kept} - loops.read[number]))
            inside += [*own, *_close(choices, after, places)]
        body += [f"for lane in range({LANES}):", *(f"    {line}" for line in inside)]
    text = "\n    ".join(["def step(block, table, shared):", *body, "return any_false(all_well)"]) + "\n"
    return module_text(choices.row, names, *_end_texts(choices, places), text)


def _end_texts(choices: Choices, places: Mapping[str, str]) -> Iterator[str]:
    state, own, ends = {name: real(name) for name in STATE}, Lines(), Lines()
    before = {name: places[name].replace("[", "[first + ") for name in choices.kept}
    for name, lines, results, first, where in (
        ("clearance_of", own, least_clearance(own, choices, state), (), places),
        ("ends_of", ends, ends_of(ends, choices, state), ("first",), {**places, **before}),
    ):
        head = [f"{one} = {where[one]}" for one in lines.inputs]
        yield function_text(name, ("block", "lane", *first, "table", "shared"), lines.assignments, results, head)


def _close(choices: Choices, after: Mapping[str, Expr], places: Mapping[str, str]) -> Iterator[str]:
    out = {name: plain.doprint(sympify(value)) for name, value in after.items()}
    yield from (f"{places[f'old {name}']} = {name}" for name in choices.kept)
    yield f"clearance_before = {places['clearance']}"
    yield f"{places['clearance_before']} = clearance_before"
    yield from (f"{places[name]} = {out[name]}" for name in ("clearance", "side", *choices.kept) if name in out)
    yield f"left = {places['left']} - 1.0"
    yield f"{places['left']} = left"
    must = f"{choices.leaves!r} * clearance_before" if choices.leaves else "0.0"
    sane = " & ".join(f"(abs({out[name]}) < {most})" for name, most in SPEED_LIMITS.items())
    yield f"well = (left > 0.0) & ({out['clearance']} > {must}) & {sane}"
    yield f"{places['flag']} = where(well, 0.0, 1.0)"
    yield "all_well = all_well & well"


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
    choices: Choices, rates: Rates, names: Sequence[str], actuators: Sequence[Actuated], section: Sequence[str]
) -> str:
    rates, lines = Rates(rates.motion, arguments(actuators, section)[len(STATE) :], pushed=True), Lines()
    program, results = rates.program()
    linear = linear_slopes(program, {**results, "psi": real("r")}, actuators)
    slopes = coefficient_slopes(lines, rates, names, rates.symbols)
    # Both define constants of their own, so the texts come after them.
    texts = [_jacobian("linear", rates, *linear), _jacobian("coefficients", rates, lines, slopes)]
    return module_text(choices.row, constants_text(rates.parameters, rates.constants), *texts)


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
    where = {symbol(f"{name}dot"): solved[name] for name in ("u", "v", "r")}
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
    kept, fields, (step, after) = choices.kept, (*choices.kept, *moving), step_of(rates, choices, whole=True)
    out, seeds = [after[name] for name in kept], {real(name): [real(SLOPE(name))] for name in fields}
    lines, slopes_of = with_tangents(step.needed_for(out), seeds, 1)
    slopes = [slopes_of(value)[0] for value in out]
    program = lines.needed_for([*out, *slopes]).assignments
    rest = {LENGTH, *asked_by(program, out)} - {*fields, *map(SLOPE, fields)}
    inputs = (*moving, *sorted(rest))
    numbers = {"INPUTS": inputs, "KEPT": len(kept), "MOVING": len(moving)}
    names = "\n".join(f"{name} = {value!r}" for name, value in numbers.items())
    # The lines split into floats, and lanes: those that depend on a derivative.
    lanes = {real(SLOPE(name)) for name in fields}
    for name, value in program:
        lanes |= {name} if symbols_of(value) & lanes else set()
    body = [
        *(f"{name} = z[{i}]" for i, name in enumerate(kept)),
        *(f"{name} = inputs[{i}]" for i, name in enumerate(inputs)),
        *(f"{name} = {plain.doprint(value)}" for name, value in program if name not in lanes),
        *(f"z[{i}] = {plain.doprint(value)}" for i, value in enumerate(out)),
        f"for lane in range({DIRECTIONS}):",
        *(f"    {SLOPE(name)} = block[{i * DIRECTIONS} + lane]" for i, name in enumerate(fields)),
        *(f"    {name} = {plain.doprint(value)}" for name, value in program if name in lanes),
        *(f"    block[{i * DIRECTIONS} + lane] = {plain.doprint(value)}" for i, value in enumerate(slopes)),
    ]
    text = "\n    ".join(["@quiet\ndef step(z, block, inputs, table):", *body])
    return module_text(choices.row, names, f"{text}\n")
