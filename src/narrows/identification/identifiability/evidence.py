"""What each verdict is drawn from: the columns over all rows, at each speed, and without each cluster of rows."""

from collections.abc import Collection, Mapping

from narrows.identification.identifiability.diagnostics import Diagnostics
from narrows.identification.identifiability.verdict import WEAK, Evidence, Verdict, judge
from narrows.identification.uncertainty.clusters import Clusters
from narrows.terms.term import Term


def verdicts(
    diagnostics: Diagnostics,
    clusters: Clusters,
    intervals: Mapping[str, tuple[float, float]],
    at_bound: Collection[str],
) -> dict[str, Verdict]:
    """Say how far each coefficient of a fit can be trusted (ours).

    Parameters
    ----------
    diagnostics : Diagnostics
        Of the columns.
    clusters : Clusters
        Rows that are left out together.
    intervals : mapping of str to pair of float
        95 % confidence interval of each coefficient.
    at_bound : collection of str
        Coefficients that the fit pressed against a bound.
    """
    rests = {label: diagnostics.over(rest) for label, rest in zip(clusters.labels, clusters.without, strict=True)}

    def verdict(force: str, term: Term) -> Verdict:
        known = diagnostics.determined(term.name)
        pinned = [label for label, rest in rests.items() if known and not diagnostics.determined(term.name, rest)]
        speeds = {speed: by_force[force] for speed, by_force in diagnostics.by_speed.items()}
        overall, pressed = diagnostics.overall[force], term.name in at_bound
        evidence = Evidence(overall, speeds, intervals[term.name], pressed, tuple(pinned))
        return _with_ties(judge(term, evidence), known)

    return {term.name: verdict(force, term) for force, part in diagnostics.terms.forces.items() for term in part}


def _with_ties(verdict: Verdict, known: bool) -> Verdict:
    """A coefficient that its own force leaves open may still be known through one that it is tied to."""
    if verdict.determined or not known:
        return verdict
    return Verdict(WEAK, (f"{verdict.reasons[0]}, so that only its tie determines it",))
