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
    return f"{name}_" if name in TAKEN else name


class JavaScriptArithmetic(Arithmetic):
    TABLE = "waterway"

    def called(self, name: str, *arguments: str) -> str:
        return super().called(LIBRARY.get(name, name), *arguments)

    def _print_Symbol(self, value: Expr) -> str:
        return javascript_name(value.name)


def javascript_body(program: Program, targets: Sequence[str], places: Mapping[str, str]) -> list[str]:
    asked = [name for name in program.asked if name != places[name]]
    lines = [f"const {javascript_name(name)} = {places[name]};" for name in asked]
    return lines + statements(program, targets, JavaScriptArithmetic(), "const {} = {};", "{} = {};")


class JavaScriptTranslation(Translation):
    """Plain functions in JavaScript; a tuple is an array there."""

    INFINITE, NO_NUMBER, EQUAL, UNEQUAL = "Infinity", "NaN", "===", "!=="

    def head(self) -> str:
        return f"function {self.function.name}({', '.join(one.arg for one in self.parameters())}) {{"

    def declarations(self) -> list[str]:
        names = [name for name in self.assigned() if name not in {one.arg for one in self.parameters()}]
        return [f"let {', '.join(names)};"] if names else []

    def array(self, name: str, size: str) -> str:
        return f"const {name} = new Float64Array({size});"

    def held(self, name: str, value: str) -> str:
        return f"const {name} = {value};"

    def from_call(self, targets: Sequence[ast.expr], call: ast.Call) -> Iterator[str]:
        yield f"[{', '.join(map(self.expression, targets))}] = {self.expression(call)};"

    def returned(self, values: Sequence[ast.expr]) -> Iterator[str]:
        yield f"return [{', '.join(map(self.expression, values))}];"

    def over_tuple(self, node: ast.For) -> Iterator[str]:
        yield f"for ({self._listed(node.target)} of {self._listed(node.iter)}) {{"

    def _listed(self, node: ast.expr) -> str:
        return f"[{', '.join(map(self._listed, node.elts))}]" if isinstance(node, ast.Tuple) else self.expression(node)

    def called(self, name: str, arguments: Sequence[ast.expr]) -> str:
        texts = [self.expression(one) for one in arguments]
        if name == "len":
            return f"{texts[0]}.length"
        return texts[0] if name == "float" else f"{LIBRARY.get(name, name)}({', '.join(texts)})"

    def attribute(self, structure: str, name: str) -> str:
        return f"{structure}.{name}"

    def constant(self, name: str) -> str:
        self.used.add(name)
        return name

    def whole_quotient(self, left: str, right: str) -> str:
        return f"Math.floor({left} / {right})"

    def remainder(self, left: str, right: str) -> str:
        return f"{left} % {right}"
