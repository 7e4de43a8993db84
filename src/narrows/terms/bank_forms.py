"""Forms of the bank term: each a pressure parameter or two, with where it is from, where it holds, and its standing."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from narrows.errors import InputError, did_you_mean
from narrows.physics import clearance
from narrows.physics.bank import cushion, suction
from narrows.quantities import dimensions as dim
from narrows.quantities.names import Number
from narrows.terms.regressors import Composed
from narrows.terms.term import Term, TermTable

WITH_HELM = "helm"
"""What the name of a table says where it has the terms of a rudder."""
PUBLISHED, REFITTED, OURS = "published", "form of another, coefficients refitted", "ours"


@dataclass(frozen=True)
class BankForm:
    """A form of the bank term.

    Parameters
    ----------
    name : str
        As in ``paper+keel_gap``.
    parameters : mapping of str to callable
        What makes the pressure differ, by the coefficients' ending: ``bank`` for b_bank and c_bank.
    source : str
        Where it is from.
    validity : str
        Where it means something.
    status : str
        ``published``, ``form of another, coefficients refitted`` or ``ours``.
    """

    name: str
    parameters: Mapping[str, Callable[..., Number]]
    source: str
    validity: str
    status: str

    @property
    def sway(self) -> tuple[Term, ...]:
        """The terms of the sway force."""
        return tuple(
            Term(f"b_{ending}", _symbol("b", ending), Composed(suction, parameter), dim.NUMBER)
            for ending, parameter in self.parameters.items()
        )

    @property
    def yaw(self) -> tuple[Term, ...]:
        """The terms of the yaw moment."""
        return tuple(
            Term(f"c_{ending}", _symbol("c", ending), Composed(cushion, parameter), dim.NUMBER)
            for ending, parameter in self.parameters.items()
        )


def _symbol(letter: str, ending: str) -> str:
    return rf"{letter}_{{{ending.replace('_', ',')}}}"


PAPER_TEXT = "Mikkelsen et al. (2025)"
FORMS = {
    form.name: form
    for form in (
        BankForm("delta", {"bank": clearance.delta}, PAPER_TEXT, "clear of the banks; knows no depth", PUBLISHED),
        BankForm(
            "tapered",
            {"bank": clearance.tapered_delta},
            f"{PAPER_TEXT}, red curve of fig. (Delta_fun)",
            "also within the boundary layer of a wall; knows no depth",
            PUBLISHED,
        ),
        BankForm(
            "distance",
            {"bank": clearance.bank_distance},
            "y_B of Ch'ng (1993) and Vantorre et al. (2003)",
            "far from the banks; knows no depth",
            REFITTED,
        ),
        BankForm(
            "distance_depth",
            {"bank": clearance.bank_distance, "bank_depth": clearance.shallow_bank_distance},
            "y_B and y_B T/(h - T) of Vantorre et al. (2003)",
            "far from the banks, h > T; two coefficients a force, so that the sign can change with depth",
            REFITTED,
        ),
        BankForm(
            "tuck",
            {"bank": clearance.critical_bank_distance},
            "y_B with Tuck's number, after Lataire (2014)",
            "far from the banks, well below the critical speed (F < 0.7)",
            REFITTED,
        ),
        BankForm(
            "keel_gap",
            {"bank": clearance.keel_gap_delta},
            "delta with B T/h in place of B",
            "h >= T; the paper's delta at T = h; no change of sign",
            OURS,
        ),
        BankForm(
            "delta_depth",
            {"bank": clearance.delta, "bank_depth": clearance.shallow_delta},
            "delta and delta T/(h - T)",
            "h > T; two coefficients a force, so that the sign can change with depth",
            OURS,
        ),
    )
}
"""The forms by name."""


def with_bank(table: TermTable, form: str | BankForm, name: str = "") -> TermTable:
    """Return a table with another form of its bank term (ours).

    Parameters
    ----------
    table : TermTable
        The table; its own bank terms go.
    form : str or BankForm
        One of ``FORMS``, or your own.
    name : str
        Of the new table; ``table+form`` unless given.

    Raises
    ------
    InputError
        Where there is no such form.
    """
    form = _form(form)
    sway, yaw = (tuple(term for term in own if not term.from_bank) for own in (table.sway, table.yaw))
    base, *additions = table.name.split("+")
    own = "+".join([base, *(word for word in additions if word == WITH_HELM)])
    kept = TermTable(name or f"{own}+{form.name}", table.surge, sway, yaw, table.ties)
    return kept.with_terms(kept.name, sway=form.sway, yaw=form.yaw)


def _form(form: str | BankForm) -> BankForm:
    if isinstance(form, str) and form not in FORMS:
        raise InputError(f"unknown form {form!r} of the bank term{did_you_mean(form, FORMS)}")
    return FORMS[form] if isinstance(form, str) else form


def bank_only(form: str | BankForm) -> TermTable:
    """Return a table of a bank form alone, for steady tests along a bank without drift or yaw (ours).

    Parameters
    ----------
    form : str or BankForm
        One of ``FORMS``, or your own.

    Raises
    ------
    InputError
        Where there is no such form.
    """
    own = _form(form)
    return TermTable(f"bank only: {own.name}", (), own.sway, own.yaw)
