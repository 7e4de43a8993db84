"""From formulas to straight lines: what parameters alone decide lifted out, common subexpressions written once."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from narrows.codegen.free_motion import Expr, symbol
from narrows.codegen.lines import CUT, Assignment, Lines


@dataclass
class Constants:
    """The expressions of parameters that the moving part uses, each under the name of a constant."""

    parameters: set[Expr]  # What does not change in a voyage
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


def straight_lines(expressions: Sequence[Expr], prefix: str = "t") -> tuple[list[Assignment], list[Expr]]:
    """Take out common subexpressions and name what a power repeats."""
    import sympy

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
        value = expression.replace(sympy.Pow, name_base)
        assignments.append((name, value))
    return assignments, [result.replace(sympy.Pow, name_base) for result in results]


def reads_table(value: Expr) -> bool:
    """Whether a line reads the table of a waterway."""
    return str(value.func) == "entry"


def rounds(lines: Lines, apart: Callable[[Expr], bool] = reads_table) -> list[list[Assignment]]:
    """Part a program into loops over lanes: at its cuts, and where the table of a waterway is read."""
    # A loop that reads a table at an index of its own and writes the block does not vectorise: nothing tells LLVM that
    # the two do not overlap. So reads get loops of their own, that only fetch, and the arithmetic between them
    # vectorises.
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
    """Even rounds of arithmetic, odd ones of what stands apart; each line in the earliest that has what it needs."""
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
