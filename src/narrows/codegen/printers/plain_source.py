"""Plain functions of Python as they are read: what of them is called, what constants decide before it is translated."""

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass
class PlainSource:
    """Functions to be translated, with the constants that they use."""

    texts: tuple[str, ...]  # Modules; a function of an earlier one may be called in a later
    numbers: Mapping[str, Any] = field(default_factory=dict)  # Constants that stand for those of the modules
    absent: frozenset[str] = frozenset()  # Arguments that are left out

    def __post_init__(self) -> None:
        bodies = [ast.parse(text).body for text in self.texts]
        found = {name: value for body in bodies for node in body for name, value in _constants(node)}
        self.constants: dict[str, Any] = {**found, **self.numbers}
        folded = [Folding(self.constants).visit(node) for body in bodies for node in body]
        self.functions = {node.name: node for node in folded if isinstance(node, ast.FunctionDef)}

    def needed(self, *names: str) -> list[ast.FunctionDef]:
        """Return some functions, each behind those that it calls."""
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
    """Leaves out what the constants decide never happens."""

    def __init__(self, constants: Mapping[str, Any]) -> None:
        self.constants = constants

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """A truth by its value."""
        value = self.constants.get(node.id)
        return ast.Constant(value) if isinstance(value, bool) else node

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        """``NAME > 0.0``, where that is known."""
        name, (sign,), (other,) = node.left, node.ops, node.comparators
        known = self.constants.get(name.id) if isinstance(name, ast.Name) else None
        if isinstance(known, float) and isinstance(sign, ast.Gt) and isinstance(other, ast.Constant):
            return ast.Constant(known > float(str(other.value)))
        return node

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.expr:
        """``and`` with a part that is known."""
        self.generic_visit(node)
        if isinstance(node.op, ast.Or):
            return node
        if any(_truth(part) is False for part in node.values):
            return ast.Constant(False)
        node.values = [part for part in node.values if _truth(part) is None]
        return node if len(node.values) > 1 else node.values[0]

    def visit_If(self, node: ast.If) -> ast.If | list[ast.stmt]:
        """A branch that is never taken, or always."""
        self.generic_visit(node)
        known = _truth(node.test)
        return node if known is None else node.body if known else node.orelse

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        """A choice that is known."""
        self.generic_visit(node)
        known = _truth(node.test)
        return node if known is None else node.body if known else node.orelse


def _truth(node: ast.expr) -> bool | None:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, bool) else None


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
