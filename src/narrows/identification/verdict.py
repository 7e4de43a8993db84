"""How far each coefficient can be trusted, in one word and one sentence, from thresholds stated here."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from narrows.identification.diagnostics import INVOLVED, Diagnosis
from narrows.terms import Term

VIF_LIMIT = 10.0
"""Over all rows: beyond this the other columns leave a coefficient under a tenth of its own information."""
VIF_LIMIT_ONE_SPEED = 30.0
"""Within every single speed: beyond this only mixing speeds separates a coefficient from the others."""

NOT_EXCITED, NOT_IDENTIFIABLE = "not excited", "not identifiable"
AT_BOUND, WEAK, IDENTIFIED = "at its bound", "weakly identified", "identified"


@dataclass(frozen=True)
class Verdict:
    """What can be said of a coefficient.

    Parameters
    ----------
    status : str
        ``identified``, ``weakly identified``, ``at its bound``, ``not identifiable`` or ``not excited``.
    reasons : tuple of str
        Why, each a clause.
    """

    status: str
    reasons: tuple[str, ...] = ()

    @property
    def identifiable(self) -> bool:
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
    return Verdict(WEAK, reasons) if reasons else Verdict(IDENTIFIED)


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
    """Whether the coefficient is lost among the others at each speed where it is excited at all."""
    seen = [d for d in speeds.values() if name not in d.empty]
    inflation = [d.vif[name] for d in seen]
    if len(speeds) < 2 or not seen or not min(inflation) > VIF_LIMIT_ONE_SPEED:
        return ""
    partner, alignment = seen[int(np.argmax(inflation))].partner(name)
    return (
        f"only mixing speeds separates it: at each single speed its VIF is {min(inflation):.0f} or more "
        f"(its column aligns {alignment:+.4f} with {partner}'s)"
    )


def _combination(overall: Diagnosis, direction: np.ndarray) -> str:
    """Name the coefficients of a direction without data; what is known is orthogonal to it."""
    involved = [name for name, part in zip(overall.names, direction, strict=True) if abs(part) > INVOLVED]
    return f"the tests determine {' and '.join(involved)} only in combination, their columns being dependent"
