"""Straight-line programs: one assignment a line, every name assigned once. All printers print these.

One ``Lines`` holds a whole step (control law, gear, Runge-Kutta, contact); a cut marks where a loop over lanes may be
split.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, reduce
from typing import Any

import sympy
from sympy import Integer

Expr = Any
Assignment = tuple[Expr, Expr]

CUT = None  # A place in the program where a loop may be split

# Functions that printers know, with their partial derivatives by each argument. ``whole`` truncates to an integer,
# ``entry(column, cell)`` reads the table of a waterway, ``positive`` is 1 for numbers above 0, else 0.
SLOPES: dict[str, Callable[..., tuple[Expr, ...]]] = {
    "minimum": lambda a, b: (positive(b - a), 1 - positive(b - a)),
    "maximum": lambda a, b: (positive(a - b), 1 - positive(a - b)),
    "choice": lambda test, over, under: (Integer(0), positive(test), 1 - positive(test)),
    "sine": lambda a: (FUNCTIONS["cosine"](a),),
    "cosine": lambda a: (-FUNCTIONS["sine"](a),),
    "angle": lambda c, s: (-s / (c * c + s * s), c / (c * c + s * s)),
    "whole": lambda number: (Integer(0),),
    "entry": lambda column, cell: (Integer(0), Integer(0)),
    "positive": lambda test: (Integer(0),),
    "abs": lambda a: (sympy.sign(a),),  # SymPy's Abs simplifies its argument, which takes seconds
}


class _Function(sympy.Function):  # type: ignore[misc]
    is_real = True

    def fdiff(self, argindex: int = 1) -> Expr:
        return SLOPES[type(self).__name__](*self.args)[argindex - 1]


FUNCTIONS: dict[str, Expr] = {name: type(name, (_Function,), {}) for name in SLOPES}
positive: Expr = FUNCTIONS["positive"]


@lru_cache(maxsize=4096)
def real(name: str) -> Expr:
    return sympy.Symbol(name, real=True)


def clipped(value: Expr, most: Expr) -> Expr:
    return FUNCTIONS["minimum"](FUNCTIONS["maximum"](value, -most), most)


def least(*values: Expr) -> Expr:
    return reduce(FUNCTIONS["minimum"], values)


def greatest(*values: Expr) -> Expr:
    return reduce(FUNCTIONS["maximum"], values)


@dataclass
class Lines:
    """A straight-line program under construction: assignments in order."""

    program: list[Assignment | None] = field(default_factory=list)  # In order
    _taken: set[str] = field(default_factory=set)

    def put(self, name: str, value: Expr) -> Expr:
        """Write a line and return its symbol; a bare number or symbol needs none."""
        value = sympy.sympify(value)
        if value.is_Number or value.is_Symbol:
            return value
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        self.program.append((real(name), value))
        return real(name)

    def inline(
        self, prefix: str, assignments: Iterable[Assignment], results: Iterable[Expr], values: Mapping[Expr, Expr]
    ) -> list[Expr]:
        """Write the lines of a function here with its arguments replaced, and return its results."""
        where = dict(values)
        for name, value in assignments:
            where[name] = self.put(f"{prefix}{name}", value.xreplace(where))
        return [sympy.sympify(result).xreplace(where) for result in results]

    def cut(self) -> None:
        self.program.append(CUT)

    @property
    def assignments(self) -> list[Assignment]:
        return [line for line in self.program if line is not None]

    def needed_for(self, results: Sequence[Expr]) -> "Lines":
        wanted = {name for result in results for name in names_in(result)}
        kept: list[Assignment | None] = []
        for line in reversed(self.program):
            if line is None:
                kept.append(line)
            elif str(line[0]) in wanted:
                kept.append(line)
                wanted |= names_in(line[1])
        return Lines(kept[::-1], set(self._taken))

    @property
    def inputs(self) -> tuple[str, ...]:
        return asked_by(self.assignments)


@dataclass(frozen=True)
class Program:
    assignments: tuple[Assignment, ...]  # In order
    results: tuple[Expr, ...]  # Its results

    @classmethod
    def of(cls, lines: Lines, results: Sequence[Expr]) -> "Program":
        return cls(tuple(lines.needed_for(results).assignments), tuple(results))

    @cached_property
    def asked(self) -> tuple[str, ...]:
        return asked_by(self.assignments, self.results)


def asked_by(assignments: Iterable[Assignment], results: Iterable[Expr] = ()) -> tuple[str, ...]:
    """Return the names that lines and results use and no line assigns, in alphabetical order."""
    lines = list(assignments)
    used = {name for value in (*(value for _, value in lines), *results) for name in names_in(value)}
    return tuple(sorted(used - {str(name) for name, _ in lines}))


def names_in(value: Expr) -> set[str]:
    return {symbol.name for symbol in symbols_of(sympy.sympify(value))}


# Formulas become straight lines: parts of parameters alone are constants, common subexpressions are written once.
@dataclass
class Constants:
    """Expressions of parameters in the moving part, each under the name of a constant."""

    parameters: set[Expr]  # Symbols that do not change in a voyage
    table: dict[Expr, Expr] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(str(name) for name in self.table.values())

    def lift(self, expression: Expr) -> Expr:
        """Replace every part of an expression that depends on parameters alone by a constant."""
        symbols = symbols_of(expression)
        if not symbols & self.parameters:
            return expression
        if symbols <= self.parameters:
            return self.table.setdefault(expression, real(f"k{len(self.table)}"))
        if not (expression.is_Add or expression.is_Mul):
            return expression.func(*map(self.lift, expression.args))
        fixed = [a for a in expression.args if symbols_of(a) <= self.parameters]
        moving = [self.lift(a) for a in expression.args if a not in fixed]
        return expression.func(self.lift(expression.func(*fixed)), *moving)


def straight_lines(expressions: Sequence[Expr], prefix: str = "t") -> tuple[list[Assignment], list[Expr]]:
    """Extract common subexpressions and name the bases of repeated powers."""
    names = sympy.numbered_symbols(prefix, real=True)
    shared, results = sympy.cse(expressions, symbols=names, order="canonical")
    assignments: list[Assignment] = []

    def name_base(base: Expr, exponent: Expr) -> Expr:
        if base.is_Symbol or base.is_number or not exponent.is_Rational or exponent.p in (1, -1):
            return base**exponent
        name = next(names)
        assignments.append((name, base))
        return name**exponent

    for name, expression in shared:
        value = expression.replace(sympy.Pow, name_base)  # This may append lines, which come first
        assignments.append((name, value))
    return assignments, [result.replace(sympy.Pow, name_base) for result in results]


def rounds(lines: Lines, apart: Callable[[Expr], bool] = lambda value: False) -> list[list[Assignment]]:
    """Split a program into loops over lanes: at its cuts, and so that some lines stand apart from all others."""
    # Each line is in the earliest round that has its inputs: odd rounds hold those apart.
    level: dict[Expr, int] = {}
    scheduled: dict[int, list[Assignment]] = {}
    floor = 0
    for line in lines.program:
        if line is CUT:
            floor = (max(scheduled, default=0) + 2) // 2 * 2
            continue
        name, value = line
        first = max((level.get(s, 0) for s in symbols_of(value)), default=0)
        is_apart = apart(value)
        first = max(first, 0 if is_apart else floor)
        index = first + (first % 2 != is_apart)
        level[name] = index
        scheduled.setdefault(index, []).append(line)
    return [scheduled[index] for index in sorted(scheduled)]


@dataclass(frozen=True)
class LaneLoops:
    """A program as loops over lanes: each stores what a later one reads in a field of the lane."""

    parts: Sequence[Sequence[Assignment]]  # The rounds, one loop each
    results: tuple[Expr, ...]  # Results of the last

    @cached_property
    def read(self) -> list[set[str]]:
        results = [()] * (len(self.parts) - 1) + [self.results]
        return [set(asked_by(part, own)) for part, own in zip(self.parts, results, strict=True)]

    @cached_property
    def stored(self) -> list[list[str]]:
        read = set().union(*self.read)
        return [sorted(str(name) for name, _ in part if str(name) in read) for part in self.parts]


@lru_cache(maxsize=65536)
def symbols_of(value: Expr) -> frozenset[Expr]:
    """Return the symbols of an expression; those of its parts are remembered."""
    return frozenset((value,)) if value.is_Symbol else frozenset().union(*map(symbols_of, value.args))
