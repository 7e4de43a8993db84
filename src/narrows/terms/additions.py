"""Tables derived from others: with a rudder, asymmetry, transverse thrust, with hull coefficients for each depth."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from narrows.errors import InputError
from narrows.physics import propeller, rudder
from narrows.physics.hull import HullPower
from narrows.quantities import dimensions as dim
from narrows.quantities.arithmetic import maximum, minimum
from narrows.quantities.dimensions import NUMBER
from narrows.quantities.names import Number
from narrows.terms.term import DEPTH, NONNEGATIVE, Term, TermKind, TermTable

# Suffix of the name of a table with the terms of a rudder.
WITH_HELM = "helm"
HELM_SOURCE = "form of Yasukawa and Yoshimura (2015)"


def _row(letter: str, regressor: Callable[..., Number]) -> tuple[Term, ...]:
    name, symbol = f"{letter}_{WITH_HELM}", f"{letter}_{{{WITH_HELM}}}"
    return (Term(name, symbol, regressor, dim.NUMBER, NONNEGATIVE, TermKind.RUDDER, HELM_SOURCE),)


def helm_terms(table: TermTable) -> dict[str, tuple[Term, ...]]:
    """Return the terms of a rudder with a table's names: those of surge, sway and yaw."""
    surge, sway, yaw = table.letters
    return {
        "surge": _row(surge, rudder.helm_surge),
        "sway": _row(sway, rudder.helm_sway),
        "yaw": _row(yaw, rudder.helm_yaw),
    }


def with_helm(table: TermTable, name: str = "") -> TermTable:
    """Return a table with the terms of a rudder.

    Parameters
    ----------
    table : TermTable
        The table.
    name : str
        Name of the new table; ``table+helm`` unless given.

    Raises
    ------
    InputError
        If the table has a rudder.

    Examples
    --------
    >>> nw.with_helm(nw.PAPER).actuators[0].name
    'rudder'
    """
    if any(term.kind == TermKind.RUDDER for term in table.terms):
        raise InputError(f"the terms {table.name!r} have a rudder; leave +{WITH_HELM} out")
    return table.with_terms(name or f"{table.name}+{WITH_HELM}", **helm_terms(table))


# Suffix of the name of a table with these terms.
WITH_ASYMMETRY = "asymmetry"
ASYMMETRY_SOURCE = "Y_0' and N_0' of polynomial manoeuvring models, as in Abkowitz (1964)"


def asymmetry_names(table: TermTable) -> tuple[str, str]:
    """Return a table's names for the constant sway force and yaw moment."""
    _, sway, yaw = table.letters
    return f"{sway}_0", f"{yaw}_0"


def with_asymmetry(table: TermTable) -> TermTable:
    """Return a table with a constant sway force and yaw moment, proportional to the speed squared."""
    sway, yaw = asymmetry_names(table)
    if sway in table.names:
        raise InputError(f"the terms {table.name!r} have an asymmetry; leave +{WITH_ASYMMETRY} out")
    return table.with_terms(
        f"{table.name}+{WITH_ASYMMETRY}",
        sway=[Term(sway, f"{sway}'", HullPower(0, 0), NUMBER, kind=TermKind.HULL, source=ASYMMETRY_SOURCE)],
        yaw=[Term(yaw, f"{yaw}'", HullPower(0, 0, lever=1), NUMBER, kind=TermKind.HULL, source=ASYMMETRY_SOURCE)],
    )


# Suffix of the name of a table with these terms.
WITH_TRANSVERSE_THRUST = "transverse_thrust"
TRANSVERSE_SOURCE = "MMG model of the Esso Osaka astern, Osaka University"


def transverse_names(table: TermTable) -> tuple[str, str]:
    """Return a table's names for the sway force and yaw moment of a propeller that turns astern."""
    _, sway, yaw = table.letters
    return f"{sway}_astern", f"{yaw}_astern"


def with_transverse_thrust(table: TermTable) -> TermTable:
    """Return a table with the transverse thrust of a propeller that turns astern, relative to the Esso Osaka's."""
    sway, yaw = transverse_names(table)
    if sway in table.names:
        raise InputError(f"the terms {table.name!r} have a transverse thrust; leave +{WITH_TRANSVERSE_THRUST} out")

    def part(name: str, force: Callable[..., Number]) -> list[Term]:
        symbol = name.replace("astern", "{astern}")
        return [Term(name, symbol, force, NUMBER, kind=TermKind.PROPELLER, source=TRANSVERSE_SOURCE)]

    return table.with_terms(
        f"{table.name}+{WITH_TRANSVERSE_THRUST}",
        sway=part(sway, propeller.transverse_thrust),
        yaw=part(yaw, propeller.transverse_thrust_yaw),
    )


# Additions to a table besides a form of the bank.
ADDED: dict[str, Callable[[TermTable], TermTable]] = {
    WITH_HELM: with_helm, WITH_ASYMMETRY: with_asymmetry, WITH_TRANSVERSE_THRUST: with_transverse_thrust,
}  # fmt: skip

# Separator between a name and a depth in metres: ``b_v@0.41``, ``paper@0.246,0.41``.
AT = "@"


def pooled(table: TermTable, depths: Sequence[float]) -> TermTable:
    """Return a table with one coefficient per depth for each hull term."""
    # Between depths a coefficient is linear, beyond them constant. Terms of the bank are unchanged: shared, or with
    # their own dependence on depth.
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
    """The regressor times a hat function of depth: 1 at its knot, 0 at the neighbours."""
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
