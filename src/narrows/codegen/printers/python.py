"""Lines as Python: one function of floats or columns; the caller provides the elementary functions."""

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import sympy
from sympy.printing.pycode import PythonCodePrinter

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Assignment, Constants, straight_lines

# Highest power that is written as a product, and digits that exceed those of a double.
LONGEST_PRODUCT, DIGITS = 4, 20


class Arithmetic(PythonCodePrinter):  # type: ignore[misc]
    """SymPy's printer of Python, with short powers as products and the function names of ``lines``."""

    # Name of the table of a waterway.
    TABLE = "table"

    def __init__(self) -> None:
        super().__init__({"fully_qualified_modules": False})

    def called(self, name: str, *arguments: str) -> str:
        return f"{name}({', '.join(arguments)})"

    def _print_Float(self, value: Expr) -> str:
        text = repr(abs(float(value.evalf(DIGITS))))
        return f"-{text}" if value < 0 else text

    _print_Rational = _print_Half = _print_Integer = _print_Zero = _print_One = _print_NegativeOne = _print_Float
    _print_NumberSymbol = _print_Exp1 = _print_Pi = _print_Float

    def _print_Abs(self, value: Expr) -> str:
        return self.called("abs", self._print(value.args[0]))

    def _print_exp(self, value: Expr) -> str:
        return self.called("exp", self._print(value.args[0]))

    def _print_log(self, value: Expr) -> str:
        return self.called("log", self._print(value.args[0]))

    def _print_Pow(self, value: Expr, **_: Any) -> str:
        base, power = value.args
        if base == sympy.E:
            return self.called("exp", self._print(power))
        if power.is_Rational and power < 0:
            return f"(1.0 / {self.parenthesize(sympy.Pow(base, -power), 1000)})"
        if power.is_Integer and power <= LONGEST_PRODUCT:
            return "(" + " * ".join([self.parenthesize(base, 1000)] * int(power)) + ")"
        if power == sympy.Rational(1, 2):
            return self.called("sqrt", self._print(base))
        if power.is_Rational and power.q == 2:
            whole = self.parenthesize(base ** (power - sympy.Rational(1, 2)), 1000)
            return f"({whole} * {self.called('sqrt', self._print(base))})"
        if base.is_number and not power.is_number:
            return self.called("exp", self._print(power * sympy.log(base).evalf(DIGITS)))
        return self.called("power", self._print(base), self._print(power))

    def _print_Function(self, value: Expr) -> str:
        name = str(value.func)
        if name == "entry":
            return self.called(name, self.TABLE, str(value.args[0]), self._print(value.args[1]))
        return self.called(name, *map(self._print, value.args))


plain = Arithmetic()


def function_text(
    name: str, arguments: Sequence[str], assignments: Iterable[Assignment], results: Iterable[Expr],
    head: Iterable[str] = (),
) -> str:  # fmt: skip
    body = [*head, *(f"{target} = {plain.doprint(value)}" for target, value in assignments)]
    values = ", ".join(plain.doprint(sympy.sympify(value)) for value in results)
    return "\n    ".join([f"def {name}({', '.join(arguments)}):", *body, f"return ({values},)"]) + "\n"


def constants_text(parameters: Mapping[str, Expr], constants: Constants) -> str:
    """Print the function ``constants`` of the parameters, with the names of its arguments and results."""
    assignments, results = straight_lines(list(constants.table))
    text = function_text("constants", [str(symbol) for symbol in parameters.values()], assignments, results)
    return f"PARAMETERS = {tuple(parameters)!r}\nCONSTANTS = {constants.names!r}\n\n\n{text}"


# Source of plain Python functions: find calls, and fold constants before translation.
@dataclass
class PlainSource:
    """Functions for translation, with the constants that they use."""

    texts: tuple[str, ...]  # Modules; a function of an earlier one may be called in a later
    numbers: Mapping[str, Any] = field(default_factory=dict)  # Constants that replace those of the modules
    absent: frozenset[str] = frozenset()  # Omitted arguments

    def __post_init__(self) -> None:
        bodies = [ast.parse(text).body for text in self.texts]
        found = {name: value for body in bodies for node in body for name, value in _constants(node)}
        self.constants: dict[str, Any] = {**found, **self.numbers}
        # Meaning of each constant: the text below its assignment.
        self.about = {
            name: meaning
            for body in bodies
            for node, below in pairwise(body)
            if (meaning := _text_of(below))
            for name, _ in _constants(node)
        }
        folded = [Folding(self.constants).visit(node) for body in bodies for node in body]
        self.functions = {node.name: node for node in folded if isinstance(node, ast.FunctionDef)}

    def needed(self, *names: str) -> list[ast.FunctionDef]:
        """Return some functions, each after those that it calls."""
        order: dict[str, ast.FunctionDef] = {}

        def visit(name: str) -> None:
            for inner in ast.walk(self.functions[name]):
                called = inner.func.id if isinstance(inner, ast.Call) and isinstance(inner.func, ast.Name) else name
                if called != name and called in self.functions and called not in order:
                    visit(called)
            order.setdefault(name, self.functions[name])

        for name in names:
            visit(name)
        return list(order.values())


class Folding(ast.NodeTransformer):
    """Removes branches that the constants exclude."""

    def __init__(self, constants: Mapping[str, Any]) -> None:
        self.constants = constants

    def visit_Name(self, node: ast.Name) -> ast.expr:
        value = self.constants.get(node.id)
        return ast.Constant(value) if isinstance(value, bool) else node

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        name, (sign,), (other,) = node.left, node.ops, node.comparators
        known = self.constants.get(name.id) if isinstance(name, ast.Name) else None
        if isinstance(known, float) and isinstance(sign, ast.Gt) and isinstance(other, ast.Constant):
            return ast.Constant(known > float(str(other.value)))
        return node

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.expr:
        self.generic_visit(node)
        if isinstance(node.op, ast.Or):
            return node
        if any(_truth(part) is False for part in node.values):
            return ast.Constant(False)
        node.values = [part for part in node.values if _truth(part) is None]
        return node if len(node.values) > 1 else node.values[0]

    def visit_If(self, node: Any) -> Any:
        self.generic_visit(node)
        known = _truth(node.test)
        return node if known is None else node.body if known else node.orelse

    visit_IfExp = visit_If


def _truth(node: ast.expr) -> bool | None:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, bool) else None


def _text_of(node: ast.stmt) -> str:
    value = node.value.value if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) else ""
    return " ".join(value.split()) if isinstance(value, str) else ""


def _constants(node: ast.stmt) -> Iterator[tuple[str, Any]]:
    if not isinstance(node, ast.Assign):
        return
    try:
        value = ast.literal_eval(node.value)
    except ValueError:
        return
    for target in node.targets:
        if isinstance(target, ast.Tuple):
            yield from (
                (name.id, one) for name, one in zip(target.elts, value, strict=True) if isinstance(name, ast.Name)
            )
        elif isinstance(target, ast.Name):
            yield target.id, value
