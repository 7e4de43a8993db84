"""Summary of a fit: a sentence on the hull, one on the bank, one on the next runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from narrows.base.errors import InputError
from narrows.base.results import interval, readable
from narrows.captive.tests import CaptiveTests
from narrows.identification.fit import Fit
from narrows.identification.fitting import identify
from narrows.identification.motions import numbered
from narrows.identification.verdict import IDENTIFIED
from narrows.model.tables import BARE, table_named
from narrows.quantities.names import FORCES


@dataclass(frozen=True)
class BankSummary:
    """The hull, the bank and the next runs of a fit in one sentence each, with details."""

    fit: Fit  # Fit with the requested terms
    preferred: Fit | None  # Fit with the hull terms that predict left-out motions best, if these differ

    @property
    def warnings(self) -> tuple[str, ...]:
        """Implausible results that the verdict on the bank does not name."""
        return tuple(sentence for sentence in self.fit.implausible if sentence not in self._bank())

    @property
    def sentences(self) -> tuple[str, ...]:
        return self._hull(), self._bank(), self._next_runs()

    @property
    def details(self) -> tuple[str, ...]:
        """Bank coefficients with other hull terms, and the campaign errors that would move them by a standard error."""
        return tuple(filter(None, (self._other_terms(), self._limits() if self.settled else "")))

    def to_dict(self) -> dict[str, object]:
        """Give the sentences, the details, and the terms that predict left-out motions best."""
        terms = (self.preferred or self.fit).terms.name
        return {"summary": " ".join(self.sentences), "details": list(self.details), "preferred_terms": terms}

    @property
    def settled(self) -> bool:
        """Whether the bank coefficients are identified with the given and the preferred terms, and agree."""
        certain = not any(_bank_doubts(fit) for fit in (self.fit, self.preferred) if fit)
        return bool(bank_names(self.fit)) and certain and not self.fit.implausible and not self._apart()

    def _hull(self) -> str:
        hull = [term.name for term in self.fit.terms.terms if not term.from_bank]
        known = sum(self.fit.verdicts[name].status == IDENTIFIED for name in hull)
        first = f"The tests identify {known} of {len(hull)} hull coefficients"
        parts = [f"{one.half:.2g} {FORCES[one.force].unit} in {one.force}" for one in self.fit.predictiveness]
        return first + f"; the median 95 % interval of left-out motions is +-{listed(parts)}" * bool(parts) + "."

    def _bank(self) -> str:
        if not bank_names(self.fit):
            return f"The terms {self.fit.terms.name} have no bank."
        if self.fit.implausible:
            return f"Do not trust the bank's coefficients: {self.fit.implausible[0]}"
        values = _bank_values(self.fit)
        if self.settled:
            return f"The tests identify the bank: {values}."
        if doubts := _bank_doubts(self.fit):
            return f"The tests do not determine the bank: {values}; {listed(doubts)}."
        other = self.preferred.terms.name if self.preferred else ""
        return f"The tests determine the bank with the terms {self.fit.terms.name} alone, not with {other}: {values}."

    def _other_terms(self) -> str:
        if self.preferred is None:
            return ""
        pairs = [(f, self.preferred.left_out[f].rmse, self.fit.left_out[f].rmse) for f in _bank_forces(self.fit)]
        errors = listed([f"{other:.3g} instead of {own:.3g} {FORCES[f].unit} in {f}" for f, other, own in pairs])
        first = f"The terms {self.preferred.terms.name} predict left-out motions better (rms error {errors})"
        apart = self._apart()
        differ = f"{listed(apart)} {'differ' if len(apart) > 1 else 'differs'} from the terms above" * bool(apart)
        doubts = filter(None, (listed(_bank_doubts(self.preferred)), differ))
        return "; ".join((f"{first}: {_bank_values(self.preferred)}", *doubts)) + "."

    def _limits(self) -> str:
        """Return the campaign errors that move each bank coefficient by its standard error."""
        limits = {name: self.fit.verdicts[name].limits[:2] for name in bank_names(self.fit)}
        parts = [f"{name} is off by a standard error with {' or '.join(most)}" for name, most in limits.items() if most]
        sentence = "; ".join(parts) or "No usual error of a campaign moves the bank's coefficients by a standard error"
        return f"{sentence}. No test shows a gain that all runs share."

    def _apart(self) -> list[str]:
        """Return the coefficients whose intervals with the two tables of terms do not overlap."""
        if self.preferred is None:
            return []
        pairs = ((n, self.fit.intervals[n], self.preferred.intervals[n]) for n in bank_names(self.fit))
        return [name for name, one, other in pairs if one[1] < other[0] or other[1] < one[0]]

    def _next_runs(self) -> str:
        if self.settled:
            return "No more runs are needed to identify the bank force; narrows plan chooses runs to narrow it further."
        what = listed(missing_runs(self.fit)) or "motions other than these"
        return f"Run next: {what}; narrows plan --after chooses them."


def summarise_bank(fit: Fit) -> BankSummary:
    comparable = isinstance(fit.tests, CaptiveTests) and bank_names(fit)
    return BankSummary(fit, preferred_fit(fit) if comparable else None)


def bank_names(fit: Fit) -> list[str]:
    return [term.name for term in fit.terms.terms if term.from_bank]


def preferred_fit(fit: Fit) -> Fit | None:
    """Return the fit with the hull terms of least left-out error and the same additions; None if this is best."""
    base, plus, additions = fit.terms.name.partition("+")
    known = base in BARE and fit.terms == table_named(fit.terms.name)
    best, least = None, 0.98  # Others must be better by 2 %
    for name in [name for name in BARE if known and name != base]:
        table, balance = table_named(f"{name}{plus}{additions}"), fit.normal_equations.balance
        try:
            other = identify(fit.tests, table, balance=balance, errors=fit.errors, pass_over="rudder")
        except InputError:
            continue
        # Errors on left-out tests over those of the fit, as a geometric mean over the forces of the bank.
        rmse = np.array([[one.left_out[force].rmse for force in _bank_forces(fit)] for one in (other, fit)])
        ratios = np.maximum(rmse[0] / np.maximum(rmse[1], 1e-300), 1e-300)  # 1e-300: errors may be 0
        ratio = float(np.exp(np.mean(np.log(ratios))))
        if ratio < least:
            best, least = other, ratio
    return best


def missing_runs(fit: Fit) -> list[str]:
    """Name the kinds of runs that separate bank and hull and are missing in the tests."""
    motions = fit.motions
    # Straight runs further off than a tenth of the canal's half width contain information on a bank.
    off = motions.steady & (motions.features["reach"] > 0.1 * fit.tests.configuration.canal.width / 2)
    fastest = f"{max(round(float(motions.features['speed'][group].mean()), 2) for group in motions.by_speed):g} m/s"
    missing = []
    if len(set(numbered(motions.features["side"])[off].tolist())) < 2:
        missing.append(f"straight runs off the centreline to both sides at {fastest}")
    period = np.where(motions.steady, -1, numbered(motions.features["period"]))
    if max(len(set(period[group].tolist()) - {-1}) for group in motions.by_speed) < 2:
        missing.append(f"harmonic yaw at two periods or more at {fastest}")
    return missing


def _bank_forces(fit: Fit) -> list[str]:
    return [force for force, part in fit.terms.forces.items() if any(term.from_bank for term in part)]


def listed(parts: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def _bank_values(fit: Fit) -> str:
    parts = []
    for name in bank_names(fit):
        value, std, ends = fit.coefficients[name], fit.std[name], fit.intervals[name]
        known = fit.verdicts[name].determined
        parts.append(f"{name} {readable(value, std)} ({interval(ends, std)})" if known else f"{name} unknown")
    return listed(parts)


def _bank_doubts(fit: Fit) -> list[str]:
    """Return why bank coefficients are not identified; empty if all are."""
    verdicts = {name: fit.verdicts[name] for name in bank_names(fit)}
    return [f"{name} is {verdict.words}" for name, verdict in verdicts.items() if verdict.status != IDENTIFIED]
