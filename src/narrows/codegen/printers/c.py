"""Lines as C99: structure members are unpacked before their first use, then one assignment a line."""

import ast
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import ClassVar

import sympy

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import LaneLoops, Lines, asked_by, rounds
from narrows.codegen.printers.translation import Language, Translation

# Functions of <math.h> by their names in lines and plain functions.
LIBRARY = {"abs": "fabs", "exp": "exp", "log": "log", "sqrt": "sqrt", "power": "pow", "sine": "sin", "cosine": "cos",
           "floor": "floor", "hypot": "hypot", "cos": "cos", "sin": "sin"}  # fmt: skip


class C(Language):
    TAKEN = frozenset({
        "auto", "bool", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum",
        "extern", "false", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return",
        "short", "signed", "sizeof", "static", "struct", "switch", "true", "typedef", "union", "unsigned", "void",
        "volatile", "while", "INFINITY", "NAN", "near", "far", "small", "main", "state", "inputs", "constants",
        "parameters", "waterway", "result", "after", "lane", "rows", *LIBRARY.values(),
    })  # fmt: skip
    FIELD, DECLARED = "{}->{}", "const double {} = {};"
    INFINITE, NO_NUMBER = "INFINITY", "NAN"

    def called(self, name: str, *arguments: str) -> str:
        return super().called(LIBRARY.get(name, f"{self.prefix}_{name}"), *arguments)


# Plain functions as C99: one static function each.
TYPES = {"Array": "double *", "StepState": "double *", "float": "double ", "int": "int ", "bool": "bool "}
STRUCTURES = {"Inputs": "inputs", "Constants": "constants", "Place": "waterway"}


class CTranslation(Translation):
    """Plain functions in C; the caller provides the array for a returned tuple."""

    OPERATORS: ClassVar = Translation.OPERATORS | {
        ast.Eq: "==", ast.NotEq: "!=", ast.FloorDiv: "{} / {}", ast.Mod: "fmod({}, {})",
    }  # fmt: skip
    INFINITE, NO_NUMBER = C.INFINITE, C.NO_NUMBER
    FIELD, ARRAY, HELD = C.FIELD, "double {}[{}] = {{0.0}};", "const double {} = {};"

    def head(self) -> str:
        arguments = [text for one in self.parameters() for text in self._declared(one)]
        returns, kind = self.function.returns, "void"
        if isinstance(returns, ast.Subscript):
            arguments.append("double *result")
        elif isinstance(returns, ast.Name):
            kind = TYPES[returns.id].strip()
        return f"static inline {kind} {self.prefix}_{self.function.name}({', '.join(arguments)}) {{"

    def _declared(self, argument: ast.arg) -> Iterator[str]:
        kind = ast.unparse(argument.annotation) if argument.annotation else ""
        if kind.startswith("Sequence"):
            yield f"const double *{argument.arg}"
            yield f"int {argument.arg}_length"
        elif kind in STRUCTURES:
            yield f"const {self.prefix}_{STRUCTURES[kind]} *{argument.arg}"
        else:
            constant = "const " if kind == "Array" and argument.arg not in self._written_arrays() else ""
            yield f"{constant}{TYPES[kind]}{self.variable(argument.arg)}"

    def variable(self, name: str) -> str:
        return name if name in STRUCTURES.values() or name in ("state", "after") else C().named(name)

    def _written_arrays(self) -> set[str]:
        stored = (node for node in ast.walk(self.function) if isinstance(node, ast.Subscript))
        return {"closeness", "end", "after"} | {
            node.value.id for node in stored if isinstance(node.ctx, ast.Store) and isinstance(node.value, ast.Name)
        }

    def declarations(self) -> list[str]:
        names = {one.arg for one in self.parameters()}
        unused = names - {one.id for one in ast.walk(self.function) if isinstance(one, ast.Name)}
        kinds = {name: kind for name, kind in self.assigned().items() if name not in names}
        return [f"(void){name};" for name in sorted(unused)] + [
            f"{TYPES[kind]}{', '.join(own)};"
            for kind in ("int", "bool", "float")
            if (own := [name for name in kinds if kinds[name] == kind])
        ]

    def from_call(self, targets: Sequence[ast.expr], call: ast.Call) -> Iterator[str]:
        assert isinstance(call.func, ast.Name)
        name, self.held_numbers = f"held_{self.held_numbers}", self.held_numbers + 1
        yield self.ARRAY.format(name, len(targets))
        yield f"{self._call_of(call.func.id, self.arguments(call), name)};"
        kinds = self.assigned()
        for number, target in enumerate(map(self.expression, targets)):
            yield f"{target} = {'(int)' if kinds.get(target) == 'int' else ''}{name}[{number}];"

    def returned(self, values: Sequence[ast.expr]) -> Iterator[str]:
        for number, value in enumerate(values):
            yield f"result[{number}] = {self.expression(value)};"
        yield "return;"

    def called(self, name: str, arguments: Sequence[ast.expr]) -> str:
        if name == "len":
            return f"{self.expression(arguments[0])}_length"
        texts = ", ".join(self.expression(one) for one in arguments)
        if name in ("int", "float"):
            return f"({'int' if name == 'int' else 'double'})({texts})"
        if name in LIBRARY:
            return f"{LIBRARY[name]}({texts})"
        return self._call_of(name, arguments)

    def _call_of(self, name: str, arguments: Sequence[ast.expr], *results: str) -> str:
        function = self.source.functions.get(name)
        known = [one for one in function.args.args if one.arg not in self.source.absent] if function else []
        texts = []
        for number, argument in enumerate(arguments):
            texts.append(self.expression(argument))
            kind = known[number].annotation if known else None
            if kind is not None and ast.unparse(kind).startswith("Sequence"):
                texts.append(f"{texts[-1]}_length")
        return f"{self.prefix}_{name}({', '.join([*texts, *results])})"


# A step in C over a block of vessels: the lines of one vessel in loops over lanes, which compilers vectorise. Functions
# but those of <math.h> with processor instructions:
CALLED = tuple(f"{name}(" for name in {*LIBRARY.values(), "angle"} - {"fabs", "sqrt", "floor"})


class BlockC(C):
    """C in loops over lanes: sine, cosine and exponential are ``polynomials``."""

    def called(self, name: str, *arguments: str) -> str:
        return super().called(f"lane_{name}" if name in ("sine", "cosine", "exp") else name, *arguments)


def c_block(lines: Lines, results: Mapping[str, Expr], places: Mapping[str, str], printer: C, lanes: str) -> list[str]:
    # Calls of the library and reads of a waterway's table at a computed place have loops of their own, so that a
    # compiler makes vectors of the others.
    values = tuple(map(sympy.sympify, results.values()))
    needed = lines.needed_for(values)
    parts = rounds(
        needed, lambda value: str(value.func) == "entry" or any(name in printer.doprint(value) for name in CALLED)
    )
    loops = LaneLoops(parts, values)
    rows = {name: f"rows[{field}][lane]" for field, name in enumerate(chain.from_iterable(loops.stored))}
    shared = [name for name in asked_by(needed.assignments, values) if "lane]" not in places[name]]
    body = [*printer.unpacked(shared, places), *[f"double rows[{len(rows)}][{lanes}];"] * bool(rows)]
    for number in range(len(parts)):
        inside = printer.loop_body(loops, number, {**places, **rows})
        if number == len(parts) - 1:
            inside += [f"{target} = {printer.doprint(value)};" for target, value in zip(results, values, strict=True)]
        body += [f"for (int lane = 0; lane < {lanes}; ++lane) {{", *(f"    {line}" for line in inside), "}"]
    return body
