"""What a fit says first: a sentence on the hull, one on the bank, whether to trust it, and which runs to make next."""

import math
from dataclasses import dataclass

import numpy as np

from narrows.captive.tests import CaptiveTests
from narrows.errors import InputError
from narrows.identification.fit import Fit
from narrows.identification.fitting import identify
from narrows.identification.verdict import IDENTIFIED
from narrows.terms.tables import BARE, table_named
from narrows.terms.term import TermTable

# Error on what was left out, over that of the given terms, below which tests prefer other terms.
BETTER = 0.98
UNITS = {"X": "N", "Y": "N", "N": "N m"}
# Of the half width of the canal: an offset that a straight run must have to tell of a bank.
OFF_CENTRE = 0.1


@dataclass(frozen=True)
class Answer:
    """What comes first of all that is known of a fit."""

    fit: Fit  # Of the terms that were asked for
    preferred: Fit | None  # Of the hull's terms that err least on what was left out, where these are others

    @property
    def sentences(self) -> tuple[str, ...]:
        """How well the hull is known, the bank's coefficients, whether to trust them, and what to run next."""
        return self._hull(), self._coefficients(), self._trust(), self._next_runs()

    def to_dict(self) -> dict[str, object]:
        """Give the sentences, and the terms that the tests prefer."""
        terms = (self.preferred or self.fit).terms.name
        return {"summary": " ".join(self.sentences), "preferred_terms": terms}

    @property
    def settled(self) -> bool:
        """Whether the bank's coefficients are identified, under the terms given and those preferred, and agree."""
        fits = [self.fit, *([self.preferred] if self.preferred else [])]
        names = bank_names(self.fit)
        certain = all(fit.verdicts[name].status == IDENTIFIED for fit in fits for name in names)
        return bool(names) and certain and not self.fit.implausible and not self._apart()

    def _hull(self) -> str:
        """How many hull coefficients are identified, and how well left-out motions are predicted."""
        hull = [term.name for term in self.fit.terms.terms if not term.from_bank]
        known = sum(self.fit.verdicts[name].status == IDENTIFIED for name in hull)
        first = f"{known} of {len(hull)} hull coefficients are identified"
        parts = [f"{one.force} to +- {one.half:.2g} {UNITS[one.force]}" for one in self.fit.predictiveness]
        return f"{first}; motions left out in turn are predicted {', '.join(parts)} (95 %)." if parts else f"{first}."

    def _coefficients(self) -> str:
        if not bank_names(self.fit):
            return f"The terms {self.fit.terms.name} have none of the bank, so that nothing is said of it."
        first = f"Under the terms {self.fit.terms.name} the bank's coefficients are {_listed(self.fit)}"
        if self.preferred is None:
            return f"{first}; {_why_none(self.fit)}."
        other, fit = self.preferred.left_out, self.fit.left_out
        errors = [f"{other[f].rmse:.3g} for {fit[f].rmse:.3g} {UNITS[f]} in {f}" for f in _forces(self.fit)]
        told = f"which these tests prefer (errors on motions left out {' and '.join(errors)})"
        return f"{first}; under {self.preferred.terms.name}, {told}, {_listed(self.preferred)}."

    def _trust(self) -> str:
        if self.fit.implausible:
            return f"They cannot be trusted, as something is wrong with the tests: {self.fit.implausible[0]}"
        if self.settled:
            return (
                f"They are identified as far as these terms hold: {'; '.join(self._limits())}. No test shows a gain "
                "that all runs share."
            )
        if not bank_names(self.fit):
            known = sum(verdict.status == IDENTIFIED for verdict in self.fit.verdicts.values())
            return f"{known} of {len(self.fit.terms.names)} coefficients are identified."
        return f"They are not all identified: {'; '.join(self._doubts())}."

    def _limits(self) -> list[str]:
        """Which error of a campaign would put each coefficient of the bank outside its interval."""
        told = [(name, self.fit.verdicts[name].limits) for name in bank_names(self.fit)]
        parts = [f"{name} would be off by more with {' or '.join(limits[:2])}" for name, limits in told if limits]
        return parts or ["no usual error of a campaign puts them outside their intervals"]

    def _doubts(self) -> list[str]:
        doubts = []
        for fit in (self.fit, self.preferred):
            words = (
                [_doubt(fit, name) for name in bank_names(fit) if fit.verdicts[name].status != IDENTIFIED]
                if fit
                else []
            )
            if fit and words:
                where = f"under {fit.terms.name} " if fit is self.preferred else ""
                doubts.append(f"{where}{', '.join(words)}")
        apart = self._apart()
        return [*doubts, *([f"the two disagree on {' and '.join(apart)}"] if apart else [])]

    def _apart(self) -> list[str]:
        """Coefficients whose intervals under the two tables of terms have nothing in common."""
        if self.preferred is None:
            return []
        pairs = ((n, self.fit.intervals[n], self.preferred.intervals[n]) for n in bank_names(self.fit))
        return [name for name, one, other in pairs if one[1] < other[0] or other[1] < one[0]]

    def _next_runs(self) -> str:
        if self.settled:
            return (
                "No run is needed to tell that there is a bank's force; narrows plan names those that narrow it most."
            )
        asks = missing_runs(self.fit)
        plan = "narrows plan, with --after these tests, chooses them"
        return f"Run next: {', and '.join(asks)}; {plan}." if asks else f"Run next other motions than these: {plan}."


def answer_of(fit: Fit) -> Answer:
    """Put the answer of a fit first: its bank's coefficients, under its terms and under those that its tests prefer."""
    return Answer(fit, preferred_fit(fit) if _comparable(fit) else None)


def bank_names(fit: Fit) -> list[str]:
    """Return the bank's coefficients."""
    return [term.name for term in fit.terms.terms if term.from_bank]


def preferred_fit(fit: Fit) -> Fit | None:
    """Return the fit of the hull's terms, with the same form of the bank, that errs least on what was left out."""
    # None where the terms of the fit do, within two per cent.
    others = []
    for table in _others(fit.terms):
        try:
            others.append(
                identify(fit.tests, table, balance=fit.normal_equations.balance, errors=fit.errors, pass_over="rudder")
            )
        except InputError:
            continue
    best = min(others, key=lambda other: _relative_error(other, fit), default=fit)
    return best if _relative_error(best, fit) < BETTER else None


def missing_runs(fit: Fit) -> list[str]:
    """Name the kinds of runs that part a bank from the hull and are not among the tests."""
    motions, strata = fit.motions, fit.motions.strata
    off = motions.steady & (motions.reach > OFF_CENTRE * fit.tests.configuration.canal.width / 2)
    speeds = sorted({round(float(motions.features["speed"][group].mean()), 2) for group in motions.by_speed})
    fastest = f"{speeds[-1]:g} m/s"
    asks = []
    if len(set(strata["side"][off].tolist())) < 2:
        asks.append(f"straight runs off the centreline to both sides at {fastest}")
    harmonic = ~motions.steady
    periods = [len(set(strata["period"][group][harmonic[group]].tolist())) for group in motions.by_speed]
    if max(periods, default=0) < 2:
        asks.append(f"harmonic yaw at two periods or more at {fastest}")
    return asks


def _comparable(fit: Fit) -> bool:
    return isinstance(fit.tests, CaptiveTests) and bool(bank_names(fit)) and fit.split == "test"


def _others(terms: TermTable) -> list[TermTable]:
    """The package's other tables of a hull, with the additions that these terms have."""
    base, plus, additions = terms.name.partition("+")
    if base not in BARE or terms != table_named(terms.name):
        return []
    return [table_named(f"{name}{plus}{additions}") for name in BARE if name != base]


def _forces(fit: Fit) -> list[str]:
    return [force for force, part in fit.terms.forces.items() if any(term.from_bank for term in part)]


def _relative_error(other: Fit, fit: Fit) -> float:
    """Geometric mean, over the forces that the bank makes, of errors on what was left out over those of the fit."""
    ratios = [other.left_out[force].rmse / max(fit.left_out[force].rmse, 1e-300) for force in _forces(fit)]
    mean = float(np.exp(np.mean(np.log(np.maximum(ratios, 1e-300)))))
    return mean if math.isfinite(mean) else math.inf


def _listed(fit: Fit) -> str:
    parts = []
    for name in bank_names(fit):
        low, high = fit.intervals[name]
        known = fit.verdicts[name].determined
        parts.append(f"{name} {fit.coefficients[name]:.2g} ({low:.2g} to {high:.2g})" if known else f"{name} unknown")
    return " and ".join(parts)


def _doubt(fit: Fit, name: str) -> str:
    return f"{name} is {fit.verdicts[name].words}"


def _why_none(fit: Fit) -> str:
    return "no other terms of the hull do better on these tests" if _comparable(fit) else "no other terms were tried"
