"""A model as one Python file that needs NumPy alone."""

import ast
from collections.abc import Mapping
from keyword import iskeyword

from narrows.codegen.choices import ROW
from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Program
from narrows.codegen.printers.plain_source import PlainSource
from narrows.codegen.printers.python import Arithmetic
from narrows.export.exported_ship import ExportedShip
from narrows.export.rendering import (
    places_in,
    plain_functions,
    rate_names,
    rendered,
    results_of,
    targets_of,
    water_of,
)

TAKEN = frozenset({"state", "inputs", "constants", "parameters", "waterway", "result", "np", "abs", "sine", "cosine"})


class PortableArithmetic(Arithmetic):
    """Expressions of a file that stands alone: the table of a waterway is a part of it."""

    def _print_Symbol(self, value: Expr) -> str:
        return python_name(value.name)

    def _print_Function(self, value: Expr) -> str:
        if str(value.func) == "entry":
            return f"entry(waterway, {int(value.args[0])}, {self._print(value.args[1])})"
        return str(super()._print_Function(value))


def python_name(name: str) -> str:
    """Return what a number is called in a Python file (ours).

    Parameters
    ----------
    name : str
        Of the lines.
    """
    return f"{name}_" if name in TAKEN or iskeyword(name) else name


def python_text(exported: ExportedShip) -> str:
    """Return the file of a ship (ours).

    Parameters
    ----------
    exported : ExportedShip
        The ship, its choices and its waterway.
    """
    source = plain_functions(exported)
    functions = source.needed(*(("clearance",) * exported.exact), "sail")
    return rendered(
        "model.py.j2", exported, f=_bodies(exported), plain=[ast.unparse(one) for one in functions],
        numbers=_constants_of(functions, source), row=ROW, water=water_of(exported, python_number),
        number=python_number, name=python_name, rates=rate_names(exported),
    )  # fmt: skip


def _constants_of(functions: list[ast.FunctionDef], source: PlainSource) -> dict[str, float]:
    """The constants of the modules that functions ask for."""
    asked = {one.id for function in functions for one in ast.walk(function) if isinstance(one, ast.Name)}
    return {name: source.constants[name] for name in sorted(asked & set(source.constants))}


def python_number(value: float) -> str:
    """Return a number to its last bit (ours).

    Parameters
    ----------
    value : float
        Any.
    """
    return repr(float(value))


def _bodies(exported: ExportedShip) -> Mapping[str, str]:
    of = "{}.{}".format
    places = places_in(exported, of, "np.{}({})".format, python_name)
    bodies = {}
    for name, program in exported.programs.items():
        targets, where = targets_of(name, exported, of, python_name) or (results_of(program), places)
        bodies[name] = "\n    ".join(_body(program, targets, where))
    return bodies


def _body(program: Program, targets: list[str], places: Mapping[str, str]) -> list[str]:
    printer = PortableArithmetic()
    asked = [name for name in program.asked if name != places[name]]
    lines = [f"{python_name(name)} = {places[name]}" for name in asked]
    lines += [f"{printer.doprint(name)} = {printer.doprint(value)}" for name, value in program.assignments]
    return lines + [f"{at} = {printer.doprint(value)}" for at, value in zip(targets, program.results, strict=True)]
