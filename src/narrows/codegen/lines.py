"""Straight-line programs: one assignment a line, every name assigned once. All printers print these.

One ``Lines`` holds a whole step (control law, gear, Runge-Kutta, contact); a cut marks where a loop over lanes may be
split.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import sympy

from narrows.codegen.free_motion import Expr, symbol

Assignment = tuple[Expr, Expr]

# A place in the program where a loop may be split.
CUT = None

FUNCTION_NAMES = ("minimum", "maximum", "choice", "angle", "sine", "cosine", "whole", "entry", "positive")

# Functions that printers know. ``whole`` truncates to an integer, ``entry(column, cell)`` reads the table of a
# waterway, ``positive`` is 1 for numbers above 0, else 0.
FUNCTIONS: dict[str, Expr] = {name: sympy.Function(name, real=True) for name in FUNCTION_NAMES}


@lru_cache(maxsize=4096)
def real(name: str) -> Expr:
    return sympy.Symbol(name, real=True)


def clipped(value: Expr, most: Expr) -> Expr:
    """Clip an expression to between ``-most`` and ``most``."""
    return FUNCTIONS["minimum"](FUNCTIONS["maximum"](value, -most), most)


def least(*values: Expr) -> Expr:
    smallest, *rest = values
    for value in rest:
        smallest = FUNCTIONS["minimum"](smallest, value)
    return smallest


def greatest(*values: Expr) -> Expr:
    largest, *rest = values
    for value in rest:
        largest = FUNCTIONS["maximum"](largest, value)
    return largest


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
        """Mark a place where a loop may be split."""
        self.program.append(CUT)

    @property
    def assignments(self) -> list[Assignment]:
        """Return the lines without the cuts."""
        return [line for line in self.program if line is not None]

    def needed_for(self, results: Sequence[Expr]) -> "Lines":
        wanted = {str(s) for result in results for s in sympy.sympify(result).free_symbols}
        kept: list[Assignment | None] = []
        for line in reversed(self.program):
            if line is None:
                kept.append(line)
            elif str(line[0]) in wanted:
                kept.append(line)
                wanted |= {str(s) for s in line[1].free_symbols}
        return Lines(kept[::-1], set(self._taken))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names used before they are assigned, in alphabetical order."""
        made: set[str] = set()
        asked: set[str] = set()
        for name, value in self.assignments:
            asked |= {str(s) for s in value.free_symbols} - made
            made.add(str(name))
        return tuple(sorted(asked))


@dataclass(frozen=True)
class Program:
    assignments: tuple[Assignment, ...]  # In order
    results: tuple[Expr, ...]  # Its results

    @classmethod
    def of(cls, lines: Lines, results: Sequence[Expr]) -> "Program":
        return cls(tuple(lines.needed_for(results).assignments), tuple(results))

    @cached_property
    def asked(self) -> tuple[str, ...]:
        """Names that it uses and does not assign, in alphabetical order."""
        made = {str(name) for name, _ in self.assignments}
        values = [*(value for _, value in self.assignments), *self.results]
        used = {str(s) for value in values for s in sympy.sympify(value).free_symbols}
        return tuple(sorted(used - made))


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
    if any(apart(value) for _, value in lines.assignments):
        return _scheduled(lines, apart)
    parts: list[list[Assignment]] = [[]]
    for line in lines.program:
        if line is CUT:
            parts.append([])
        else:
            parts[-1].append(line)
    return [part for part in parts if part]


def _scheduled(lines: Lines, apart: Callable[[Expr], bool]) -> list[list[Assignment]]:
    """Put each line into the earliest round that has its inputs: odd rounds hold those apart."""
    level: dict[Expr, int] = {}
    scheduled: dict[int, list[Assignment]] = {}
    floor = 0
    for line in lines.program:
        if line is CUT:
            floor = (max(scheduled, default=0) + 2) // 2 * 2
            continue
        name, value = line
        first = max((level.get(s, 0) for s in value.free_symbols), default=0)
        if apart(value):
            index = first + (first % 2 == 0)
        else:
            first = max(first, floor)
            index = first + first % 2
        level[name] = index
        scheduled.setdefault(index, []).append(line)
    return [scheduled[index] for index in sorted(scheduled)]
