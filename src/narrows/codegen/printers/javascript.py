"""Lines as JavaScript, and plain functions of Python as functions of it."""

import ast
from collections.abc import Iterator, Mapping, Sequence

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Program
from narrows.codegen.printers.python import Arithmetic, statements
from narrows.codegen.printers.translation import Translation

LIBRARY = {name: f"Math.{name}" for name in ("abs", "exp", "log", "sqrt", "floor", "hypot", "cos", "sin", "min", "max")}
LIBRARY |= {"sine": "Math.sin", "cosine": "Math.cos", "power": "Math.pow", "whole": "Math.trunc", "int": "Math.trunc"}
# Words that no number can be called by.
TAKEN = frozenset({
    "await", "break", "case", "catch", "class", "const", "continue", "debugger", "default", "delete", "do", "else",
    "enum", "export", "extends", "false", "finally", "for", "function", "if", "import", "in", "instanceof", "let",
    "new", "null", "return", "static", "super", "switch", "this", "throw", "true", "try", "typeof", "var", "void",
    "while", "with", "yield", "arguments", "eval", "Math", "state", "inputs", "constants", "parameters", "waterway",
    "result",
})  # fmt: skip


def javascript_name(name: str) -> str:
    """Return what a number is called in JavaScript."""
    return f"{name}_" if name in TAKEN else name


class JavaScriptArithmetic(Arithmetic):
    """Expressions in JavaScript."""

    TABLE = "waterway"

    def called(self, name: str, *arguments: str) -> str:
        """Write the call of a function of ``Math``, or of the file."""
        return super().called(LIBRARY.get(name, name), *arguments)

    def _print_Symbol(self, value: Expr) -> str:
        return javascript_name(value.name)


def javascript_body(program: Program, targets: Sequence[str], places: Mapping[str, str]) -> list[str]:
    """Write a program as statements of JavaScript."""
    asked = [name for name in program.asked if name != places[name]]
    lines = [f"const {javascript_name(name)} = {places[name]};" for name in asked]
    return lines + statements(program, targets, JavaScriptArithmetic(), "const {} = {};", "{} = {};")


class JavaScriptTranslation(Translation):
    """Plain functions in JavaScript; a tuple is an array there."""

    INFINITE, NO_NUMBER, EQUAL, UNEQUAL = "Infinity", "NaN", "===", "!=="

    def head(self) -> str:
        """The line that begins the function."""
        return f"function {self.function.name}({', '.join(one.arg for one in self.parameters())}) {{"

    def declarations(self) -> list[str]:
        """Every variable of the function, before its first statement."""
        names = [name for name in self.assigned() if name not in {one.arg for one in self.parameters()}]
        return [f"let {', '.join(names)};"] if names else []

    def array(self, name: str, size: str) -> str:
        """The line that makes an array of zeros."""
        return f"const {name} = new Float64Array({size});"

    def held(self, name: str, value: str) -> str:
        """The line that keeps a number for the next lines."""
        return f"const {name} = {value};"

    def from_call(self, targets: Sequence[ast.expr], call: ast.Call) -> Iterator[str]:
        """Lines that take apart the tuple that a call returns."""
        yield f"[{', '.join(map(self.expression, targets))}] = {self.expression(call)};"

    def returned(self, values: Sequence[ast.expr]) -> Iterator[str]:
        """Lines that return a tuple."""
        yield f"return [{', '.join(map(self.expression, values))}];"

    def over_tuple(self, node: ast.For) -> Iterator[str]:
        """Lines that begin a loop over a tuple of numbers, or of tuples of them."""
        yield f"for ({self._listed(node.target)} of {self._listed(node.iter)}) {{"

    def _listed(self, node: ast.expr) -> str:
        return f"[{', '.join(map(self._listed, node.elts))}]" if isinstance(node, ast.Tuple) else self.expression(node)

    def called(self, name: str, arguments: Sequence[ast.expr]) -> str:
        """A call of a function."""
        texts = [self.expression(one) for one in arguments]
        if name == "len":
            return f"{texts[0]}.length"
        return texts[0] if name == "float" else f"{LIBRARY.get(name, name)}({', '.join(texts)})"

    def attribute(self, structure: str, name: str) -> str:
        """A field of a structure."""
        return f"{structure}.{name}"

    def constant(self, name: str) -> str:
        """A constant of the modules by its name."""
        self.used.add(name)
        return name

    def whole_quotient(self, left: str, right: str) -> str:
        """How often one whole number goes into another."""
        return f"Math.floor({left} / {right})"

    def remainder(self, left: str, right: str) -> str:
        """What is left of one number that is not negative by another."""
        return f"{left} % {right}"
