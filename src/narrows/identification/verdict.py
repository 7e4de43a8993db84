"""Verdict on each coefficient: one word from the posterior, one plain sentence, and its tipping points."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from narrows.identification.collinearity import INVOLVED, Diagnosis, Diagnostics
from narrows.identification.estimates import HALF, CoefficientEstimates
from narrows.identification.normal_equations import Score
from narrows.identification.systematic_effects import Effect
from narrows.results.base_results import interval, with_error
from narrows.terms.term import Term, TermTable

IDENTIFIED, IMPRECISE, NOT_SEPARABLE, ZERO = "identified", "imprecise", "not separable", "zero"
AT_BOUND, NOT_EXCITED, NOT_IDENTIFIABLE = "at bound", "not excited", "not identifiable"
# Half width of the interval over the estimate, below which a coefficient is identified.
PRECISE = 0.5
# Share of the force that a term makes, below which its coefficient is zero for practical purposes.
NEGLIGIBLE = 0.02
# Posterior correlation of two coefficients beyond which the tests do not separate them.
INSEPARABLE = 0.9
# Errors of a campaign that are named with a verdict.
MOST_NAMED = 3


@dataclass(frozen=True)
class Verdict:
    """Verdict on a coefficient.

    Parameters
    ----------
    status : str
        ``identified``, ``imprecise``, ``not separable``, ``zero``, ``at bound``, ``not identifiable`` or
        ``not excited``.
    reasons : tuple of str
        Why, each a clause.
    partners : tuple of str
        Coefficients from which the tests do not separate it.
    tipping : tuple of str
        Errors of a campaign that would bring the interval to 0, the least unusual first, each with its size.
    limits : tuple of str
        Errors of a campaign that move the estimate by its standard error, or are too large to be sure that they do not.
    """

    status: str
    reasons: tuple[str, ...] = ()
    partners: tuple[str, ...] = ()
    tipping: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()

    @property
    def determined(self) -> bool:
        """Whether the data determine the coefficient at all."""
        return self.status not in (NOT_EXCITED, NOT_IDENTIFIABLE)

    @property
    def words(self) -> str:
        """The status, and the coefficients from which the tests do not separate it."""
        word = NOT_IDENTIFIABLE if self.status == NOT_EXCITED else self.status
        return f"{word} from {' and '.join(self.partners)}" if self.partners else word

    def sentence(self, name: str) -> str:
        """One sentence of a coefficient."""
        limited = (f"off by a standard error with {' or '.join(self.limits)}",) * bool(self.limits)
        tipped = (f"overturned by {' or '.join(self.tipping)}",) * bool(self.tipping)
        clauses = "; ".join((*self.reasons, *limited, *tipped))
        return f"{name} is {self.words}" + (f": {clauses}." if clauses else ".")


def verdicts(
    diagnostics: Diagnostics, found: CoefficientEstimates, left_out: Mapping[str, Score]
) -> dict[str, Verdict]:
    """Judge every coefficient of a fit."""
    terms = diagnostics.terms
    judged = {}
    for force, part in terms.forces.items():
        for term in part:
            index, known = terms.names.index(term.name), diagnostics.determined(term.name)
            verdict = _without_data(term, diagnostics.overall[force], known) or _judged(term, index, terms, found)
            judged[term.name] = _of_a_force(verdict, force, left_out[force].r2)
    return judged


def _of_a_force(verdict: Verdict, force: str, r2: float) -> Verdict:
    """Trust no interval where the mean predicts a force of left-out tests better than the terms do."""
    if verdict.status != IDENTIFIED or not r2 < 0:
        return verdict
    reason = f"{force} of left-out tests is predicted worse than by its mean (R2 {r2:.2f})"
    return Verdict(IMPRECISE, (*verdict.reasons, reason))


def _without_data(term: Term, overall: Diagnosis, known: bool) -> Verdict | None:
    """A coefficient that its own force's columns do not determine; one that is tied may be known by its partner."""
    if known:
        return None
    if term.name in overall.empty:
        what = term.inputs[0] if len(term.inputs) == 1 else "its regressor"
        return Verdict(NOT_EXCITED, (f"{what} is 0 in every test",))
    for direction in overall.missing:
        if abs(direction[overall.names.index(term.name)]) > INVOLVED:
            return Verdict(NOT_IDENTIFIABLE, (_combination(overall, direction),))
    return None


def _combination(overall: Diagnosis, direction: np.ndarray) -> str:
    """Name the coefficients of a direction without data; the data determine the orthogonal ones."""
    involved = [name for name, part in zip(overall.names, direction, strict=True) if abs(part) > INVOLVED]
    return f"the tests determine {' and '.join(involved)} only in combination, their columns being dependent"


def _judged(term: Term, index: int, terms: TermTable, found: CoefficientEstimates) -> Verdict:
    value, (low, high) = float(found.values[index]), found.ends[index].tolist()
    half = (high - low) / 2
    if found.held[index]:
        return Verdict(AT_BOUND, (f"the data alone would put it beyond, at {found.free_values[index]:.3g}",))
    known = with_error(value, half)
    if (low > 0 or high < 0) and half < PRECISE * abs(value):
        tipping, limits = (_named(errors[term.name]) for errors in (found.tipping, found.limits))
        return Verdict(IDENTIFIED, (f"{known}, {half / abs(value):.0%}",), (), tipping, limits)
    if max(abs(low), abs(high)) < NEGLIGIBLE * _usual(term.name, found):
        return Verdict(ZERO, (f"{low:.2g} to {high:.2g} makes less than {NEGLIGIBLE:.0%} of the force",))
    partner = _partner(index, terms, found)
    if partner is not None:
        return Verdict(NOT_SEPARABLE, (_direction(index, partner, terms, found),), (terms.names[partner],))
    return Verdict(IMPRECISE, (f"{known}, its 95 % interval is {interval((low, high), half)}",))


def _usual(name: str, found: CoefficientEstimates) -> float:
    """Value at which the term is as large as its force."""
    slot = found.problem.slot[name]
    return next(
        float(part.unit[part.free_parameters.index(slot)]) for part in found.forces if slot in part.free_parameters
    )


def _named(errors: list[tuple[Effect, float]]) -> tuple[str, ...]:
    """The least unusual errors, one of each kind."""
    by_kind: dict[str, str] = {}
    for effect, size in errors:
        by_kind.setdefault(effect.name.split(" ")[0], f"{size:.2g} {effect.unit} of {effect.name}")
    return tuple(by_kind.values())[:MOST_NAMED]


def _partner(index: int, terms: TermTable, found: CoefficientEstimates) -> int | None:
    """The coefficient whose estimate is most correlated with this one's."""
    size = np.sqrt(np.diag(found.covariance))
    if not size[index] > 0:
        return None
    correlation = np.abs(found.covariance[index]) / np.where(size > 0, size * size[index], np.inf)
    slots = np.array([found.problem.slot[name] for name in terms.names])
    correlation[slots == slots[index]] = 0.0
    most = int(correlation.argmax())
    return most if correlation[most] > INSEPARABLE else None


def _direction(index: int, partner: int, terms: TermTable, found: CoefficientEstimates) -> str:
    """The combination of two coefficients that the tests determine."""
    c, names = found.covariance, terms.names
    slope = -c[index, partner] / c[partner, partner]
    value = found.values[index] + slope * found.values[partner]
    half = HALF * float(np.sqrt(max(c[index, index] + slope * c[index, partner], 0.0)))
    return f"the tests determine {names[index]} {slope:+.3g} {names[partner]} = {with_error(value, half)}"
