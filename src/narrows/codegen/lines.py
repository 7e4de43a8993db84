"""Straight lines of arithmetic: one assignment each, every name assigned once. What every printer prints.

The whole of a step (control law, gear, Runge-Kutta, contact) is written into one ``Lines``; a cut says where a loop
over lanes may be parted.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import sympy

from narrows.codegen.free_motion import Expr

Assignment = tuple[Expr, Expr]
# A place in the program where a loop may be parted.
CUT = None
FUNCTION_NAMES = ("minimum", "maximum", "choice", "angle", "sine", "cosine", "whole", "entry", "positive")
# Functions that printers know. ``whole`` cuts a number down to an integer, ``entry(column, cell)`` reads the table of
# a waterway, ``positive`` is 1 over 0 and else 0.
FUNCTIONS: dict[str, Expr] = {name: sympy.Function(name, real=True) for name in FUNCTION_NAMES}


@lru_cache(maxsize=4096)
def real(name: str) -> Expr:
    """Return the symbol of a number of the program."""
    return sympy.Symbol(name, real=True)


def clipped(value: Expr, most: Expr) -> Expr:
    """Bring an expression to between ``-most`` and ``most``."""
    return FUNCTIONS["minimum"](FUNCTIONS["maximum"](value, -most), most)


def least(*values: Expr) -> Expr:
    """Return the least of some expressions."""
    smallest, *rest = values
    for value in rest:
        smallest = FUNCTIONS["minimum"](smallest, value)
    return smallest


def greatest(*values: Expr) -> Expr:
    """Return the greatest of some expressions."""
    largest, *rest = values
    for value in rest:
        largest = FUNCTIONS["maximum"](largest, value)
    return largest


@dataclass
class Lines:
    """A program of assignments that is being written."""

    program: list[Assignment | None] = field(default_factory=list)  # In order
    _taken: set[str] = field(default_factory=set)

    def put(self, name: str, value: Expr) -> Expr:
        """Write a line and return its symbol; a number or a symbol alone needs none."""
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
        """Write the lines of a function here, its arguments replaced, and return its results."""
        # assignments (symbol, expression)
        where = dict(values)
        for name, value in assignments:
            where[name] = self.put(f"{prefix}{name}", value.xreplace(where))
        return [sympy.sympify(result).xreplace(where) for result in results]

    def cut(self) -> None:
        """Mark a place where a loop may be parted."""
        self.program.append(CUT)

    @property
    def assignments(self) -> list[Assignment]:
        """The lines without the cuts."""
        return [line for line in self.program if line is not None]

    def needed_for(self, results: Sequence[Expr]) -> "Lines":
        """Return the program without the lines that nothing asks for."""
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
        """The names that are used before they are assigned, in alphabetical order."""
        made: set[str] = set()
        asked: set[str] = set()
        for name, value in self.assignments:
            asked |= {str(s) for s in value.free_symbols} - made
            made.add(str(name))
        return tuple(sorted(asked))


@dataclass(frozen=True)
class Program:
    """Lines, and what becomes of them."""

    assignments: tuple[Assignment, ...]  # In order
    results: tuple[Expr, ...]  # What it gives

    @classmethod
    def of(cls, lines: Lines, results: Sequence[Expr]) -> "Program":
        """Return the lines that some results need."""
        return cls(tuple(lines.needed_for(results).assignments), tuple(results))

    @cached_property
    def asked(self) -> tuple[str, ...]:
        """The names that it uses and does not make, in alphabetical order."""
        made = {str(name) for name, _ in self.assignments}
        values = [*(value for _, value in self.assignments), *self.results]
        used = {str(s) for value in values for s in sympy.sympify(value).free_symbols}
        return tuple(sorted(used - made))
