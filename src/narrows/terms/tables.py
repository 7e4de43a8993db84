"""The tables of terms that come with the package, by name: a base, a form of its bank term, a rudder."""

from functools import cache

from narrows.errors import InputError, did_you_mean
from narrows.terms.bank_forms import FORMS, OPEN_WATER, with_bank, without_bank
from narrows.terms.canal_tables import CROSSFLOW, MIXED, PAPER, SPEED
from narrows.terms.helm import WITH_HELM, with_helm
from narrows.terms.mmg import MMG
from narrows.terms.pooled import AT, pooled
from narrows.terms.term import TermTable

__all__ = ["BARE", "BASES", "CROSSFLOW", "MIXED", "MMG", "PAPER", "SPEED", "STEERED", "TAPERED", "table_named"]

# The terms of ``crossflow`` and a rudder.
STEERED = with_helm(CROSSFLOW, "steered")
# The tables of a hull without a rudder, with the paper's bank term.
BARE = {table.name: table for table in (PAPER, SPEED, MIXED, CROSSFLOW)}
# The tables by name; ``speed+keel_gap`` is the table ``speed`` with another form of the bank term.
BASES = {**BARE, "steered": STEERED, "mmg": MMG}
# Other names for some of them.
SHORT = {"tapered": "paper+tapered"}


@cache
def table_named(name: str) -> TermTable:
    """Return a table of terms that comes with the package."""
    if AT in name:
        base, _, depths = name.partition(AT)
        return pooled(table_named(base), _depths(depths, name))
    first, plus, rest = name.partition("+")
    base, *additions = (SHORT.get(first, first) + plus + rest).split("+")
    if base not in BASES:
        raise InputError(f"unknown table of terms {base!r}{did_you_mean(base, [*BASES, *SHORT])}")
    if unknown := [word for word in additions if word not in (*FORMS, OPEN_WATER, WITH_HELM)]:
        hint = did_you_mean(unknown[0], [*FORMS, OPEN_WATER, WITH_HELM])
        raise InputError(f"unknown form {unknown[0]!r} of the bank term{hint}")
    if sum(word != WITH_HELM for word in additions) > 1:
        raise InputError(f"the terms {name!r} have two forms of the bank; keep one")
    table = BASES[base]
    for addition in additions:
        table = _with(table, addition)
    return table


def _depths(written: str, name: str) -> list[float]:
    try:
        return [float(part) for part in written.split(",")]
    except ValueError:
        raise InputError(f"the terms {name!r} give no depths in metres behind {AT}; write paper{AT}0.25,0.41") from None


def _with(table: TermTable, addition: str) -> TermTable:
    if addition == WITH_HELM:
        return with_helm(table)
    return without_bank(table) if addition == OPEN_WATER else with_bank(table, addition)


# The paper's terms with its boundary-layer taper on the bank.
TAPERED = table_named("paper+tapered")
