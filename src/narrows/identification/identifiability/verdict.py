"""How far each coefficient can be trusted, in one word and a few clauses, from thresholds stated here."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from narrows.identification.identifiability.diagnosis import INVOLVED, Diagnosis
from narrows.identification.identifiability.diagnostics import Diagnostics
from narrows.identification.identifiability.evidence import ONE_TEST, Evidence
from narrows.identification.identifiability.other_estimates import ComparedEstimate, Kind
from narrows.identification.identifiability.strata import HARMONIC_RUNS, STEADY_RUNS
from narrows.terms.term import Term

# Over all rows: beyond this the other columns leave a coefficient under a tenth of its own information.
VIF_LIMIT = 10.0
# Over all rows, or as information that is lost within strata: beyond this a small error of the model's form, shared by
# the columns that align, lands on the coefficient magnified; no standard error knows that.
CONFOUNDED_VIF = 30.0
# Probability of the scatter about the fit under which the terms are said not to fit.
MISFIT = 1e-3

NOT_EXCITED, NOT_IDENTIFIABLE = "not excited", "not identifiable"
AT_BOUND, CONFOUNDED, ONE_ALONE = "at its bound", "confounded", "rests on one test"
CONTRADICTED, WEAK, IDENTIFIED = "contradicted", "weakly identified", "identified"

WITH = dict.fromkeys(Kind, "with ") | {Kind.WITHOUT: "without ", Kind.ONLY: "", Kind.TYPE: ""}


@dataclass(frozen=True)
class Verdict:
    """What can be said of a coefficient."""

    # ``identified``, ``weakly identified``, ``contradicted``, ``rests on one test``, ``confounded``, ``at its
    # bound``, ``not identifiable`` or ``not excited``
    status: str
    reasons: tuple[str, ...] = ()  # Why, each a clause
    partners: tuple[str, ...] = ()  # With which coefficients it is confounded

    @property
    def determined(self) -> bool:
        """Whether the data determine the coefficient at all."""
        return self.status not in (NOT_EXCITED, NOT_IDENTIFIABLE)

    @property
    def words(self) -> str:
        """The verdict, and with which coefficients it is confounded."""
        word = "not identifiable" if self.status == NOT_EXCITED else self.status
        return f"{word} with {' and '.join(self.partners)}" if self.partners else word

    def sentence(self, name: str) -> str:
        """Say it of a coefficient."""
        verb = "" if self.status == ONE_ALONE else "is "
        return f"{name} {verb}{self.words}" + (f": {'; '.join(self.reasons)}." if self.reasons else ".")


def verdicts(
    diagnostics: Diagnostics,
    evidence: Evidence,
    intervals: Mapping[str, tuple[float, float]],
    at_bound: Mapping[str, float],
) -> dict[str, Verdict]:
    """Say how far each coefficient of a fit can be trusted."""
    terms = diagnostics.terms
    judged = {}
    for force, part in terms.forces.items():
        for term in part:
            overall, index = diagnostics.overall[force], terms.names.index(term.name)
            verdict = _without_data(term, overall, diagnostics.determined(term.name))
            judged[term.name] = verdict or _judged(term, index, diagnostics, force, evidence, intervals, at_bound)
    return judged


def _without_data(term: Term, overall: Diagnosis, known: bool) -> Verdict | None:
    """Where the columns of a coefficient's own force leave it open."""
    reason, status = "", NOT_IDENTIFIABLE
    if term.name in overall.empty:
        what = term.inputs[0] if len(term.inputs) == 1 else "its regressor"
        reason, status = f"{what} is 0 in every test", NOT_EXCITED
    for direction in overall.missing:
        if not reason and abs(direction[overall.names.index(term.name)]) > INVOLVED:
            reason = _combination(overall, direction)
    if not reason:
        return None
    return Verdict(WEAK, (f"{reason}, so that only its tie determines it",)) if known else Verdict(status, (reason,))


def _judged(
    term: Term, index: int, diagnostics: Diagnostics, force: str, evidence: Evidence,
    intervals: Mapping[str, tuple[float, float]], at_bound: Mapping[str, float],
) -> Verdict:  # fmt: skip
    if term.name in at_bound:
        return Verdict(AT_BOUND, (_beyond(term, at_bound[term.name]),))
    vif = diagnostics.overall[force].vif[term.name]
    doubts = _from_comparisons(list(evidence.compared(index)))
    doubts += _by_itself(intervals[term.name], vif, evidence.lack_of_fit(index))
    words = [word for word, _ in doubts]
    status = next((word for word in (CONFOUNDED, ONE_ALONE, CONTRADICTED, WEAK) if word in words), IDENTIFIED)
    partners = _partners(term.name, force, diagnostics) if status == CONFOUNDED else ()
    return Verdict(status, tuple(dict.fromkeys(reason for _, reason in doubts)), partners)


def _beyond(term: Term, value: float) -> str:
    low, high = term.bound
    if low <= value <= high:
        return "other bounds press it there: without its own the fit stays inside"
    return f"the data alone would put it beyond, at {value:.3g}"


def _from_comparisons(comparisons: list[ComparedEstimate]) -> list[tuple[str, str]]:
    """Doubts that other fits raise: word and reason."""
    doubts = [doubt for c in comparisons if c.kind in (Kind.STRATA, Kind.SHAPE) for doubt in _within(c)]
    doubts += _of_one([c for c in comparisons if c.kind is Kind.WITHOUT])
    doubts += [(CONTRADICTED, _against(c, comparisons)) for c in comparisons if c.contradicts]
    weighted = [c for c in comparisons if c.kind is Kind.WEIGHTS and c.holds_zero]
    return doubts + [(WEAK, f"with {c.label} its interval holds 0") for c in weighted]


def _left(c: ComparedEstimate) -> str:
    return "nothing is left of it" if c.lost else f"{c.share:.1%} of what is known of it is left"


def _against(c: ComparedEstimate, comparisons: list[ComparedEstimate]) -> str:
    """What contradicts a fit; of steady and harmonic runs both numbers."""
    clause = f"{WITH[c.kind]}{c.label} it is {c.value:.3g}"
    other = {STEADY_RUNS: HARMONIC_RUNS, HARMONIC_RUNS: STEADY_RUNS}
    for one, opposite in other.items():
        if one in c.label:
            told = [d for d in comparisons if d.kind is c.kind and opposite in d.label]
            return clause + "".join(
                f" +- {c.reach:.2g}, {WITH[d.kind]}{d.label} {d.value:.3g} +- {d.reach:.2g}" for d in told
            )
    return clause


def _within(c: ComparedEstimate) -> list[tuple[str, str]]:
    if c.lost or (c.kind is Kind.STRATA and c.share < 1 / CONFOUNDED_VIF):
        return [(CONFOUNDED, f"with {c.label} {_left(c)}")]
    low, high = c.value - c.reach, c.value + c.reach
    return [(CONFOUNDED, f"with {c.label} it is {low:.3g} to {high:.3g}, which holds 0")] if c.holds_zero else []


def _of_one(without: list[ComparedEstimate]) -> list[tuple[str, str]]:
    """Doubts about a coefficient that stands or falls with one motion."""
    pinned = [c.label for c in without if c.lost]
    if len(without) < 2:
        return [(ONE_ALONE, "it is the only motion")]
    if pinned:
        return [(ONE_ALONE, f"without {' or without '.join(pinned)} nothing is known of it")]
    least = min(without, key=lambda c: c.share)
    if 1 - least.share > ONE_TEST:
        return [(ONE_ALONE, f"{1 - least.share:.1%} of what is known of it goes with {least.label}")]
    zero = [c for c in without if c.holds_zero]
    return [(ONE_ALONE, f"without {zero[0].label} its interval holds 0")] if zero else []


def _by_itself(interval: tuple[float, float], vif: float, lack: float) -> list[tuple[str, str]]:
    low, high = interval
    doubts = [(WEAK, f"its 95 % interval {low:.3g} to {high:.3g} holds 0")] if low <= 0 <= high else []
    if vif > VIF_LIMIT:
        word = CONFOUNDED if vif > CONFOUNDED_VIF else WEAK
        doubts.append((word, f"VIF {vif:.0f} over all rows"))
    if lack < MISFIT:
        doubts.append((WEAK, f"the terms do not fit this force within the errors of runs (p = {lack:.0e})"))
    return doubts


def _partners(name: str, force: str, diagnostics: Diagnostics) -> tuple[str, ...]:
    """The coefficients that take its place over all rows, or at the speed that tells most of it."""
    overall = diagnostics.overall[force]
    single = [by_force[force] for by_force in diagnostics.by_speed.values() if name not in by_force[force].empty]
    worst = max(single, key=lambda d: d.vif[name], default=overall)
    return (overall if overall.vif[name] > CONFOUNDED_VIF else worst).partners(name)


def _combination(overall: Diagnosis, direction: np.ndarray) -> str:
    """Name the coefficients of a direction without data; what is known is orthogonal to it."""
    involved = [name for name, part in zip(overall.names, direction, strict=True) if abs(part) > INVOLVED]
    return f"the tests determine {' and '.join(involved)} only in combination, their columns being dependent"
