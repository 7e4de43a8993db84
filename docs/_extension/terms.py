"""Tables of terms, forms of the bank term and squat formulas, as the package has them."""

from collections.abc import Iterator

from _extension.markdown import code, table
from narrows import FORMS, SQUAT, BankForm, Term, TermTable
from narrows.model.tables import BASES
from narrows.quantities.names import name_of

HEADER = ("coefficient", "symbol", "regressor", "inputs", "unit", "bound", "kind")


def tables() -> str:
    """Every table of terms that has a name of its own, force by force."""
    return "\n\n".join(part for own in BASES.values() for part in _table(own))


def _table(own: TermTable) -> Iterator[str]:
    yield f"## {own.name}"
    if own.ties:
        yield "Held equal: " + "; ".join(code(pair) for pair in own.ties) + "."
    for force, terms in own.forces.items():
        yield f"**{force}**\n\n{table(HEADER, map(_row, terms))}"
    for source in dict.fromkeys(term.source for term in own.terms if term.source):
        yield f"From {source}: {code(term.name for term in own.terms if term.source == source)}."


def _row(term: Term) -> tuple[str, ...]:
    return (
        f"`{term.name}`", f"${term.symbol}$", f"`{name_of(term.regressor)}`", code(term.inputs),
        term.dimension.unit or "1", _bound(term.bound), str(term.kind),
    )  # fmt: skip


def _bound(bound: tuple[float, float]) -> str:
    return "free" if bound == (float("-inf"), float("inf")) else f"{bound[0]:g} to {bound[1]:g}".replace("inf", "∞")


def bank_forms() -> str:
    """The forms of the bank term."""
    return table(
        ("form", "coefficients end in", "inputs", "source", "valid range", "status"),
        (
            (f"`{form.name}`", code(form.parameters), code(_asked(form)), form.source, form.validity, form.status)
            for form in FORMS.values()
        ),
    )  # fmt: skip


def _asked(form: BankForm) -> tuple[str, ...]:
    return tuple(dict.fromkeys(word for term in form.sway for word in term.inputs))


def squat_formulas() -> str:
    """The formulas for squat."""
    return table(
        ("formula", "gives", "source", "standing", "limits"),
        (
            (f"`{name}`", own.gives, own.source, own.status,
             "; ".join(f"{what.replace('_', ' ')} {low:g} to {high:g}" for what, (low, high) in own.limits.items()))
            for name, own in SQUAT.items()
        ),
    )  # fmt: skip
