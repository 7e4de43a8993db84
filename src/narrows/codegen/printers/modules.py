"""The plain module of a system: constants, rates, step and room as functions of floats or columns."""

from collections.abc import Mapping

from narrows.codegen.choices import Choices
from narrows.codegen.free_motion import STATE, Expr
from narrows.codegen.lines import Lines, real
from narrows.codegen.lowering import straight_lines
from narrows.codegen.printers.python import function_text
from narrows.codegen.rates import Rates
from narrows.codegen.step import Step, room_left


def plain_text(choices: Choices, rates: Rates, step: Step) -> str:
    """Write the plain module of a system."""
    kept, lines = choices.kept, Lines()
    room, lean = room_left(lines, choices, {name: real(name) for name in STATE})
    program, derivatives = rates.program()
    parts = [
        '"""Made by narrows from a table of terms: made again where it is missing, so do not edit."""\n',
        _constants(rates),
        _function("rates", program, {name: derivatives[name] for name in STATE}, STATE, False),
        _function("step", step.lines, {name: step.out[name] for name in (*kept, "room", "lean")}, kept, True),
        _function("room", lines, {"room": room, "lean": lean}, STATE[:4], True),
    ]
    return "\n\n".join(parts)


def _constants(rates: Rates) -> str:
    constants, names = rates.constants, rates.motion.names
    assignments, results = straight_lines(list(constants.table))
    used = set().union(*(expression.free_symbols for expression in constants.table))
    asked = {name: symbol for name, symbol in names.items() if symbol in used}
    text = function_text("constants", [str(symbol) for symbol in asked.values()], assignments, results)
    return f"PARAMETERS = {tuple(asked)!r}\nCONSTANTS = {constants.names!r}\n\n\n{text}"


def _function(name: str, lines: Lines, out: Mapping[str, Expr], first: tuple[str, ...], table: bool) -> str:
    """A function, and the names of what it takes after its first arguments."""
    program = lines.needed_for(list(out.values()))
    asked = {str(s) for value in out.values() for s in real(name).free_symbols | value.free_symbols}
    made = {str(target) for target, _ in program.assignments}
    rest = tuple(sorted((set(program.inputs) | asked) - made - {*first, name}))
    text = function_text(name, (*first, *rest), program.assignments, list(out.values()), table)
    return f"{name.upper()}_INPUTS = {rest!r}\n\n\n{text}"
