"""How far each coefficient can be trusted, in one word and one sentence, from thresholds stated here."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from narrows.identification.identifiability.diagnosis import INVOLVED, Diagnosis
from narrows.terms.term import Term

VIF_LIMIT = 10.0
"""Over all rows: beyond this the other columns leave a coefficient under a tenth of its own information."""
CONFOUNDED_VIF = 30.0
"""Over all rows, or within every single speed: beyond this a small error of the model's form, shared by the columns
that align, lands on the coefficient magnified; no standard error knows that."""

NOT_EXCITED, NOT_IDENTIFIABLE = "not excited", "not identifiable"
AT_BOUND, CONFOUNDED, WEAK, IDENTIFIED = "at its bound", "confounded", "weakly identified", "identified"


@dataclass(frozen=True)
class Verdict:
    """What can be said of a coefficient.

    Parameters
    ----------
    status : str
        ``identified``, ``weakly identified``, ``confounded``, ``at its bound``, ``not identifiable`` or
        ``not excited``.
    reasons : tuple of str
        Why, each a clause.
    partners : tuple of str
        With which coefficients it is confounded.
    """

    status: str
    reasons: tuple[str, ...] = ()
    partners: tuple[str, ...] = ()

    @property
    def determined(self) -> bool:
        """Whether the data determine the coefficient at all."""
        return self.status not in (NOT_EXCITED, NOT_IDENTIFIABLE)

    def sentence(self, name: str) -> str:
        """Say it of a coefficient.

        Parameters
        ----------
        name : str
            The coefficient.
        """
        word = "not identifiable" if self.status == NOT_EXCITED else self.status
        if self.partners:
            word += f" with {' and '.join(self.partners)}"
        return f"{name} is {word}" + (f": {'; '.join(self.reasons)}." if self.reasons else ".")


@dataclass(frozen=True)
class Evidence:
    """What a verdict is drawn from.

    Parameters
    ----------
    overall : Diagnosis
        Of the force's columns over all rows.
    speeds : mapping of float [m/s] to Diagnosis
        The same at each single speed.
    interval : pair of float
        95 % confidence interval, in the coefficient's unit.
    at_bound : bool
        Whether the fit pressed it against its bound.
    pinned_by : tuple of str
        Clusters of rows without which it would not be identifiable.
    """

    overall: Diagnosis
    speeds: Mapping[float, Diagnosis]
    interval: tuple[float, float]
    at_bound: bool
    pinned_by: tuple[str, ...]


def judge(term: Term, evidence: Evidence) -> Verdict:
    """Draw the verdict on one coefficient.

    Parameters
    ----------
    term : Term
        The coefficient's term.
    evidence : Evidence
        What is known of it.
    """
    overall = evidence.overall
    if term.name in overall.empty:
        what = term.inputs[0] if len(term.inputs) == 1 else "its regressor"
        return Verdict(NOT_EXCITED, (f"{what} is 0 in every test",))
    for direction in overall.missing:
        if abs(direction[overall.names.index(term.name)]) > INVOLVED:
            return Verdict(NOT_IDENTIFIABLE, (_combination(overall, direction),))
    reasons = tuple(reason for reason in _doubts(term, evidence) if reason)
    if evidence.at_bound:
        return Verdict(AT_BOUND, ("the data alone would put it beyond", *reasons))
    if partners := _confounders(term.name, evidence):
        return Verdict(CONFOUNDED, reasons, partners)
    return Verdict(WEAK, reasons) if reasons else Verdict(IDENTIFIED)


def _confounders(name: str, evidence: Evidence) -> tuple[str, ...]:
    """The coefficients that take a coefficient's place, over all rows or at each single speed."""
    if evidence.overall.vif[name] > CONFOUNDED_VIF:
        return evidence.overall.partners(name)
    worst = _worst_speed(name, evidence.speeds)
    return worst.partners(name) if worst else ()


def _worst_speed(name: str, speeds: Mapping[float, Diagnosis]) -> Diagnosis | None:
    """The speed with the largest inflation, if at each one the coefficient is lost among the others."""
    seen = [d for d in speeds.values() if name not in d.empty]
    inflation = [d.vif[name] for d in seen]
    lost = len(speeds) > 1 and seen and min(inflation) > CONFOUNDED_VIF
    return seen[int(np.argmax(inflation))] if lost else None


def _doubts(term: Term, evidence: Evidence) -> tuple[str, ...]:
    return (
        _zero_inside(evidence),
        _pinned(evidence),
        _inflated(term.name, evidence.overall),
        _one_speed(term.name, evidence.speeds),
    )


def _zero_inside(evidence: Evidence) -> str:
    low, high = evidence.interval
    inside = low <= 0 <= high and not evidence.at_bound
    return f"its 95 % interval {low:.3g} to {high:.3g} holds 0" if inside else ""


def _pinned(evidence: Evidence) -> str:
    return f"it rests on {', '.join(evidence.pinned_by)} alone" if evidence.pinned_by else ""


def _inflated(name: str, overall: Diagnosis) -> str:
    vif = overall.vif[name]
    if not vif > VIF_LIMIT:
        return ""
    partner, alignment = overall.partner(name)
    return f"VIF {vif:.0f} over all rows (its column aligns {alignment:+.3f} with {partner}'s)"


def _one_speed(name: str, speeds: Mapping[float, Diagnosis]) -> str:
    worst = _worst_speed(name, speeds)
    if not worst:
        return ""
    least = min(d.vif[name] for d in speeds.values() if name not in d.empty)
    partner, alignment = worst.partner(name)
    return (
        f"only mixing speeds separates it: at each single speed its VIF is {least:.0f} or more "
        f"(its column aligns {alignment:+.4f} with {partner}'s)"
    )


def _combination(overall: Diagnosis, direction: np.ndarray) -> str:
    """Name the coefficients of a direction without data; what is known is orthogonal to it."""
    involved = [name for name, part in zip(overall.names, direction, strict=True) if abs(part) > INVOLVED]
    return f"the tests determine {' and '.join(involved)} only in combination, their columns being dependent"
