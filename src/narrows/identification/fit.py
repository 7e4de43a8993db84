"""``identify``: tests in, a fit with its standard errors, scores, diagnostics and shares out."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from narrows.captive.split import random_split
from narrows.captive.tests import CaptiveTests, Tests
from narrows.errors import InputError
from narrows.identification import diagnostics, shapley
from narrows.identification.diagnostics import Diagnosis
from narrows.identification.moments import Moments, accumulate, design_rows
from narrows.identification.problem import Problem, reduced
from narrows.identification.score import Score, left_out_coefficients, left_out_score, score
from narrows.identification.solve import Kkt, solve
from narrows.identification.uncertainty import Clusters, clustered, interval_factor, jackknife, pieces_for
from narrows.identification.verdict import WEAK, Evidence, Verdict, judge
from narrows.model import Envelope, Model
from narrows.terms import PAPER, Term, TermTable

SPLITS = ("test", "random")


@dataclass(frozen=True)
class Fit:
    """A fitted table of terms and everything that is known of it.

    Parameters
    ----------
    tests : CaptiveTests, StreamedTests or a part of them
        What it was fitted on.
    terms : TermTable
        The terms.
    coefficients : mapping of str to float
        In each term's SI unit.
    covariance : array (n, n)
        Of the coefficients, in the order of ``terms.names``.
    scores : mapping of str to Score
        R2 and RMSE of each force on the rows of the fit.
    left_out : mapping of str to Score
        The same on rows left out, by test or at random.
    split : str
        ``test`` or ``random``.
    kkt : Kkt
        Check of optimality.
    at_bound : tuple of str
        Coefficients at a bound.
    moments : Moments
        Sums over the rows.
    clusters : Clusters
        What the standard errors take as independent.
    without : array (clusters, n)
        Coefficients without each cluster.
    envelope : Envelope
        What the rows cover.
    """

    tests: Tests
    terms: TermTable
    coefficients: Mapping[str, float]
    covariance: np.ndarray
    scores: Mapping[str, Score]
    left_out: Mapping[str, Score]
    split: str
    kkt: Kkt
    at_bound: tuple[str, ...]
    moments: Moments
    clusters: Clusters
    without: np.ndarray
    envelope: Envelope

    @property
    def model(self) -> Model:
        """The fit as a model, ready to save or to simulate."""
        return Model(
            self.tests.setting,
            self.terms,
            self.coefficients,
            self.covariance,
            self.envelope,
            self.tests.source,
        )

    @cached_property
    def std(self) -> dict[str, float]:
        """Standard error of each coefficient; NaN where it is not identifiable."""
        sizes = np.sqrt(np.diag(self.covariance))
        return {
            name: float(size) if self._determined(name) else float("nan")
            for name, size in zip(self.terms.names, sizes, strict=True)
        }

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % confidence interval of each coefficient, cut at its bounds; the bounds where it is not identifiable."""
        reach = interval_factor(len(self.clusters.labels))
        return {term.name: self._interval(term.name, term.bound, reach) for term in self.terms.terms}

    @cached_property
    def verdicts(self) -> dict[str, Verdict]:
        """How far each coefficient can be trusted."""
        return {term.name: self._verdict(force, term) for force, own in self.terms.forces.items() for term in own}

    def diagnostics(self) -> dict[str, Diagnosis]:
        """Rank, condition, VIF and correlations of each force's columns over all rows."""
        return self._overall

    def by_test(self) -> dict[str, dict[str, Diagnosis]]:
        """The same within each test: test -> force -> diagnosis."""
        return diagnostics.by_test(self.moments, self.terms)

    def by_speed(self) -> dict[float, dict[str, Diagnosis]]:
        """The same at each speed [m/s]: speed -> force -> diagnosis."""
        return self._by_speed

    def shapley(self, kind: str = "mse") -> dict[str, dict[str, float]]:
        """Shapley share of each term: force -> coefficient -> share, sizes adding up to 1.

        Parameters
        ----------
        kind : str
            ``mse``, ``mean_abs`` or ``lmg``.

        Raises
        ------
        InputError
            Where the kind is none of these.
        """
        if kind not in shapley.KINDS:
            raise InputError(f"Shapley kind {kind!r} is unknown; choose {', '.join(shapley.KINDS)}")
        return {force: self._shares(kind, force) for force, own in self.terms.forces.items() if own}

    def summary(self) -> dict[str, Any]:
        """Everything as plain numbers and words: what ``identify --json`` prints."""
        from narrows.identification.summary import as_json

        return as_json(self)

    @cached_property
    def _overall(self) -> dict[str, Diagnosis]:
        total = self.moments.total
        return {
            force: diagnostics.diagnose(self.moments, total, own) for force, own in self.terms.forces.items() if own
        }

    @cached_property
    def _by_speed(self) -> dict[float, dict[str, Diagnosis]]:
        return diagnostics.by_speed(self.moments, self.terms)

    @cached_property
    def _without_cluster(self) -> list[dict[str, Diagnosis]]:
        forces = {force: own for force, own in self.terms.forces.items() if own}
        return [
            {force: diagnostics.diagnose(self.moments, rest, own) for force, own in forces.items()}
            for rest in self.clusters.without
        ]

    @cached_property
    def _deviations(self) -> dict[str, float]:
        """Mean absolute deviation of each column, by one more pass over the rows."""
        rows = self.moments.total[-1, -1]
        mean = self.moments.total[:, -1] / rows
        sums = sum(np.abs(d - mean[:, None]).sum(axis=1) for _, d in design_rows(self.tests, self.terms))
        return {name: float(np.asarray(sums)[self.moments.columns[name]] / rows) for name in self.terms.names}

    def _shares(self, kind: str, force: str) -> dict[str, float]:
        names = [term.name for term in self.terms.forces[force]]
        values = np.array([self.coefficients[name] for name in names])
        total = self.moments.total
        gram, cross = self.moments.pick(total, names), self.moments.pick(total, names, [force])[:, 0]
        if kind == "mse":
            shares = shapley.mse_shares(gram, cross, values)
        elif kind == "lmg":
            shares = shapley.lmg_shares(gram, cross)
        else:
            shares = shapley.mean_abs_shares(np.array([self._deviations[name] for name in names]), values)
        return dict(zip(names, shares.tolist(), strict=True))

    def _determined(self, name: str, among: dict[str, Diagnosis] | None = None) -> bool:
        """Whether the data determine a coefficient, through its own force or through one it is tied to."""
        tied = {name, *(other for tie in self.terms.ties if name in tie for other in tie)}
        found = (among or self._overall).values()
        return any(np.isfinite(d.vif[own]) for d in found for own in tied if own in d.names)

    def _interval(self, name: str, bound: tuple[float, float], reach: float) -> tuple[float, float]:
        value, half = self.coefficients[name], reach * self.std[name]
        if not np.isfinite(half):
            return bound
        return max(bound[0], value - half), min(bound[1], value + half)

    def _verdict(self, force: str, term: Term) -> Verdict:
        own = judge(term, self._evidence(force, term.name))
        if own.identifiable or not self._determined(term.name):
            return own
        return Verdict(WEAK, (f"{own.reasons[0]}, so that only its tie determines it",))

    def _evidence(self, force: str, name: str) -> Evidence:
        pinned = [
            label
            for label, without in zip(self.clusters.labels, self._without_cluster, strict=True)
            if not self._determined(name, without)
        ]
        return Evidence(
            self._overall[force],
            {speed: found[force] for speed, found in self._by_speed.items()},
            self.intervals[name],
            name in self.at_bound,
            tuple(pinned) if self._determined(name) else (),
        )


def identify(tests: Tests, terms: TermTable = PAPER, weights: str = "paper", split: str = "test", seed: int = 0) -> Fit:
    """Fit a table of terms to captive tests: the paper's joint constrained problem, solved exactly.

    One pass over the rows leaves sums of products; the fit, its standard errors (cluster jackknife) and its
    left-out scores all come from these.

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        Of one condition.
    terms : TermTable
        The terms, their bounds and ties.
    weights : str
        ``paper``: the plain sum of squared errors of X, Y and N; ``variance``: each over its force's variance.
    split : str
        ``test``: fit on every row, check on each test left out in turn; ``random``: fit on a seeded random
        80 % of the rows, check on the rest, as the paper does.
    seed : int
        Of the random split.

    Returns
    -------
    Fit
        With ``coefficients``, ``std``, ``verdicts``, ``scores``, ``left_out`` and ``model``.

    Raises
    ------
    InputError
        Where an option is unknown or the tests are of several conditions.
    """
    if split not in SPLITS:
        raise InputError(f"split {split!r} is unknown; choose {' or '.join(SPLITS)}")
    _check_one_condition(tests)
    fitted, checked = random_split(tests, seed=seed) if split == "random" else (tests, None)
    moments, envelope = accumulate(fitted, terms, pieces_for(len(tests.names)))
    problem = reduced(moments, terms, weights)
    solution = solve(*problem.normal(moments.total), problem.lower, problem.upper)
    best = problem.coefficients(solution.z)
    clusters = clustered(moments)
    without = left_out_coefficients(problem, clusters.without)
    values = dict(zip(terms.names, best.tolist(), strict=True))
    if checked is None:
        left_out = left_out_score(moments, terms, clusters.sums, without)
    else:
        rest, _ = accumulate(checked, terms)
        left_out = score(rest, rest.total, terms, values)
    return Fit(
        tests=fitted,
        terms=terms,
        coefficients=values,
        covariance=jackknife(best, without),
        scores=score(moments, moments.total, terms, values),
        left_out=left_out,
        split=split,
        kkt=solution.kkt,
        at_bound=_at_bound(problem, solution.at_bound),
        moments=moments,
        clusters=clusters,
        without=without,
        envelope=envelope,
    )


def _at_bound(problem: Problem, at_bound: np.ndarray) -> tuple[str, ...]:
    return tuple(name for name in problem.terms.names if at_bound[problem.slot[name]])


def _check_one_condition(tests: Tests) -> None:
    if isinstance(tests, CaptiveTests) and len(set(tests.conditions)) > 1:
        labels = ", ".join(dict.fromkeys(tests.conditions))
        raise InputError(
            f"the tests are of several conditions ({labels}), which no one model fits; "
            "identify each of tests.by_condition()"
        )
