"""Other languages: lines as statements, and plain functions (the rule of contact, the banks of a waterway).

It supports a part of Python: floats, annotated whole numbers and truth values, arrays of floats, returned tuples, loops
over ranges.
"""

import ast
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from keyword import kwlist
from typing import ClassVar

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import LaneLoops, Program
from narrows.codegen.printers.python import Arithmetic, PlainSource


class Language(Arithmetic):
    TABLE = "waterway"
    TAKEN: frozenset[str] = frozenset()  # Reserved words
    LIBRARY: ClassVar[Mapping[str, str]] = {}  # Elementary functions by their names in lines and plain functions
    FIELD, DECLARED, ASSIGNED = "{}.{}", "{} = {};", "{} = {};"
    INFINITE, NO_NUMBER = "inf", "nan"

    def __init__(self, prefix: str = "") -> None:
        super().__init__()
        self.prefix = prefix

    def named(self, name: str) -> str:
        return f"{name}_" if name in self.TAKEN else name

    def literal(self, value: float) -> str:
        text = repr(float(value))
        return {"inf": self.INFINITE, "-inf": f"-{self.INFINITE}", "nan": self.NO_NUMBER}.get(text, text)

    def field(self, structure: str, name: str) -> str:
        return self.FIELD.format(structure, self.named(name))

    def called(self, name: str, *arguments: str) -> str:
        return super().called(self.LIBRARY.get(name, name), *arguments)

    def _print_Symbol(self, value: Expr) -> str:
        return self.named(value.name)

    def unpacked(self, names: Iterable[str], places: Mapping[str, str]) -> list[str]:
        return [self.DECLARED.format(self.named(name), places[name]) for name in names if name != places[name]]

    def body(self, program: Program, targets: Sequence[str], places: Mapping[str, str]) -> list[str]:
        lines = [self.DECLARED.format(*map(self.doprint, line)) for line in program.assignments]
        results = zip(targets, program.results, strict=True)
        assigned = [self.ASSIGNED.format(target, self.doprint(value)) for target, value in results]
        return [*self.unpacked(program.asked, places), *lines, *assigned]

    def loop_body(self, loops: LaneLoops, number: int, places: Mapping[str, str]) -> list[str]:
        """Write a loop over lanes, from the numbers that it reads to those that a later one reads."""
        read = [name for name in sorted(loops.read[number]) if "lane]" in places[name]]
        lines = [self.DECLARED.format(*map(self.doprint, line)) for line in loops.parts[number]]
        stored = [self.ASSIGNED.format(places[name], self.named(name)) for name in loops.stored[number]]
        return [*self.unpacked(read, places), *lines, *stored]


class PythonFile(Language):
    TAKEN = frozenset({
        "state", "inputs", "constants", "parameters", "waterway", "result", "np", "abs", "sine", "cosine", *kwlist,
    })  # fmt: skip
    LIBRARY: ClassVar = {"cos": "np.cos", "sin": "np.sin"}
    DECLARED = ASSIGNED = "{} = {}"


class JavaScript(Language):
    TAKEN = frozenset({
        "await", "break", "case", "catch", "class", "const", "continue", "debugger", "default", "delete", "do", "else",
        "enum", "export", "extends", "false", "finally", "for", "function", "if", "import", "in", "instanceof", "let",
        "new", "null", "return", "static", "super", "switch", "this", "throw", "true", "try", "typeof", "var", "void",
        "while", "with", "yield", "arguments", "eval", "Math", "state", "inputs", "constants", "parameters", "waterway",
        "result",
    })  # fmt: skip
    LIBRARY: ClassVar = {
        **{own: f"Math.{own}" for own in ("abs", "exp", "log", "sqrt", "floor", "hypot", "cos", "sin", "min", "max")},
        "sine": "Math.sin", "cosine": "Math.cos", "power": "Math.pow", "whole": "Math.trunc", "int": "Math.trunc",
    }  # fmt: skip
    DECLARED = "const {} = {};"
    INFINITE, NO_NUMBER = "Infinity", "NaN"


class CSharp(Language):
    LIBRARY: ClassVar = {
        name: re.sub(r"\.(\w)", lambda at: f".{at[1].upper()}", own) for name, own in JavaScript.LIBRARY.items()
    }
    DECLARED = "double {} = {};"


class Matlab(Language):
    TAKEN = frozenset({
        "x", "ui", "xdot", "U", "beyond", "i", "j", "pi", "eps", "end", "for", "if", "while", "function", "otherwise",
    })  # fmt: skip
    LIBRARY: ClassVar = {"sine": "sin", "cosine": "cos", "minimum": "min", "maximum": "max", "whole": "fix"}

    def doprint(self, expression: Expr) -> str:
        return re.sub(r"([*/])", r".\1", super().doprint(expression))


class Translation:
    """Plain functions in JavaScript, where a tuple becomes an array; other languages replace what differs."""

    OPERATORS: ClassVar[dict[type[ast.AST], str]] = {
        ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">",
        ast.GtE: ">=", ast.And: "&&", ast.Or: "||", ast.Not: "!", ast.USub: "-", ast.Eq: "===", ast.NotEq: "!==",
        ast.FloorDiv: "Math.floor({} / {})", ast.Mod: "{} % {}",
    }  # fmt: skip
    INFINITE, NO_NUMBER = JavaScript.INFINITE, JavaScript.NO_NUMBER
    FIELD, ARRAY, HELD = "{}.{}", "const {} = new Float64Array({});", "const {} = {};"

    def __init__(self, source: PlainSource, prefix: str = "") -> None:
        self.source, self.prefix = source, prefix
        self.function: ast.FunctionDef
        self.held_numbers = 0
        self.used: set[str] = set()

    def text(self, function: ast.FunctionDef) -> str:
        self.function, self.held_numbers = function, 0
        body = [line for statement in function.body[1:] for line in self.statement(statement)]
        about = " ".join((ast.get_docstring(function) or "").split())
        lines = [*self.declarations(), *body]
        return "\n".join([f"/** {about} */", self.head(), *(f"    {line}" for line in lines), "}"])

    def head(self) -> str:
        return f"function {self.function.name}({', '.join(one.arg for one in self.parameters())}) {{"

    def declarations(self) -> list[str]:
        names = [name for name in self.assigned() if name not in {one.arg for one in self.parameters()}]
        return [f"let {', '.join(names)};"] if names else []

    def parameters(self) -> list[ast.arg]:
        return [one for one in self.function.args.args if one.arg not in self.source.absent]

    def assigned(self) -> dict[str, str]:
        """Variables of the function by their type: ``float`` unless annotated or counted by a loop."""
        known, stated = dict[str, str](), dict[str, str]()
        for node in ast.walk(self.function):
            match node:
                case ast.AnnAssign(target=ast.Name(id=name), annotation=kind):
                    stated[name] = ast.unparse(kind)
                case ast.For(target=ast.Name(id=name)):
                    stated[name] = "int"
                case ast.Assign(targets=[target], value=value) if not isinstance(getattr(value, "left", 0), ast.List):
                    known |= {one.id: "float" for one in getattr(target, "elts", [target]) if isinstance(one, ast.Name)}
        return known | stated

    def expression(self, node: ast.expr, tight: bool = False) -> str:
        text = self._written(node)
        return f"({text})" if tight and isinstance(node, ast.BinOp | ast.BoolOp | ast.Compare | ast.IfExp) else text

    def _written(self, node: ast.expr) -> str:
        match node:
            case ast.Name(id=name) if name in self.source.constants:
                self.used.add(name)
                return f"{self.prefix.upper()}_{name}" if self.prefix else name
            case ast.Name(id=name):
                return {"inf": self.INFINITE, "nan": self.NO_NUMBER}.get(name) or self.variable(name)
            case ast.Constant(value=value):
                return repr(value).lower() if isinstance(value, bool) else repr(value)
            case ast.BinOp(left=left, op=sign, right=right) | ast.Compare(left=left, ops=[sign], comparators=[right]):
                operator, sides = self.OPERATORS[type(sign)], [self.expression(one, True) for one in (left, right)]
                return operator.format(*sides) if "{" in operator else f" {operator} ".join(sides)
            case ast.UnaryOp(op=sign, operand=value):
                return f"{self.OPERATORS[type(sign)]}{self.expression(value, True)}"
            case ast.BoolOp(op=sign, values=values):
                return f" {self.OPERATORS[type(sign)]} ".join(self.expression(value, True) for value in values)
            case ast.IfExp(test=test, body=over, orelse=under):
                return "{} ? {} : {}".format(*(self.expression(one, True) for one in (test, over, under)))
            case ast.Call(func=ast.Name(id=name)):
                return self.called(name, self.arguments(node))
            case ast.Subscript(value=array, slice=place):
                return f"{self.expression(array)}[{self.expression(place)}]"
            case ast.Attribute(value=structure, attr=name):
                return self.FIELD.format(self.expression(structure), name)
        raise TypeError(f"cannot be translated: {ast.unparse(node)}")

    def variable(self, name: str) -> str:
        return name

    def arguments(self, call: ast.Call) -> list[ast.expr]:
        return [one for one in call.args if not (isinstance(one, ast.Name) and one.id in self.source.absent)]

    def called(self, name: str, arguments: Sequence[ast.expr]) -> str:
        texts = [self.expression(one) for one in arguments]
        if name == "len":
            return f"{texts[0]}.length"
        return texts[0] if name == "float" else f"{JavaScript.LIBRARY.get(name, name)}({', '.join(texts)})"

    def statement(self, node: ast.stmt) -> Iterator[str]:
        match node:
            case ast.Expr(value=value):
                yield f"{self.expression(value)};"
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.BinOp(left=ast.List(), right=size)):
                yield self.ARRAY.format(name, self.expression(size))
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=ast.Call() as call):
                yield from self.from_call(targets, call)
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=ast.Tuple(elts=values)):
                yield from self._at_once(targets, values)
            case ast.Assign(targets=[target], value=value) | ast.AnnAssign(target=target, value=ast.expr() as value):
                yield f"{self.expression(target)} = {self.expression(value)};"
            case ast.AugAssign(target=target, op=sign, value=value):
                yield f"{self.expression(target)} {self.OPERATORS[type(sign)]}= {self.expression(value)};"
            case ast.If(test=test, body=body, orelse=orelse):
                yield from (f"if ({self.expression(test)}) {{", *self.block(body))
                yield from ("} else {", *self.block(orelse)) if orelse else ()
                yield "}"
            case ast.While(test=test, body=body):
                yield from (f"while ({self.expression(test)}) {{", *self.block(body), "}")
            case ast.For(target=target, iter=ast.Call(args=ends), body=body):
                texts, name = [self.expression(one) for one in ends], self.expression(target)
                first, last, step = ["0", *texts, "1"] if len(texts) == 1 else [*texts, "1"][:3]
                yield from (f"for ({name} = {first}; {name} < {last}; {name} += {step}) {{", *self.block(body), "}")
            case ast.AnnAssign(value=None):
                pass
            case ast.Return(value=ast.Tuple(elts=values)):
                yield from self.returned(values)
            case ast.Return(value=value):
                yield f"return {self.expression(value)};" if value else "return;"
            case ast.Break() | ast.Continue():
                yield f"{ast.unparse(node)};"
            case _:
                raise TypeError(f"cannot be translated: {ast.unparse(node)}")

    def block(self, nodes: Sequence[ast.stmt]) -> list[str]:
        return [f"    {line}" for node in nodes for line in self.statement(node)]

    def _at_once(self, targets: Sequence[ast.expr], values: Sequence[ast.expr]) -> Iterator[str]:
        """Assign several numbers at once, by temporaries: one may be both written and read."""
        first, self.held_numbers = self.held_numbers, self.held_numbers + len(values)
        held = [f"held_{number}" for number in range(first, self.held_numbers)]
        yield from (self.HELD.format(name, self.expression(one)) for name, one in zip(held, values, strict=True))
        yield from (f"{self.expression(one)} = {name};" for name, one in zip(held, targets, strict=True))

    def from_call(self, targets: Sequence[ast.expr], call: ast.Call) -> Iterator[str]:
        yield f"[{', '.join(map(self.expression, targets))}] = {self.expression(call)};"

    def returned(self, values: Sequence[ast.expr]) -> Iterator[str]:
        yield f"return [{', '.join(map(self.expression, values))}];"
