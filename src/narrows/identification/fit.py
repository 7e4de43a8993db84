"""``identify``: tests in, a fit with its standard errors, scores, diagnostics and shares out."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from narrows.captive.split import random_split
from narrows.captive.tests import CaptiveTests, Tests
from narrows.errors import InputError, did_you_mean
from narrows.identification import diagnostics, evidence, shapley
from narrows.identification.bootstrap import Bootstrap, resampled
from narrows.identification.diagnostics import Diagnosis
from narrows.identification.influence import Influence, influence
from narrows.identification.interval import bounded_interval
from narrows.identification.moments import Moments, accumulate, design_rows
from narrows.identification.problem import Problem, reduced
from narrows.identification.profile import Profile, profile
from narrows.identification.robust import Robust, assess
from narrows.identification.score import (
    Score,
    left_out_by_speed,
    left_out_coefficients,
    left_out_score,
    score,
)
from narrows.identification.solve import Kkt, solve
from narrows.identification.tradeoff import Tradeoff, tradeoffs
from narrows.identification.uncertainty import Clusters, clustered, pieces_for
from narrows.identification.verdict import Verdict
from narrows.model.model import DataRange, Model
from narrows.terms.tables import PAPER, table_named
from narrows.terms.term import TermTable

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
    robust : Robust
        Estimates that do not know the bounds, and their cluster-robust standard errors.
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
    problem : Problem
        What was solved.
    moments : Moments
        Sums over the rows.
    clusters : Clusters
        What the standard errors take as independent.
    data_range : DataRange
        What the rows cover.
    """

    tests: Tests
    terms: TermTable
    coefficients: Mapping[str, float]
    robust: Robust
    scores: Mapping[str, Score]
    left_out: Mapping[str, Score]
    split: str
    kkt: Kkt
    at_bound: tuple[str, ...]
    problem: Problem
    moments: Moments
    clusters: Clusters
    data_range: DataRange

    @property
    def model(self) -> Model:
        """The fit as a model, ready to save or to simulate."""
        return Model(
            self.tests.configuration,
            self.terms,
            self.coefficients,
            self.covariance,
            self.data_range,
            self.tests.source,
        )

    @property
    def covariance(self) -> np.ndarray:
        """Cluster-robust covariance (n, n) in the order of ``terms.names``; zero where a bound is rejected and held."""
        return self.robust.covariance

    @cached_property
    def std(self) -> dict[str, float]:
        """Cluster-robust standard error of each coefficient; NaN where it is not identifiable."""
        return {
            name: float(size) if self.determined(name) else float("nan")
            for name, size in zip(self.terms.names, self.robust.std, strict=True)
        }

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % confidence interval of each coefficient within its bounds; the bounds where it is not identifiable."""
        seen = zip(self.terms.terms, self.robust.values, self.robust.counts, strict=True)
        return {
            term.name: bounded_interval(float(value), self.std[term.name], term.bound, float(count))
            for term, value, count in seen
        }

    @cached_property
    def verdicts(self) -> dict[str, Verdict]:
        """How far each coefficient can be trusted."""
        return evidence.verdicts(self)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader of the tests had to say, and what was taken as independent."""
        few = [name for name, own in zip(self.terms.names, self.robust.few, strict=True) if own]
        said = (f"Too few of these tests tell of {', '.join(few)}: their errors are clustered by stretches of tests.",)
        depths = ("Terms that do not ask for the depth have one coefficient for all conditions of these tests.",)
        return (*self.tests.notes, self.clusters.sentence, *said * bool(few), *depths * self._several)

    @property
    def _several(self) -> bool:
        return isinstance(self.tests, CaptiveTests) and len(set(self.tests.conditions)) > 1

    @cached_property
    def tradeoffs(self) -> tuple[Tradeoff, ...]:
        """Pairs of coefficients that stand in for one another, the closest first."""
        return tradeoffs(self.problem, self.moments.total)

    @cached_property
    def left_out_speeds(self) -> dict[str, Score]:
        """Scores at each speed of a fit to the other speeds; empty where there is one speed."""
        return left_out_by_speed(self.problem, self.moments)

    @cached_property
    def influence(self) -> Influence:
        """What each test tells of each coefficient, and how far it moves it."""
        return influence(self.problem, self.moments)

    def bootstrap(self, resamples: int = 10_000, kind: str = "tests", seed: int = 0) -> Bootstrap:
        """Fit resamples of the tests, each under the constraints.

        Parameters
        ----------
        resamples : int
            How many.
        kind : str
            ``tests``: whole tests are drawn with replacement, stretches of them where there are fewer than ten;
            ``scores``: the tests stay, each one's pull on the fit is multiplied by a random number.
        seed : int
            Of the draws.

        Raises
        ------
        InputError
            Where the kind is unknown, or there are fewer than 2 resamples.
        """
        return resampled(self.problem, self.clusters, self.robust, resamples, kind, seed)

    def profile(self, name: str) -> Profile | None:
        """Profile the likelihood of a coefficient under the constraints; None where it is not identifiable.

        Parameters
        ----------
        name : str
            The coefficient.

        Raises
        ------
        InputError
            Where there is no such coefficient.
        """
        if name not in self.terms.names:
            raise InputError(f"unknown coefficient {name!r}{did_you_mean(name, self.terms.names)}")
        return profile(self.problem, self.moments.total, self.robust, name) if self.determined(name) else None

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
        return shapley.shares(kind, self.moments, self.terms, self.coefficients, lambda: self.deviations)

    def summary(self) -> dict[str, Any]:
        """Everything as plain numbers and words: what ``identify --json`` prints."""
        from narrows.identification.summary import as_json

        return as_json(self)

    def determined(self, name: str, among: Mapping[str, Diagnosis] | None = None) -> bool:
        """Whether the data determine a coefficient, through its own force or through one that it is tied to.

        Parameters
        ----------
        name : str
            A coefficient.
        among : mapping of str to Diagnosis, optional
            Of each force; over all rows unless given.
        """
        tied = {name, *(other for tie in self.terms.ties if name in tie for other in tie)}
        found = (among or self._overall).values()
        return any(np.isfinite(d.vif[own]) for d in found for own in tied if own in d.names)

    @cached_property
    def _overall(self) -> dict[str, Diagnosis]:
        return diagnostics.all_forces(self.moments, self.moments.total, self.terms)

    @cached_property
    def _by_speed(self) -> dict[float, dict[str, Diagnosis]]:
        return diagnostics.by_speed(self.moments, self.terms)

    @cached_property
    def deviations(self) -> dict[str, float]:
        """Mean absolute deviation of each column, by one more pass over the rows."""
        rows = self.moments.total[-1, -1]
        mean = self.moments.total[:, -1] / rows
        sums = sum(np.abs(d - mean[:, None]).sum(axis=1) for _, d in design_rows(self.tests, self.terms))
        return {name: float(np.asarray(sums)[self.moments.columns[name]] / rows) for name in self.terms.names}


def identify(
    tests: Tests, terms: TermTable | str = PAPER, weights: str = "paper", split: str = "test", seed: int = 0
) -> Fit:
    """Fit a table of terms to captive tests: the paper's joint constrained problem, solved exactly.

    One pass over the rows leaves sums of products; the fit, its standard errors (cluster jackknife) and its
    left-out scores all come from these.

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        Of one condition.
    terms : TermTable or str
        The terms, their bounds and ties, or the name of a table that comes with the package.
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
        With ``coefficients``, ``std``, ``intervals``, ``verdicts``, ``scores``, ``left_out`` and ``model``.

    Raises
    ------
    InputError
        Where an option is unknown or the tests are of several conditions.
    """
    if split not in SPLITS:
        raise InputError(f"split {split!r} is unknown; choose {' or '.join(SPLITS)}")
    terms = table_named(terms) if isinstance(terms, str) else terms
    check_one_condition(tests, terms)
    fitted, checked = random_split(tests, seed=seed) if split == "random" else (tests, None)
    moments, data_range = accumulate(fitted, terms, pieces_for(len(tests.names)))
    problem = reduced(moments, terms, weights)
    solution = solve(*problem.normal(moments.total), problem.lower, problem.upper)
    values = dict(zip(terms.names, problem.coefficients(solution.z).tolist(), strict=True))
    clusters = clustered(moments)
    if checked is None:
        without = left_out_coefficients(problem, clusters.without)
        left_out = left_out_score(moments, terms, clusters.sums, without)
    else:
        rest, _ = accumulate(checked, terms)
        left_out = score(rest, rest.total, terms, values)
    return Fit(
        tests=fitted,
        terms=terms,
        coefficients=values,
        robust=assess(problem, moments),
        scores=score(moments, moments.total, terms, values),
        left_out=left_out,
        split=split,
        kkt=solution.kkt,
        at_bound=_at_bound(problem, solution.at_bound),
        problem=problem,
        moments=moments,
        clusters=clusters,
        data_range=data_range,
    )


def _at_bound(problem: Problem, at_bound: np.ndarray) -> tuple[str, ...]:
    return tuple(name for name in problem.terms.names if at_bound[problem.slot[name]])


def check_one_condition(tests: Tests, terms: TermTable) -> None:
    """Raise where tests at several depths are to share coefficients that do not know the depth (ours).

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        The rows.
    terms : TermTable
        The terms.

    Raises
    ------
    InputError
        Names the conditions.
    """
    if isinstance(tests, CaptiveTests) and len(set(tests.conditions)) > 1 and "depth" not in terms.inputs:
        labels = ", ".join(dict.fromkeys(tests.conditions))
        raise InputError(
            f"the tests are of several conditions ({labels}), which no one model fits unless its terms ask for the "
            "depth; identify each of tests.by_condition()"
        )
