"""What each verdict is drawn from: the columns over all rows, at each speed, and without each cluster of rows."""

from collections.abc import Collection, Mapping

from narrows.identification.identifiability.diagnostics import Diagnosis, all_forces, determined
from narrows.identification.identifiability.verdict import WEAK, Evidence, Verdict, judge
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.identification.uncertainty.clusters import Clusters
from narrows.terms.term import Term, TermTable


def verdicts(
    terms: TermTable,
    equations: NormalEquations,
    clusters: Clusters,
    by_speed: Mapping[float, Mapping[str, Diagnosis]],
    intervals: Mapping[str, tuple[float, float]],
    at_bound: Collection[str],
) -> dict[str, Verdict]:
    """Say how far each coefficient of a fit can be trusted (ours).

    Parameters
    ----------
    terms : TermTable
        The terms.
    equations : NormalEquations
        The sums.
    clusters : Clusters
        Rows that are left out together.
    by_speed : mapping of float [m/s] to mapping of str to Diagnosis
        Of each force's columns at each speed.
    intervals : mapping of str to pair of float
        95 % confidence interval of each coefficient.
    at_bound : collection of str
        Coefficients that the fit pressed against a bound.
    """
    overall = all_forces(equations, equations.total, terms)
    rests = [all_forces(equations, rest, terms) for rest in clusters.without]

    def verdict(force: str, term: Term) -> Verdict:
        known = determined(term.name, terms, overall)
        pairs = zip(clusters.labels, rests, strict=True)
        pinned = tuple(label for label, rest in pairs if not determined(term.name, terms, rest)) if known else ()
        speeds = {speed: by_force[force] for speed, by_force in by_speed.items()}
        evidence = Evidence(overall[force], speeds, intervals[term.name], term.name in at_bound, pinned)
        return _with_ties(judge(term, evidence), known)

    return {term.name: verdict(force, term) for force, part in terms.forces.items() for term in part}


def _with_ties(verdict: Verdict, known: bool) -> Verdict:
    """A coefficient that its own force leaves open may still be known through one that it is tied to."""
    if verdict.determined or not known:
        return verdict
    return Verdict(WEAK, (f"{verdict.reasons[0]}, so that only its tie determines it",))
