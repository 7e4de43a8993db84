"""Exact derivatives line by line: the chain rule carried along a program (forward accumulation).

Each line depends on few earlier ones, so that its slopes are short; whole formulas, differentiated, are not.
"""

from collections.abc import Callable, Mapping, Sequence

import sympy

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import FUNCTIONS, Lines

positive = FUNCTIONS["positive"]
# The slopes of what is not arithmetic, by each argument.
SLOPES: dict[str, Callable[..., tuple[Expr, ...]]] = {
    "minimum": lambda a, b: (positive(b - a), 1 - positive(b - a)),
    "maximum": lambda a, b: (positive(a - b), 1 - positive(a - b)),
    "choice": lambda test, over, under: (sympy.Integer(0), positive(test), 1 - positive(test)),
    "sine": lambda a: (FUNCTIONS["cosine"](a),),
    "cosine": lambda a: (-FUNCTIONS["sine"](a),),
    "angle": lambda c, s: (-s / (c * c + s * s), c / (c * c + s * s)),
    "whole": lambda number: (sympy.Integer(0),),
    "entry": lambda column, cell: (sympy.Integer(0), sympy.Integer(0)),
    "positive": lambda test: (sympy.Integer(0),),
}


def with_tangents(
    lines: Lines, inputs: Mapping[Expr, Sequence[Expr]], directions: int
) -> tuple[Lines, Callable[[Expr], list[Expr]]]:
    """Return a program with the slopes of its lines along some directions."""
    out = Lines(_taken={str(name) for name, _ in lines.assignments})
    slopes = {name: [sympy.sympify(slope) for slope in along] for name, along in inputs.items()}

    def through(value: Expr, name: str) -> list[Expr]:
        moving = [s for s in sorted(value.free_symbols, key=str) if s in slopes]
        partial = {s: out.put(f"{name}_by_{s}", slope(value, s)) for s in moving}
        totals = [sum((d * slopes[s][k] for s, d in partial.items()), sympy.Integer(0)) for k in range(directions)]
        return [out.put(f"{name}_d{k}", total) for k, total in enumerate(totals)]

    for line in lines.program:
        out.program.append(line)
        if line is not None:
            name, value = line
            if any(s in slopes for s in value.free_symbols):
                slopes[name] = through(value, str(name))

    def of(value: Expr) -> list[Expr]:
        value = sympy.sympify(value)
        if value.is_Symbol:
            return slopes.get(value, [sympy.Integer(0)] * directions)
        return through(value, "out")

    return out, of


def slope(value: Expr, by: Expr) -> Expr:
    """Differentiate an expression of a line."""
    if value == by:
        return sympy.Integer(1)
    if by not in value.free_symbols:
        return sympy.Integer(0)
    parts = [slope(argument, by) for argument in value.args]
    if value.is_Add:
        return sympy.Add(*parts)
    if value.is_Mul:
        return _product_slope(value.args, parts)
    if value.is_Pow:
        return _power_slope(*value.args, *parts)
    if isinstance(value, sympy.Abs):
        return (positive(value.args[0]) - positive(-value.args[0])) * parts[0]  # the sign
    if isinstance(value, sympy.exp):
        return value * parts[0]
    name = str(value.func)
    if name not in SLOPES:
        raise TypeError(f"no slope of {name}")
    return sympy.Add(*(outer * part for outer, part in zip(SLOPES[name](*value.args), parts, strict=True)))


def _product_slope(factors: Sequence[Expr], parts: Sequence[Expr]) -> Expr:
    terms = (sympy.Mul(*factors[:i], part, *factors[i + 1 :]) for i, part in enumerate(parts) if part != 0)
    return sympy.Add(*terms)


def _power_slope(base: Expr, power: Expr, base_slope: Expr, power_slope: Expr) -> Expr:
    by_base = power * base ** (power - 1) * base_slope if base_slope != 0 else sympy.Integer(0)
    return by_base + base**power * sympy.log(base) * power_slope if power_slope != 0 else by_base
