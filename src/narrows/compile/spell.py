"""Spell a SymPy expression as Python arithmetic, for floats and columns or for a compiled block."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from narrows.compile.trace import Expr

LONGEST_PRODUCT = 4
DIGITS = 20


@dataclass(frozen=True)
class Style:
    """How numbers and functions are written.

    Parameters
    ----------
    number, power, exponential, root : callable
        Of the texts of a number; of a base and an exponent; of an exponent of e; of what is under a square root.
    """

    number: Callable[[str], str]
    power: Callable[[str, str], str]
    exponential: Callable[[str], str]
    root: Callable[[str], str]


PLAIN = Style("{}".format, "{} ** {}".format, "E ** {}".format, "{} ** 0.5".format)
"""Arithmetic and ``abs()`` alone: floats and NumPy columns."""

BLOCK = Style("real({})".format, "{} ** {}".format, "exp{}".format, "sqrt{}".format)
"""Numbers have the width of the lanes, so that single precision stays single; functions are ones that vectorise."""


def spell(expression: Expr, style: Style) -> str:
    """Write an expression as text (ours).

    Parameters
    ----------
    expression : expression
        Of symbols, numbers, sums, products, powers, exponentials, absolute values, signs and ``larger``.
    style : Style
        How to write numbers and functions.
    """
    if expression.is_Symbol:
        return str(expression.name)
    if expression.is_number:
        return _number(expression, style)
    if expression.is_Add:
        return _sum(expression.args, style)
    if expression.is_Mul:
        return _product(expression, style)
    if expression.is_Pow:
        return _power(expression.base, expression.exp, style)
    return _function(expression, style)


def _number(value: Expr, style: Style) -> str:
    text = style.number(repr(abs(float(value.evalf(DIGITS)))))
    return f"-{text}" if value < 0 else text


def _sum(addends: Iterable[Expr], style: Style) -> str:
    words = sorted((spell(addend, style) for addend in addends), key=lambda word: word.startswith("-"))
    return "".join([words[0], *(f" - {w[1:]}" if w.startswith("-") else f" + {w}" for w in words[1:])])


def _product(expression: Expr, style: Style) -> str:
    import sympy

    number, factors = expression.as_coeff_mul()
    below = [f for f in factors if f.is_Pow and f.exp.is_Number and f.exp < 0]
    above = [f for f in factors if f not in below]
    words = [_factor(f, style) for f in above]
    if abs(number) != 1 or not words:
        words.insert(0, _number(abs(number), style))
    text = " * ".join(words)
    if below:
        divisor = " * ".join(_factor(sympy.Pow(f.base, -f.exp), style) for f in below)
        text += f" / ({divisor})" if " " in divisor else f" / {divisor}"
    return f"-{text}" if number < 0 else text


def _factor(expression: Expr, style: Style) -> str:
    """An expression that stands in a product."""
    text = spell(expression, style)
    return f"({text})" if expression.is_Add or text.startswith("-") else text


def _power(base: Expr, exponent: Expr, style: Style) -> str:
    import sympy

    if exponent.is_Number and exponent < 0:
        return f"{style.number('1.0')} / {_atom(sympy.Pow(base, -exponent), style)}"
    if exponent.is_Integer and exponent <= LONGEST_PRODUCT:
        return " * ".join([_atom(base, style)] * int(exponent))
    if exponent.is_Rational and exponent.q == 2:
        whole = [_power(base, exponent - sympy.Rational(1, 2), style)] if exponent.p > 1 else []
        return " * ".join([*whole, style.root(_bracketed(base, style))])
    if base.is_number and not exponent.is_number and style is BLOCK:
        return style.exponential(_bracketed(exponent * sympy.log(base).evalf(DIGITS), style))
    upper = str(exponent) if exponent.is_Integer else _atom(exponent, style)
    return style.power(_atom(base, style), upper)


def _atom(expression: Expr, style: Style) -> str:
    """An expression that binds more tightly than any operation."""
    whole = expression.is_Symbol or (expression.is_Number and expression >= 0)
    return spell(expression, style) if whole else _bracketed(expression, style)


def _bracketed(expression: Expr, style: Style) -> str:
    return f"({spell(expression, style)})"


def _function(expression: Expr, style: Style) -> str:
    import sympy

    name, inside = type(expression), expression.args[0]
    if name is sympy.exp:
        return style.exponential(_bracketed(inside, style))
    if name is sympy.Abs:
        return f"abs{_bracketed(inside, style)}"
    if name is sympy.sign:
        word, zero, one = _atom(inside, style), style.number("0.0"), style.number("1.0")
        return f"({one} * ({word} > {zero}) - {one} * ({word} < {zero}))"
    return f"{name}({', '.join(spell(argument, style) for argument in expression.args)})"


def lines(assignments: Iterable[tuple[Any, Expr]], style: Style) -> list[str]:
    """Write assignments, one a line (ours).

    Parameters
    ----------
    assignments : iterable of (symbol, expression)
        In order.
    style : Style
        How to write numbers and functions.
    """
    return [f"{name} = {spell(expression, style)}" for name, expression in assignments]
