"""Expressions of plain functions in languages with braces."""

import ast
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from narrows.codegen.printers.plain_source import PlainSource

OPERATORS: Mapping[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
    ast.And: "&&", ast.Or: "||", ast.Not: "!", ast.USub: "-",
}  # fmt: skip
LOOSE, TIGHT = 0, 1


class PlainExpressions(ABC):
    """Expressions, as languages with braces write them."""

    INFINITE = "INFINITY"
    NO_NUMBER = "NAN"
    EQUAL, UNEQUAL = "==", "!="

    def __init__(self, source: PlainSource) -> None:
        self.source = source

    @abstractmethod
    def called(self, name: str, arguments: Sequence[ast.expr]) -> str:
        """A call of a function."""

    @abstractmethod
    def attribute(self, structure: str, name: str) -> str:
        """A field of a structure."""

    def variable(self, name: str) -> str:
        """A variable or argument by its name."""
        return name

    @abstractmethod
    def constant(self, name: str) -> str:
        """A constant of the modules by its name."""

    @abstractmethod
    def whole_quotient(self, left: str, right: str) -> str:
        """How often one whole number goes into another."""

    @abstractmethod
    def remainder(self, left: str, right: str) -> str:
        """What is left of one number that is not negative by another."""

    def arguments(self, call: ast.Call) -> list[ast.expr]:
        """Those of a call that are there."""
        return [one for one in call.args if not (isinstance(one, ast.Name) and one.id in self.source.absent)]

    def expression(self, node: ast.expr, tight: int = LOOSE) -> str:
        """Return an expression."""
        text = str(getattr(self, f"_{type(node).__name__.lower()}")(node))
        compound = isinstance(node, ast.BinOp | ast.BoolOp | ast.Compare | ast.IfExp)
        return f"({text})" if compound and tight else text

    def _name(self, node: ast.Name) -> str:
        if node.id in self.source.constants:
            return self.constant(node.id)
        return {"inf": self.INFINITE, "nan": self.NO_NUMBER}.get(node.id) or self.variable(node.id)

    def _constant(self, node: ast.Constant) -> str:
        return repr(node.value).lower() if isinstance(node.value, bool) else repr(node.value)

    def _binop(self, node: ast.BinOp) -> str:
        left, right = self.expression(node.left, TIGHT), self.expression(node.right, TIGHT)
        if isinstance(node.op, ast.FloorDiv):
            return self.whole_quotient(left, right)
        if isinstance(node.op, ast.Mod):
            return self.remainder(left, right)
        return f"{left} {OPERATORS[type(node.op)]} {right}"

    def _unaryop(self, node: ast.UnaryOp) -> str:
        return f"{OPERATORS[type(node.op)]}{self.expression(node.operand, TIGHT)}"

    def _boolop(self, node: ast.BoolOp) -> str:
        return f" {OPERATORS[type(node.op)]} ".join(self.expression(value, TIGHT) for value in node.values)

    def _compare(self, node: ast.Compare) -> str:
        (sign,), (right,) = node.ops, node.comparators
        return f"{self.expression(node.left, TIGHT)} {self.comparison(sign)} {self.expression(right, TIGHT)}"

    def comparison(self, operator: ast.cmpop) -> str:
        """Return the sign of a comparison."""
        if isinstance(operator, ast.Eq | ast.NotEq):
            return self.EQUAL if isinstance(operator, ast.Eq) else self.UNEQUAL
        return OPERATORS[type(operator)]

    def _ifexp(self, node: ast.IfExp) -> str:
        test, over, under = (self.expression(one, TIGHT) for one in (node.test, node.body, node.orelse))
        return f"{test} ? {over} : {under}"

    def _call(self, node: ast.Call) -> str:
        assert isinstance(node.func, ast.Name)
        return self.called(node.func.id, self.arguments(node))

    def _subscript(self, node: ast.Subscript) -> str:
        return f"{self.expression(node.value)}[{self.expression(node.slice)}]"

    def _attribute(self, node: ast.Attribute) -> str:
        return self.attribute(self.expression(node.value), node.attr)
