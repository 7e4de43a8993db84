"""What each verdict is drawn from, gathered from a fit."""

from typing import TYPE_CHECKING

from narrows.identification import diagnostics
from narrows.identification.diagnostics import Diagnosis
from narrows.identification.verdict import WEAK, Evidence, Verdict, judge

if TYPE_CHECKING:
    from narrows.identification.fit import Fit
    from narrows.terms.term import Term


def verdicts(fit: "Fit") -> dict[str, Verdict]:
    """Say how far each coefficient of a fit can be trusted (ours).

    Parameters
    ----------
    fit : Fit
        The fit.
    """
    rests = [diagnostics.all_forces(fit.moments, rest, fit.terms) for rest in fit.clusters.without]
    return {term.name: _verdict(fit, rests, force, term) for force, own in fit.terms.forces.items() for term in own}


def _verdict(fit: "Fit", rests: list[dict[str, Diagnosis]], force: str, term: "Term") -> Verdict:
    own = judge(term, _evidence(fit, rests, force, term.name))
    if own.identifiable or not fit.determined(term.name):
        return own
    return Verdict(WEAK, (f"{own.reasons[0]}, so that only its tie determines it",))


def _evidence(fit: "Fit", rests: list[dict[str, Diagnosis]], force: str, name: str) -> Evidence:
    pairs = zip(fit.clusters.labels, rests, strict=True)
    known = fit.determined(name)
    pinned = tuple(label for label, rest in pairs if not fit.determined(name, rest)) if known else ()
    return Evidence(
        fit.diagnostics()[force],
        {speed: found[force] for speed, found in fit.by_speed().items()},
        fit.intervals[name],
        name in fit.at_bound,
        pinned,
    )
