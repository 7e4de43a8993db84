"""A model as one Python file that needs NumPy alone."""

import ast
from collections.abc import Mapping
from importlib.metadata import version
from keyword import iskeyword

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Program
from narrows.codegen.printers.javascript import JavaScriptTranslation, javascript_body, javascript_name
from narrows.codegen.printers.latex import latex
from narrows.codegen.printers.python import Arithmetic, PlainSource, statements
from narrows.export.exported_ship import ExportedShip
from narrows.export.rendering import (
    bodies_of,
    commented,
    last_functions,
    plain_functions,
    rendered,
    translated,
    water_of,
)
from narrows.model.model import Model

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


# A model as one ES module without dependencies, its types as JSDoc.
def javascript_text(exported: ExportedShip, derivatives: bool = True) -> str:
    """Return the module of a ship."""
    bodies = bodies_of(exported, "{}.{}".format, "Math.{}({})".format, javascript_name, javascript_body)
    return rendered(
        "model.js.j2", exported, f=bodies, water=water_of(exported, javascript_number), number=javascript_number,
        name=javascript_name, derivatives=derivatives, **translated(exported, JavaScriptTranslation),
    )  # fmt: skip


def javascript_number(value: float) -> str:
    """Return a number to its last bit."""
    text = repr(float(value))
    return {"inf": "Infinity", "-inf": "-Infinity", "nan": "NaN"}.get(text, text)


# The equations of a model in LaTeX, with symbols and with numbers.
def latex_text(model: Model) -> str:
    """Return the equations of the forces as a piece of LaTeX, for amsmath."""
    about = (model.configuration.ship.name, f"terms {model.terms.name}", model.source.text)
    lines = [f"% {commented(line)}" for line in (*about, f"written by narrows {version('narrows')}") if line]
    for coefficients in (None, model.coefficients):
        lines += ["\\begin{equation}", latex(model.terms, coefficients), "\\end{equation}"]
    return "\n".join(lines) + "\n"
