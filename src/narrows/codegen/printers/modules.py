"""The plain module of a system: constants, rates, step and room as functions of floats or columns."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from narrows.codegen.free_motion import STATE, Expr
from narrows.codegen.lines import Lines, real
from narrows.codegen.lowering import straight_lines
from narrows.codegen.printers.python import function_text
from narrows.codegen.step import room_left

if TYPE_CHECKING:
    from narrows.codegen.system import System


def plain_text(system: "System") -> str:
    """Write the plain module of a system.

    Parameters
    ----------
    system : System
        Traced.
    """
    kept, lines = system.choices.kept, Lines()
    room, lean = room_left(lines, system.choices, {name: real(name) for name in STATE})
    rates, derivatives = system.rates.program()
    step = system.step
    parts = [
        '"""Made by narrows from a table of terms: made again where it is missing, so do not edit."""\n',
        _constants(system),
        _function("rates", rates, {name: derivatives[name] for name in STATE}, STATE, False),
        _function("step", step.lines, {name: step.out[name] for name in (*kept, "room", "lean")}, kept, True),
        _function("room", lines, {"room": room, "lean": lean}, STATE[:4], True),
    ]
    return "\n\n".join(parts)


def _constants(system: "System") -> str:
    constants, names = system.rates.constants, system.rates.motion.names
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
