"""Plain functions of Python in another language: the rule of contact and the banks of a waterway, written once.

It supports a part of Python: floats, whole numbers, arrays of floats, returned tuples, loops over ranges and short
tuples.
"""

import ast
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence

from narrows.codegen.printers.language import JavaScript
from narrows.codegen.printers.python import PlainSource

LOOSE, TIGHT = 0, 1


class Translation(ABC):
    """Statements and expressions in the syntax of languages with braces."""

    INFINITE = "INFINITY"
    NO_NUMBER = "NAN"
    EQUAL, UNEQUAL = "==", "!="

    def __init__(self, source: PlainSource) -> None:
        self.source = source
        self.function: ast.FunctionDef
        self.held_numbers = 0
        self.used: set[str] = set()

    @abstractmethod
    def called(self, name: str, arguments: Sequence[ast.expr]) -> str:
        """A call of a function."""

    @abstractmethod
    def attribute(self, structure: str, name: str) -> str:
        """A field of a structure."""

    @abstractmethod
    def constant(self, name: str) -> str:
        """A constant of the modules by its name."""

    def variable(self, name: str) -> str:
        return name

    @abstractmethod
    def whole_quotient(self, left: str, right: str) -> str:
        """Whole-number quotient."""

    @abstractmethod
    def remainder(self, left: str, right: str) -> str:
        """Remainder of one non-negative number by another."""

    def arguments(self, call: ast.Call) -> list[ast.expr]:
        """Arguments of a call that exist in the translation."""
        return [one for one in call.args if not (isinstance(one, ast.Name) and one.id in self.source.absent)]

    def expression(self, node: ast.expr, tight: int = LOOSE) -> str:
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

    def text(self, function: ast.FunctionDef) -> str:
        self.function, self.held_numbers = function, 0
        body = [line for statement in function.body[1:] for line in self.statement(statement)]
        about = " ".join((ast.get_docstring(function) or "").split())
        lines = [*self.declarations(), *body]
        return "\n".join([f"/** {about} */", self.head(), *(f"    {line}" for line in lines), "}"])

    @abstractmethod
    def head(self) -> str:
        """First line of the function."""

    @abstractmethod
    def declarations(self) -> list[str]:
        """Lines before the first statement."""

    @abstractmethod
    def array(self, name: str, size: str) -> str:
        """Line that makes an array of zeros."""

    @abstractmethod
    def held(self, name: str, value: str) -> str:
        """Line that assigns a number."""

    @abstractmethod
    def from_call(self, targets: Sequence[ast.expr], call: ast.Call) -> Iterator[str]:
        """Lines that unpack the tuple of a call."""

    @abstractmethod
    def returned(self, values: Sequence[ast.expr]) -> Iterator[str]:
        """Lines that return a tuple."""

    @abstractmethod
    def over_tuple(self, node: ast.For) -> Iterator[str]:
        """Lines that begin a loop over a tuple of numbers, or of tuples of them."""

    def parameters(self) -> list[ast.arg]:
        return [one for one in self.function.args.args if one.arg not in self.source.absent]

    def assigned(self) -> dict[str, list[ast.expr | None]]:
        """Variables of the function with their assignments; None for a part of a tuple."""
        known: dict[str, list[ast.expr | None]] = {}
        for node in ast.walk(self.function):
            for target, value in self._pairs(node):
                if isinstance(target, ast.Name):
                    known.setdefault(target.id, []).append(value)
        return {name: values for name, values in known.items() if not any(_is_array(value) for value in values)}

    def _pairs(self, node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr | None]]:
        if isinstance(node, ast.For):
            elements = node.target.elts if isinstance(node.target, ast.Tuple) else [node.target]
            yield from ((one, node.iter) for one in elements)
        elif isinstance(node, ast.Assign):
            (target,) = node.targets
            if not isinstance(target, ast.Tuple):
                yield target, node.value
            elif isinstance(node.value, ast.Tuple):
                yield from zip(target.elts, node.value.elts, strict=True)
            elif isinstance(node.value, ast.Call):
                whole = [ast.Constant(0) if one else None for one in self.whole_results(node.value)]
                yield from zip(target.elts, whole, strict=True)

    def whole_results(self, call: ast.Call) -> list[bool]:
        """Return whether each number of a call's tuple is a whole one."""
        assert isinstance(call.func, ast.Name)
        returned = self.source.functions[call.func.id].returns
        assert isinstance(returned, ast.Subscript)
        assert isinstance(returned.slice, ast.Tuple)
        return [ast.unparse(one) == "int" for one in returned.slice.elts]

    def statement(self, node: ast.stmt) -> list[str]:
        return list(getattr(self, f"_{type(node).__name__.lower()}")(node))

    def block(self, nodes: Sequence[ast.stmt]) -> list[str]:
        """Return the lines of statements, indented."""
        return [f"    {line}" for node in nodes for line in self.statement(node)]

    def _expr(self, node: ast.Expr) -> Iterator[str]:
        yield f"{self.expression(node.value)};"

    def _assign(self, node: ast.Assign) -> Iterator[str]:
        (target,), value = node.targets, node.value
        if _is_array(value):
            assert isinstance(value, ast.BinOp)
            assert isinstance(target, ast.Name)
            yield self.array(target.id, self.expression(value.right))
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Call):
            yield from self.from_call(target.elts, value)
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            yield from self._at_once(target.elts, value.elts)
        else:
            yield f"{self.expression(target)} = {self.expression(value)};"

    def _at_once(self, targets: Sequence[ast.expr], values: Sequence[ast.expr]) -> Iterator[str]:
        """Assign several numbers at once; temporaries where one is both written and read."""
        names, texts = [self.expression(one) for one in targets], [self.expression(one) for one in values]
        written = {one.id for target in targets for one in _names(target)}
        if written & {one.id for value in values for one in _names(value)}:
            first, self.held_numbers = self.held_numbers, self.held_numbers + len(texts)
            held = [f"held_{number}" for number in range(first, self.held_numbers)]
            yield from (self.held(name, text) for name, text in zip(held, texts, strict=True))
            texts = held
        yield from (f"{name} = {text};" for name, text in zip(names, texts, strict=True))

    def _annassign(self, node: ast.AnnAssign) -> Iterator[str]:
        assert node.value is not None
        yield f"{self.expression(node.target)} = {self.expression(node.value)};"

    def _augassign(self, node: ast.AugAssign) -> Iterator[str]:
        yield f"{self.expression(node.target)} {OPERATORS[type(node.op)]}= {self.expression(node.value)};"

    def _if(self, node: ast.If) -> Iterator[str]:
        yield f"if ({self.expression(node.test)}) {{"
        yield from self.block(node.body)
        if node.orelse:
            yield "} else {"
            yield from self.block(node.orelse)
        yield "}"

    def _while(self, node: ast.While) -> Iterator[str]:
        yield f"while ({self.expression(node.test)}) {{"
        yield from self.block(node.body)
        yield "}"

    def _for(self, node: ast.For) -> Iterator[str]:
        if isinstance(node.iter, ast.Call):
            texts = [self.expression(one) for one in node.iter.args]
            first, last, step = ["0", *texts, "1"] if len(texts) == 1 else [*texts, "1"][:3]
            name = self.expression(node.target)
            yield f"for ({name} = {first}; {name} < {last}; {name} += {step}) {{"
        else:
            yield from self.over_tuple(node)
        yield from self.block(node.body)
        yield "}"

    def _return(self, node: ast.Return) -> Iterator[str]:
        if isinstance(node.value, ast.Tuple):
            yield from self.returned(node.value.elts)
        elif node.value is None:
            yield "return;"
        else:
            yield f"return {self.expression(node.value)};"

    def _break(self, _: ast.Break) -> Iterator[str]:
        yield "break;"

    def _continue(self, _: ast.Continue) -> Iterator[str]:
        yield "continue;"


def _names(node: ast.AST) -> Iterator[ast.Name]:
    return (one for one in ast.walk(node) if isinstance(one, ast.Name))


def _is_array(value: ast.expr | None) -> bool:
    return isinstance(value, ast.BinOp) and isinstance(value.left, ast.List)


# Operators of languages with braces.
OPERATORS: Mapping[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
    ast.And: "&&", ast.Or: "||", ast.Not: "!", ast.USub: "-",
}  # fmt: skip


class JavaScriptTranslation(Translation):
    """Plain functions in JavaScript; a tuple becomes an array."""

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
