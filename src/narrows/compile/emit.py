"""Straight-line functions from traced equations: what depends on parameters alone apart from what moves.

The ``constants`` function holds everything that stays the same through a voyage: the inverse mass matrix times the
coefficients, half the width, the bank's pressure times its area. The functions that run at each step take those
constants, and hold the rest after common subexpressions are taken out.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from narrows.compile.contact import Contact
from narrows.compile.spell import PLAIN, Style, lines
from narrows.compile.trace import ACCELERATIONS, ARGUMENTS, INPUTS, STATE, Expr, Traced, symbol

Inputs = Literal["arguments", "constants", "none"]
POSE = ("y", "cos_psi", "sin_psi")


@dataclass
class Constants:
    """The expressions of parameters that the moving part uses, each under the name of a constant.

    Parameters
    ----------
    parameters : set of symbol
        What does not change in a voyage.
    """

    parameters: set[Expr]
    table: dict[Expr, Expr] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """What the constants are called, in order."""
        return tuple(str(name) for name in self.table.values())

    def lift(self, expression: Expr) -> Expr:
        """Replace every part of an expression that parameters alone decide with a constant."""
        symbols = expression.free_symbols
        if not symbols & self.parameters:
            return expression
        if symbols <= self.parameters:
            return self._named(expression)
        if not (expression.is_Add or expression.is_Mul):
            return expression.func(*map(self.lift, expression.args))
        fixed = [a for a in expression.args if a.free_symbols <= self.parameters]
        moving = [self.lift(a) for a in expression.args if a not in fixed]
        return expression.func(self.lift(expression.func(*fixed)), *moving)

    def _named(self, expression: Expr) -> Expr:
        return self.table.setdefault(expression, symbol(f"k{len(self.table)}"))


def straight_line(expressions: Sequence[Expr]) -> tuple[list[tuple[Expr, Expr]], list[Expr]]:
    """Take out common subexpressions and name what a power repeats (ours).

    Parameters
    ----------
    expressions : sequence of expression
        The results.

    Returns
    -------
    assignments : list of (symbol, expression)
        In order.
    results : list of expression
        The results in terms of them.
    """
    import sympy

    names = sympy.numbered_symbols("t", real=True)
    shared, results = sympy.cse(expressions, symbols=names, order="canonical")
    assignments: list[tuple[Expr, Expr]] = []

    def name_base(base: Expr, exponent: Expr) -> Expr:
        if base.is_Symbol or base.is_number or not exponent.is_Rational or exponent.p in (1, -1):
            return base**exponent
        name = next(names)
        assignments.append((name, base))
        return name**exponent

    for name, expression in shared:
        value = expression.replace(sympy.Pow, name_base)
        assignments.append((name, value))
    return assignments, [result.replace(sympy.Pow, name_base) for result in results]


def function(name: str, arguments: Iterable[str], results: Sequence[Expr], style: Style, single: bool = False) -> str:
    """Write a function (ours).

    Parameters
    ----------
    name : str
        What it is called.
    arguments : iterable of str
        Its parameters.
    results : sequence of expression
        What it returns.
    style : Style
        How to write numbers and functions.
    single : bool
        Whether it returns its one result instead of a tuple.
    """
    assignments, last = straight_line(results)
    body = lines(assignments, style)
    values = [line.partition(" = ")[2] for line in lines(zip(results, last, strict=True), style)]
    answer = values[0] if single else f"({', '.join(values)},)" if len(values) == 1 else f"({', '.join(values)})"
    return "\n    ".join([f"def {name}({', '.join(arguments)}):", *body, f"return {answer}"]) + "\n"


@dataclass(frozen=True)
class Emitted:
    """The equations of motion and the contact with the banks, ready to be written.

    Parameters
    ----------
    traced : Traced
        The equations.
    constants : Constants
        What the moving part takes, lifted out of it.
    derivatives : tuple of expression
        Of the state, in its order, by state and constants.
    gap, lean : expression
        The room between hull and bank, and the side that is nearer, by state and constants.
    inputs : tuple of str
        The forces and controls that are arguments of the right-hand side.
    """

    traced: Traced
    constants: Constants
    derivatives: tuple[Expr, ...]
    gap: Expr
    lean: Expr
    inputs: tuple[str, ...]

    def function(self, name: str, style: Style) -> str:
        """Write ``rhs``, ``gap`` or ``lean``."""
        if name == "rhs":
            return function(name, (*STATE, *self.inputs, *self.constants.names), self.derivatives, style)
        return function(name, (*POSE, *self.constants.names), [getattr(self, name)], style, single=True)

    def prologue(self) -> str:
        """Write ``PARAMETERS``, the names that a caller uses, and the function ``constants`` of them."""
        expressions = list(self.constants.table)
        used = set().union(*(e.free_symbols for e in expressions))
        names = {n: s for n, s in self.traced.names.items() if s in used}
        names |= {str(s): s for s in sorted(used - set(names.values()), key=str)}  # an outline's points
        text = function("constants", map(str, names.values()), expressions, PLAIN)
        return f"PARAMETERS = {tuple(names)!r}\n\n\n{text}"


def emit(traced: Traced, contact: Contact, inputs: Inputs) -> Emitted:
    """Part the equations into constants and what moves.

    Parameters
    ----------
    traced : Traced
        The equations of motion.
    contact : Contact
        Where hull and bank meet.
    inputs : {"arguments", "constants", "none"}
        Whether forces from outside and controls change in a voyage, stay as they are, or no force is there.
    """
    arguments = ARGUMENTS if inputs == "arguments" else ()
    parameters = {s for name, s in traced.names.items() if name not in arguments}
    constants = Constants(parameters | set(contact.parameters))
    pushes = {} if inputs == "none" else {f: symbol(INPUTS[f]) for f in traced.freedoms}
    derivatives = _derivatives(traced, constants.lift, pushes)
    gap, lean = constants.lift(contact.gap), constants.lift(contact.lean)
    return Emitted(traced, constants, derivatives, gap, lean, arguments)


PLAIN_HEADER = '''"""Made by narrows {version} from a table of terms: made again where it is missing, so do not edit."""
E = 2.718281828459045


def larger(a, b):
    return 0.5 * (a + b + abs(a - b))


def smaller(a, b):
    return 0.5 * (a + b - abs(a - b))
'''


def plain_text(emitted: Emitted, version: str) -> str:
    """Write the module that evaluates floats and columns.

    Parameters
    ----------
    emitted : Emitted
        The equations, with inputs as arguments.
    version : str
        Of narrows.
    """
    functions = (emitted.function(name, PLAIN) for name in ("rhs", "gap", "lean"))
    return "\n\n".join([PLAIN_HEADER.format(version=version), emitted.prologue(), *functions])


def _derivatives(traced: Traced, lift: Callable[[Expr], Expr], pushes: Mapping[str, Expr]) -> tuple[Expr, ...]:
    import sympy

    c, s, u, v, r = (symbol(name) for name in ("cos_psi", "sin_psi", "u", "v", "r"))
    basis = [lift(expression) for expression in traced.basis]
    accelerations = dict.fromkeys(ACCELERATIONS, sympy.Integer(0))
    for force, gains, row in zip(traced.freedoms, traced.gains, traced.pushes, strict=True):
        parts = [(lift(gain), function) for gain, function in zip(gains, basis, strict=True)]
        pushed = sum((lift(part * pushes[f]) for f, part in zip(traced.freedoms, row, strict=True) if f in pushes), 0)
        accelerations[force] = _grouped(parts, (v, r)) + pushed
    return (u * c - v * s, u * s + v * c, -r * s, r * c, *accelerations.values())


def _grouped(parts: Iterable[tuple[Expr, Expr]], factors: Sequence[Expr]) -> Expr:
    """Sum gains times functions, with what multiplies each factor gathered: v (k0 + k1 |v|), not k0 v + k1 |v| v."""
    import sympy

    total, gathered = sympy.Integer(0), dict.fromkeys(factors, sympy.Integer(0))
    for gain, basis in parts:
        factor = next((f for f in factors if f in sympy.Mul.make_args(basis)), None)
        if factor is None:
            total += gain * basis
        else:
            gathered[factor] += gain * (basis / factor)
    return total + sum((factor * inner for factor, inner in gathered.items()), sympy.Integer(0))
