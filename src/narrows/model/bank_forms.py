"""Forms of the bank term, each with its source, range of validity and status, and composed regressors."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

from narrows.base.errors import InputError, did_you_mean
from narrows.base.results import BaseSummary
from narrows.model.additions import ADDED
from narrows.model.term import LETTERS, ScaleEffect, Term, TermKind, TermTable, without
from narrows.physics import clearance
from narrows.physics.clearance import cushion, suction
from narrows.quantities import dimensions as dim
from narrows.quantities.names import Number, argument_names, name_of


@dataclass(frozen=True)
class Composed:
    """A law whose first argument is the result of another function."""

    law: Callable[..., Number]  # Function of that result, then of names of the vocabulary
    parameter: Callable[..., Number]  # Function of names of the vocabulary

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*argument_names(self.parameter), *argument_names(self.law)[1:])))

    @property
    def name(self) -> str:
        return f"{name_of(self.parameter)}_{name_of(self.law)}"

    def __call__(self, *values: Number) -> Number:
        at = dict(zip(self.inputs, values, strict=True))
        result = self.parameter(*[at[name] for name in argument_names(self.parameter)])
        return self.law(result, *[at[name] for name in argument_names(self.law)[1:]])


# Suffix of the name of a table without terms of the bank.
OPEN_WATER = "open_water"
PUBLISHED, REFITTED, NEW = "published", "form of another, coefficients refitted", "new in narrows"


@dataclass(frozen=True, repr=False)
class BankForm(BaseSummary):
    """A form of the bank term.

    >>> nw.FORMS["delta"].name
    'delta'
    """

    name: str  #: As in ``paper+keel_gap``
    #: Pressure parameters, by the coefficients' ending: ``bank`` for b_bank and c_bank
    parameters: Mapping[str, Callable[..., Number]]
    source: str  #: Its source
    validity: str  #: Range of validity
    status: str  #: ``published``, ``form of another, coefficients refitted`` or ``new in narrows``

    def summary(self) -> str:
        return f"{self.name}, {self.status}: {self.source}"

    @property
    def sway(self) -> tuple[Term, ...]:
        """Terms of the sway force, with the paper's names."""
        return _bank_terms(self, LETTERS[1], suction)

    @property
    def yaw(self) -> tuple[Term, ...]:
        """Terms of the yaw moment, with the paper's names."""
        return _bank_terms(self, LETTERS[2], cushion)


def _bank_terms(form: BankForm, letter: str, law: Callable[..., Number]) -> tuple[Term, ...]:
    return tuple(
        Term(
            f"{letter}_{ending}", rf"{letter}_{{{ending.replace('_', ',')}}}", Composed(law, parameter), dim.NUMBER,
            kind=TermKind.BANK, source=form.source, scale_effect=ScaleEffect.BANK_SHAPE,
        )
        for ending, parameter in form.parameters.items()
    )  # fmt: skip


PAPER_TEXT = "Mikkelsen et al. (2025)"
TWO = "h > T; two coefficients a force, so that the sign can change with depth"
# The forms by name.
FORMS = {
    form.name: form
    for form in (
        BankForm("delta", {"bank": clearance.delta}, PAPER_TEXT, "clear of the banks; independent of depth", PUBLISHED),
        BankForm("tapered", {"bank": clearance.tapered_delta}, f"{PAPER_TEXT}, red curve of fig. (Delta_fun)",
                 "also within the boundary layer of a wall; independent of depth", PUBLISHED),
        BankForm("distance", {"bank": clearance.bank_distance}, "y_B of Ch'ng (1993) and Vantorre et al. (2003)",
                 "far from the banks; independent of depth", REFITTED),
        BankForm("distance_depth", {"bank": clearance.bank_distance, "bank_depth": clearance.shallow_bank_distance},
                 "y_B and y_B T/(h - T) of Vantorre et al. (2003)",
                 f"far from the banks, {TWO}", REFITTED),
        BankForm("tuck", {"bank": clearance.critical_bank_distance}, "y_B with Tuck's number, after Lataire (2014)",
                 "far from the banks, well below the critical speed (F < 0.7)", REFITTED),
        BankForm("return_flow", {"bank": clearance.fast_bank_distance}, "y_B with the return flow of Schijf (1949)",
                 "far from the banks, below the speed that chokes the canal", NEW),
        BankForm("keel_gap", {"bank": clearance.keel_gap_delta}, "delta with B T/h in place of B",
                 "h >= T; the paper's delta at T = h; no change of sign", NEW),
        BankForm("delta_depth", {"bank": clearance.delta, "bank_depth": clearance.shallow_delta},
                 "delta and delta T/(h - T)", TWO, NEW),
    )
}  # fmt: skip


def with_bank(table: TermTable, form: str | BankForm, name: str = "") -> TermTable:
    """Return a table with another form of its bank term.

    Raises an InputError if there is no such form.

    Parameters
    ----------
    table : TermTable
        The table; its own bank terms are replaced.
    form : str or BankForm
        One of ``FORMS``, or your own.
    name : str
        Name of the new table; ``table+form`` unless given.

    Examples
    --------
    >>> "b_bank" in nw.with_bank(nw.SPEED, "tuck").names
    True
    """
    form = _form(form)
    kept = without(table, name or f"{_base(table)}+{form.name}", lambda term: term.from_bank)
    _, sway, yaw = table.letters
    return kept.with_terms(kept.name, sway=_bank_terms(form, sway, suction), yaw=_bank_terms(form, yaw, cushion))


def without_bank(table: TermTable) -> TermTable:
    return without(table, f"{_base(table)}+{OPEN_WATER}", lambda term: term.from_bank)


def _base(table: TermTable) -> str:
    """The name of a table without its form of the bank."""
    base, *additions = table.name.split("+")
    return "+".join([base, *(word for word in additions if word in ADDED)])


def _form(form: str | BankForm) -> BankForm:
    if isinstance(form, str) and form not in FORMS:
        raise InputError(f"unknown form {form!r} of the bank term{did_you_mean(form, FORMS)}")
    return FORMS[form] if isinstance(form, str) else form
