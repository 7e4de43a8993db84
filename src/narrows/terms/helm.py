"""The terms of a rudder on a hull that was tested with it amidships, for any table without one."""

from collections.abc import Callable

from narrows.errors import InputError
from narrows.physics import rudder
from narrows.quantities import dimensions as dim
from narrows.quantities.names import Number
from narrows.terms.term import NONNEGATIVE, Term, TermKind, TermTable

# What the name of a table says where it has the terms of a rudder.
WITH_HELM = "helm"
SOURCE = "form of Yasukawa and Yoshimura (2015)"


def _row(letter: str, regressor: Callable[..., Number]) -> tuple[Term, ...]:
    name, symbol = f"{letter}_{WITH_HELM}", f"{letter}_{{{WITH_HELM}}}"
    return (Term(name, symbol, regressor, dim.NUMBER, NONNEGATIVE, TermKind.RUDDER, SOURCE),)


def helm_terms(table: TermTable) -> dict[str, tuple[Term, ...]]:
    """Return the terms of a rudder as a table would call them: those of surge, sway and yaw."""
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
        Of the new table; ``table+helm`` unless given.

    Raises
    ------
    InputError
        Where the table has a rudder.
    """
    if any(term.kind == TermKind.RUDDER for term in table.terms):
        raise InputError(f"the terms {table.name!r} have a rudder; leave +{WITH_HELM} out")
    return table.with_terms(name or f"{table.name}+{WITH_HELM}", **helm_terms(table))
