"""Two operations of SymPy on real expressions, without the searches that took half the time of writing a kernel."""

from functools import lru_cache
from typing import Any

import sympy

Expr = Any


@lru_cache(maxsize=65536)
def symbols_of(value: Expr) -> frozenset[Expr]:
    """Return the symbols of an expression; those of its parts are remembered."""
    return frozenset((value,)) if value.is_Symbol else frozenset().union(*map(symbols_of, value.args))


# Printers find their methods by the name of the class.
class Abs(sympy.Abs):  # type: ignore[misc]
    """The absolute value, whose numbers and factors of known sign are taken out; nothing else is simplified."""

    @classmethod
    def eval(cls, value: Expr) -> Expr | None:
        if value.is_Number:
            return sympy.Abs(value)
        if _is_nonnegative(value):
            return value
        if value.is_Mul:
            plain = [sympy.Abs(factor) if factor.is_Number else factor for factor in value.args]
            known = [factor for factor in plain if factor.is_Number or _is_nonnegative(factor)]
            if known:
                return sympy.Mul(*known, cls(sympy.Mul(*(factor for factor in plain if factor not in known))))
        return cls(-value) if value.could_extract_minus_sign() else None

    def _eval_power(self, exponent: Expr) -> Expr | None:
        return self.args[0] ** exponent if exponent.is_Integer and exponent.is_even else None


def _is_nonnegative(value: Expr) -> bool:
    if value.is_Pow:
        base, power = value.args
        return bool((power.is_Rational and (power.p % 2 == 0 or power.q % 2 == 0)) or _is_nonnegative(base))
    return bool(isinstance(value, sympy.Abs) or (value.is_Symbol and value.is_nonnegative))
