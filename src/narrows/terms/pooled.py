"""A table for tests at several depths: hull coefficients of their own at each, linear between them; the bank shared."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from narrows.errors import InputError
from narrows.quantities.arithmetic import maximum, minimum
from narrows.quantities.names import Number
from narrows.terms.term import DEPTH, Term, TermTable

# Between a name and a depth in metres: ``b_v@0.41``, ``paper@0.246,0.41``.
AT = "@"


def pooled(table: TermTable, depths: Sequence[float]) -> TermTable:
    """Return a table whose hull terms have a coefficient for each of some depths."""
    # Between depths a coefficient is linear, beyond them it stays. Terms of the bank are left as they are: shared, or
    # as their own form changes with depth.
    knots = sorted(set(depths))
    if len(knots) < 2 or not knots[0] > 0:
        raise InputError(f"hulls of their own at each depth need two depths or more; there are {len(knots)}")

    def spread(part: tuple[Term, ...]) -> tuple[Term, ...]:
        return tuple(each for term in part for each in ([term] if term.from_bank else _at_each(term, knots)))

    hull = {term.name for term in table.terms if not term.from_bank}
    ties = tuple((_named(a, h), _named(b, h)) for a, b in table.ties if {a, b} <= hull for h in knots)
    name = f"{table.name}{AT}{','.join(f'{h:g}' for h in knots)}"
    surge, sway, yaw = (spread(part) for part in (table.surge, table.sway, table.yaw))
    return replace(table, name=name, ties=ties, surge=surge, sway=sway, yaw=yaw)


def _named(name: str, depth: float) -> str:
    return f"{name}{AT}{depth:g}"


def _at_each(term: Term, knots: list[float]) -> list[Term]:
    return [
        replace(
            term, name=_named(term.name, h), symbol=f"{term.symbol}^{{{h:g}\\,m}}", regressor=_near(term, knots, i),
            depth_law=None,
        )
        for i, h in enumerate(knots)
    ]  # fmt: skip


def _near(term: Term, knots: list[float], i: int) -> Callable[..., Number]:
    """The regressor times how near the depth is to one of the knots: 1 at it, 0 at its neighbours."""
    asks = tuple(dict.fromkeys((*term.inputs, DEPTH)))
    depth_at, count = asks.index(DEPTH), len(term.inputs)

    def regressor(*values: Number) -> Number:
        return term.regressor(*values[:count]) * _share(values[depth_at], knots, i)

    regressor.inputs = asks  # type: ignore[attr-defined]
    return regressor


def _share(depth: Number, knots: list[float], i: int) -> Number:
    rising = (depth - knots[i - 1]) / (knots[i] - knots[i - 1]) if i else 1.0
    falling = (knots[i + 1] - depth) / (knots[i + 1] - knots[i]) if i + 1 < len(knots) else 1.0
    return maximum(minimum(minimum(rising, falling), 1.0), 0.0)
