"""A model as one Python file that needs NumPy alone."""

import ast
from collections.abc import Mapping
from keyword import iskeyword

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Program
from narrows.codegen.printers.plain_source import PlainSource
from narrows.codegen.printers.python import Arithmetic, statements
from narrows.export.exported_ship import ExportedShip
from narrows.export.rendering import bodies_of, last_functions, plain_functions, rendered, water_of

TAKEN = frozenset({"state", "inputs", "constants", "parameters", "waterway", "result", "np", "abs", "sine", "cosine"})


class PortableArithmetic(Arithmetic):
    """Expressions of a file that stands alone: the table of a waterway is a part of it."""

    TABLE = "waterway"

    def _print_Symbol(self, value: Expr) -> str:
        return python_name(value.name)


def python_name(name: str) -> str:
    """Return what a number is called in a Python file."""
    return f"{name}_" if name in TAKEN or iskeyword(name) else name


def python_text(exported: ExportedShip) -> str:
    """Return the file of a ship."""
    source = plain_functions(exported)
    functions = last_functions(exported, source)
    bodies = bodies_of(exported, "{}.{}".format, "np.{}({})".format, python_name, _body)
    return rendered(
        "model.py.j2", exported, f=bodies, plain=[ast.unparse(one) for one in functions],
        numbers=_constants_of(functions, source), water=water_of(exported, python_number),
        number=python_number, name=python_name,
    )  # fmt: skip


def _constants_of(functions: list[ast.FunctionDef], source: PlainSource) -> dict[str, float]:
    """The constants of the modules that functions ask for."""
    asked = {one.id for function in functions for one in ast.walk(function) if isinstance(one, ast.Name)}
    return {name: source.constants[name] for name in sorted(asked & set(source.constants))}


def python_number(value: float) -> str:
    """Return a number to its last bit."""
    return repr(float(value))


def _body(program: Program, targets: list[str], places: Mapping[str, str]) -> list[str]:
    lines = [f"{python_name(name)} = {places[name]}" for name in program.asked if name != places[name]]
    return lines + statements(program, targets, PortableArithmetic())
