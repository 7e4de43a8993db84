"""Plain functions of Python as functions of JavaScript."""

import ast
from collections.abc import Iterator, Sequence

from narrows.codegen.printers.language import JavaScript
from narrows.codegen.printers.translation import Translation


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
        return texts[0] if name == "float" else f"{JavaScript.LIBRARY.get(name, name)}({', '.join(texts)})"

    def attribute(self, structure: str, name: str) -> str:
        return f"{structure}.{name}"

    def constant(self, name: str) -> str:
        self.used.add(name)
        return name

    def whole_quotient(self, left: str, right: str) -> str:
        return f"Math.floor({left} / {right})"

    def remainder(self, left: str, right: str) -> str:
        return f"{left} % {right}"
