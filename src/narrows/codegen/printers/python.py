"""Lines as Python: functions of floats or columns, and modules with elementary functions for the compiler."""

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from itertools import pairwise
from math import factorial
from typing import Any

import sympy
from sympy.printing.pycode import PythonCodePrinter

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Assignment, Constants, straight_lines

LONGEST_PRODUCT, DIGITS = 4, 20  # Highest power that is written as a product, and digits that exceed those of a double


class Arithmetic(PythonCodePrinter):  # type: ignore[misc]
    """SymPy's printer of Python, with short powers as products and the function names of ``lines``."""

    TABLE = "table"  # Name of the table of a waterway

    def __init__(self) -> None:
        super().__init__({"fully_qualified_modules": False})

    def called(self, name: str, *arguments: str) -> str:
        return f"{name}({', '.join(arguments)})"

    def _print_Float(self, value: Expr) -> str:
        text = repr(abs(float(value.evalf(DIGITS))))
        return f"-{text}" if value < 0 else text

    _print_Rational = _print_Half = _print_Integer = _print_Zero = _print_One = _print_NegativeOne = _print_Float
    _print_NumberSymbol = _print_Exp1 = _print_Pi = _print_Float

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
        name = str(value.func).lower()
        if name == "entry":
            return self.called(name, self.TABLE, str(value.args[0]), self._print(value.args[1]))
        return self.called(name, *map(self._print, value.args))

    _print_Abs = _print_exp = _print_log = _print_Function


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
    texts: tuple[str, ...]  # Modules; a function of an earlier one may be called in a later
    numbers: Mapping[str, Any] = field(default_factory=dict)  # Constants that replace those of the modules
    absent: frozenset[str] = frozenset()  # Omitted arguments

    def __post_init__(self) -> None:
        bodies = [ast.parse(text).body for text in self.texts]
        found = {name: value for body in bodies for node in body for name, value in _constants(node)}
        self.constants: dict[str, Any] = {**found, **self.numbers}
        # Meaning of each constant: the text below its assignment.
        self.about = {
            name: " ".join(meaning.split())
            for body in bodies
            for node, below in pairwise(body)
            if (meaning := ast.get_docstring(ast.Module([below], [])))
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
        self.constants = dict(constants)

    def _known(self, test: ast.expr) -> bool | None:
        """Return the truth of a test of constants alone."""
        names = {node.id for node in ast.walk(test) if isinstance(node, ast.Name)}
        return bool(eval(ast.unparse(test), self.constants)) if names <= self.constants.keys() else None

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.expr:
        self.generic_visit(node)
        if isinstance(node.op, ast.Or):
            return node
        known = [self._known(part) for part in node.values]
        node.values = [part for part, truth in zip(node.values, known, strict=True) if truth is None]
        if False in known or not node.values:
            return ast.Constant(False not in known)
        return node if len(node.values) > 1 else node.values[0]

    def visit_If(self, node: Any) -> Any:
        self.generic_visit(node)
        known = self._known(node.test)
        return node if known is None else node.body if known else node.orelse

    visit_IfExp = visit_If


def _constants(node: ast.stmt) -> Iterator[tuple[str, Any]]:
    if not isinstance(node, ast.Assign):
        return
    try:
        value = ast.literal_eval(node.value)
    except ValueError:
        return
    for target in node.targets:
        pairs = zip(target.elts, value, strict=True) if isinstance(target, ast.Tuple) else [(target, value)]
        yield from ((name.id, one) for name, one in pairs if isinstance(name, ast.Name))


# Elementary functions without branches or calls of the C library, so that loops over lanes vectorise.
# Terms of the series of sine and cosine: exact to the last place up to a quarter turn, enough for any rudder.
SINE_TERMS = 11
# Coefficients of (arctan t)/t in t squared up to 22.51 degrees: interpolated at Chebyshev's points with 50 digits.
ARCTANGENT = (
    1.0, -0.3333333333333312, 0.19999999999940354, -0.1428571427919797, 0.11111110742319581, -0.09090896733922893,
    0.07692043981943032, -0.06662936310726283, 0.05846764171822936, -0.05034582119172788, 0.03795188185921145,
    -0.017790581120278405,
)  # fmt: skip
EXPONENTIAL_DEGREE = 13

# The exponential, to one unit in the last place, is e^x = 2^k e^r with k the nearest integer to x / ln 2, itself in two
# parts: Cody and Waite (1980), Software Manual for the Elementary Functions. Adding 1.5 2^52 rounds to that integer and
# leaves it in the low bits; a shift puts it into the exponent: a reason why kernels are compiled without ``reassoc``.
# An angle is a rotation by multiples of 45 degrees, one division and a short polynomial.
HEADER = '''"""Made by narrows {version} from a table of terms: made again where it is missing, so do not edit."""
import numpy as np
from numpy import float64 as real
from numpy import cos, log, sin, sqrt

CELL_ENTRIES = {cells}

# Without a compiler the functions run as written. NumPy's roots and quotients raise no errors, like compiled ones.
quiet = np.errstate(all="ignore")


def entry(table, column, cell):
    return table[CELL_ENTRIES * int(cell) + int(column)]


def minimum(a, b):
    return a if a < b else b


def maximum(a, b):
    return a if a > b else b


def choice(test, over, under):
    return over if test > 0.0 else under


def where(flag, over, under):
    return over if flag else under


def positive(test):
    return 1.0 if test > 0.0 else 0.0


def whole(number):
    return real(np.int64(number))


def power(base, exponent):
    return base**exponent


def exp(x):
    x = minimum(709.0, maximum(-708.0, x))
    shifted = x * 1.4426950408889634 + 6755399441055744.0
    whole = shifted - 6755399441055744.0
    r = x - whole * 0.6931471803691238 - whole * 1.9082149292705877e-10
    power = np.int64((real(shifted).view(np.int64) + 1023) << 52)
    return ({exp}) * power.view(real)


def sine(a):
    q = a * a
    return a * ({sine})


def cosine(a):
    q = a * a
    return {cosine}


def angle(cosine, sine):
    a, b = abs(sine), abs(cosine)
    some, most = a > 0.41421356237309503 * b, a > 2.414213562373095 * b
    turn_c = 0.0 if most else (0.7071067811865476 if some else 1.0)
    turn_s = 1.0 if most else (0.7071067811865476 if some else 0.0)
    by = 1.5707963267948966 if most else (0.7853981633974483 if some else 0.0)
    t = (a * turn_c - b * turn_s) / (b * turn_c + a * turn_s)
    q = t * t
    arctangent = by + t * ({arctangent})
    arctangent = arctangent if cosine >= 0.0 else 3.141592653589793 - arctangent
    return arctangent if sine >= 0.0 else -arctangent
'''


def module_text(cells: int, *parts: str) -> str:
    """Write a module that may call the elementary functions; ``cells`` is the width of a waterway's table."""
    head = HEADER.format(version=version("narrows"), cells=cells, **polynomials())
    return "\n\n\n".join(part.strip() for part in (head, *parts)) + "\n"


def polynomials() -> dict[str, str]:
    """Return the polynomials of the elementary functions, in q, or r for the exponential."""
    sine, cosine = ([(-1) ** k / factorial(2 * k + first) for k in range(SINE_TERMS)] for first in (1, 0))
    exponential = [1 / factorial(k) for k in range(EXPONENTIAL_DEGREE + 1)]
    series = {"sine": sine, "cosine": cosine, "arctangent": ARCTANGENT}
    return {"exp": horner("r", exponential), **{name: horner("q", own) for name, own in series.items()}}


def horner(x: str, coefficients: Sequence[float]) -> str:
    text = repr(coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        text = f"{coefficient!r} + {x} * ({text})"
    return text
