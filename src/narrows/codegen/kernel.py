"""Functions of a model that are compiled for fleets: a step over a block of lanes, clearance and ends."""

from collections.abc import Iterator, Mapping

import sympy

from narrows.codegen.choices import SHARED, Choices
from narrows.codegen.free_motion import MIDSHIP, OPEN, STATE, Expr
from narrows.codegen.kernels.elementary import module_text
from narrows.codegen.lines import Lines, real
from narrows.codegen.printers.lanes import LaneArithmetic, Lanes
from narrows.codegen.printers.python import Arithmetic, constants_text, function_text
from narrows.codegen.rates import Rates
from narrows.codegen.step import Step, ends_left, least_clearance


def kernel_text(lanes: Lanes, choices: Choices, precision: str) -> str:
    """Write the functions of a model that the queue of vessels calls."""
    printer = LaneArithmetic()
    functions = [*_end_texts(lanes, choices, printer), lanes.rates_text(printer), lanes.text(printer, choices.leaves)]
    numbers = {
        "LANES": lanes.count, "FIELDS": lanes.layout.size,
        "KEPT_NAMES": lanes.kept, "VESSEL_INPUTS": lanes.vessel_inputs,
        "EXACT": choices.waterway and choices.contact not in (MIDSHIP, OPEN), "LEAVES": choices.leaves,
    }  # fmt: skip
    names = "\n".join(f"{name} = {value!r}" for name, value in numbers.items())
    return module_text(precision, choices.row, names, *functions)


def _end_texts(lanes: Lanes, choices: Choices, printer: Arithmetic) -> Iterator[str]:
    """Write the clearance of one lane and its margins to every end but a bank."""
    state = {name: real(name) for name in STATE}
    own, ends = Lines(), Lines()
    yield _of_one("clearance_of(block, lane, table, shared)", own, least_clearance(own, choices, state), lanes, printer)
    left = ends_of(ends, choices, state)
    yield _of_one("ends_of(block, lane, first, table, shared)", ends, left, lanes, printer, "first * LANES + ")


# Margin [m] to an end that a voyage cannot meet.
UNREACHED = sympy.Integer(10) ** 9


def ends_of(lines: Lines, choices: Choices, state: Mapping[str, Expr]) -> tuple[Expr, ...]:
    left = ends_left(lines, choices, state)
    return tuple(left.get(name, UNREACHED) for name in ("heading", "ahead", "astern", "afloat"))


def _of_one(
    head: str, lines: Lines, results: tuple[Expr, ...], lanes: Lanes, printer: Arithmetic, kept_from: str = ""
) -> str:
    body = []
    for name in lines.inputs:
        place = f"shared[{SHARED.index(name)}]" if name in SHARED else lanes.entry(name)
        body.append(f"{name} = {place.replace('[', f'[{kept_from}') if name in lanes.kept else place}")
    body += [f"{target} = {printer.doprint(value)}" for target, value in lines.assignments]
    body.append(f"return {', '.join(printer.doprint(result) for result in results)}")
    return "\n    ".join([f"def {head}:", *body]) + "\n"


# The plain module of a system: constants, rates, step and clearance as functions of floats or columns.
def plain_text(choices: Choices, rates: Rates, step: Step) -> str:
    kept, lines, ends, state = choices.kept, Lines(), Lines(), {name: real(name) for name in STATE}
    clearance, side = least_clearance(lines, choices, state)
    left = dict(zip(("heading", "ahead", "astern", "afloat"), ends_of(ends, choices, state), strict=True))
    program, derivatives = rates.program()
    parts = [
        '"""Made by narrows from a table of terms: made again where it is missing, so do not edit."""\n',
        constants_text(rates.parameters, rates.constants),
        _function("rates", program, {name: derivatives[name] for name in STATE}, STATE, False),
        _function("step", step.lines, {name: step.out[name] for name in (*kept, "clearance", "side")}, kept, True),
        _function("least_clearance", lines, {"clearance": clearance, "side": side}, STATE[:5], True),
        _function("ends", ends, left, STATE[:5], True),
    ]
    return "\n\n".join(parts)


def _function(name: str, lines: Lines, out: Mapping[str, Expr], first: tuple[str, ...], table: bool) -> str:
    """Return a function and the names of its arguments after the first ones."""
    program = lines.needed_for(list(out.values()))
    asked = {str(s) for value in out.values() for s in real(name).free_symbols | value.free_symbols}
    made = {str(target) for target, _ in program.assignments}
    rest = tuple(sorted((set(program.inputs) | asked) - made - {*first, name}))
    text = function_text(name, (*first, *rest), program.assignments, list(out.values()), table)
    return f"{name.upper()}_INPUTS = {rest!r}\n\n\n{text}"
