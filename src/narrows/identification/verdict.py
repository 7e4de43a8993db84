"""Verdict on each coefficient: from its posterior, and from rank, condition and variance inflation of the columns."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from narrows.identification.estimates import HALF, CoefficientEstimates
from narrows.identification.least_squares import RANK_TOLERANCE
from narrows.identification.motions import DistinctMotions
from narrows.identification.normal_equations import ONE, NormalEquations, Score
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
# A column takes part in a direction of unit length where its share is larger than this.
INVOLVED = 1e-3


@dataclass(frozen=True)
class Diagnosis:
    names: tuple[str, ...]  # The coefficients
    rank: int  # Number of directions with data
    condition: float  # Condition number of the matrix with columns scaled to one; infinite where the rank is short [1]
    # Variance inflation, 1/(1 - R2) of a column on the others, without intercept as the model has none; infinite
    # where the column is a combination of others, NaN where it is zero [1]
    vif: Mapping[str, float]
    correlation: np.ndarray  # (n, n) Correlation of the columns; NaN where one does not vary
    empty: tuple[str, ...]  # Coefficients whose column is zero
    # (k, n) Directions without data, of unit length, among the columns that are not zero, each scaled to one
    missing: np.ndarray

    def to_dict(self) -> dict[str, Any]:
        return {"rank": self.rank, "columns": len(self.names), "condition": self.condition, "vif": dict(self.vif)}


def diagnose(equations: NormalEquations, sums: np.ndarray, terms: tuple[Term, ...]) -> Diagnosis:
    names = [term.name for term in terms]
    gram, mean = equations.pick(sums, names), equations.pick(sums, names, [ONE])[:, 0]
    norm = np.sqrt(np.diag(gram))
    live = norm > 0
    lengths = np.where(live, norm, np.nan)
    alignment = gram / np.outer(lengths, lengths)
    values, vectors = np.linalg.eigh(alignment[np.ix_(live, live)])
    singular = np.sqrt(np.maximum(values, 0.0))
    kept = singular > RANK_TOLERANCE * singular.max(initial=1e-300)
    missing = np.zeros((int((~kept).sum()), len(names)))
    missing[:, live] = vectors[:, ~kept].T
    vif = np.full(len(names), np.nan)
    vif[live] = np.maximum((vectors[:, kept] ** 2 / values[kept]).sum(axis=1), 1.0)
    vif[(np.abs(missing) > INVOLVED).any(axis=0)] = np.inf
    covariance = gram - np.outer(mean, mean) / equations.pick(sums, [ONE])[0, 0]
    variance = np.diag(covariance)
    # A constant column leaves only rounding.
    spread = np.sqrt(np.where(variance > 1e-12 * np.diag(gram), variance, np.nan))
    return Diagnosis(
        tuple(names),
        rank=int(kept.sum()),
        condition=float(singular[-1] / singular[0]) if kept.sum() == len(names) else float("inf"),
        vif=dict(zip(names, vif.tolist(), strict=True)),
        correlation=np.clip(covariance / np.outer(spread, spread), -1.0, 1.0),
        empty=tuple(name for name, alive in zip(names, live, strict=True) if not alive),
        missing=missing,
    )


@dataclass(frozen=True)
class Diagnostics:
    """The columns of every force, whatever the forces are; each diagnosis is made when it is first asked for."""

    equations: NormalEquations  # The sums
    terms: TermTable  # The terms
    motions: DistinctMotions  # The distinct motions, and their speeds

    @cached_property
    def overall(self) -> dict[str, Diagnosis]:
        """Over all rows: force -> diagnosis."""
        return self.over(self.equations.total)

    @cached_property
    def by_speed(self) -> dict[float, dict[str, Diagnosis]]:
        """Over the tests of each speed together: mean speed [m/s] -> force -> diagnosis."""
        motions = self.motions
        return {
            float(np.mean(motions.features["speed"][members])): self.over(motions.sums[members].sum(axis=0))
            for members in motions.by_speed
        }

    def over(self, sums: np.ndarray) -> dict[str, Diagnosis]:
        return {force: diagnose(self.equations, sums, part) for force, part in self.terms.forces.items() if part}

    def determined(self, name: str) -> bool:
        """Return whether rows determine a coefficient, through its own force or through one that it is tied to."""
        tied = {name, *(other for tie in self.terms.ties if name in tie for other in tie)}
        return any(np.isfinite(d.vif[other]) for d in self.overall.values() for other in tied if other in d.names)


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
        limited = (f"off by a standard error with {' or '.join(self.limits)}",) * bool(self.limits)
        tipped = (f"overturned by {' or '.join(self.tipping)}",) * bool(self.tipping)
        clauses = "; ".join((*self.reasons, *limited, *tipped))
        return f"{name} is {self.words}" + (f": {clauses}." if clauses else ".")


def verdicts(
    diagnostics: Diagnostics, found: CoefficientEstimates, left_out: Mapping[str, Score]
) -> dict[str, Verdict]:
    judged = {}
    for force, part in diagnostics.terms.forces.items():
        for term in part:
            verdict = _without_data(term, force, diagnostics) or _judged(term.name, found)
            # No interval is trusted where the mean predicts a force of left-out tests better than the terms do.
            if verdict.status == IDENTIFIED and left_out[force].r2 < 0:
                r2 = f"R2 {left_out[force].r2:.2f}"
                reason = f"{force} of left-out tests is predicted worse than by its mean ({r2})"
                verdict = Verdict(IMPRECISE, (*verdict.reasons, reason))
            judged[term.name] = verdict
    return judged


def _without_data(term: Term, force: str, diagnostics: Diagnostics) -> Verdict | None:
    """A coefficient that its own force's columns do not determine; one that is tied may be known by its partner."""
    overall = diagnostics.overall[force]
    if diagnostics.determined(term.name):
        return None
    if term.name in overall.empty:
        what = term.inputs[0] if len(term.inputs) == 1 else "its regressor"
        return Verdict(NOT_EXCITED, (f"{what} is 0 in every test",))
    for direction in overall.missing:  # The data determine the orthogonal combinations
        involved = [name for name, part in zip(overall.names, direction, strict=True) if abs(part) > INVOLVED]
        if term.name in involved:
            names = " and ".join(involved)
            reason = f"the tests determine {names} only in combination, their columns being dependent"
            return Verdict(NOT_IDENTIFIABLE, (reason,))
    return None


def _judged(name: str, found: CoefficientEstimates) -> Verdict:
    names, slot = found.problem.terms.names, found.problem.slot
    index = names.index(name)
    value, (low, high) = float(found.values[index]), found.ends[index].tolist()
    half = (high - low) / 2
    if found.held[index]:
        return Verdict(AT_BOUND, (f"the data alone would put it beyond, at {found.free_values[index]:.3g}",))
    known = with_error(value, half)
    if (low > 0 or high < 0) and half < PRECISE * abs(value):
        tipping, limits = (_named(errors[name]) for errors in (found.tipping, found.limits))
        return Verdict(IDENTIFIED, (f"{known}, {half / abs(value):.0%}",), (), tipping, limits)
    part = next(part for part in found.forces if slot[name] in part.rows.free_parameters)
    # The unit is the value at which the term is as large as its force.
    if max(abs(low), abs(high)) < NEGLIGIBLE * part.unit[part.rows.free_parameters.index(slot[name])]:
        return Verdict(ZERO, (f"{low:.2g} to {high:.2g} makes less than {NEGLIGIBLE:.0%} of the force",))
    # The coefficient whose estimate is most correlated with this one's, and the combination that the tests determine.
    c, size = found.covariance, np.sqrt(np.diag(found.covariance))
    others = np.array([slot[other] != slot[name] for other in names]) & (size > 0)
    correlation = np.abs(c[index]) / np.where(others & (size[index] > 0), size * size[index], np.inf)
    other = int(correlation.argmax())
    if correlation[other] > INSEPARABLE:
        slope = -c[index, other] / c[other, other]
        error = HALF * float(np.sqrt(max(c[index, index] + slope * c[index, other], 0.0)))
        combined = with_error(value + slope * found.values[other], error)
        reason = f"the tests determine {name} {slope:+.3g} {names[other]} = {combined}"
        return Verdict(NOT_SEPARABLE, (reason,), (names[other],))
    return Verdict(IMPRECISE, (f"{known}, its 95 % interval is {interval((low, high), half)}",))


def _named(errors: list[tuple[Effect, float]]) -> tuple[str, ...]:
    """The least unusual errors, one of each kind."""
    by_kind: dict[str, str] = {}
    for effect, size in errors:
        by_kind.setdefault(effect.name.split(" ")[0], f"{size:.2g} {effect.unit} of {effect.name}")
    return tuple(by_kind.values())[:MOST_NAMED]
