"""The constrained fit over and over: whole tests drawn anew, or each test's pull on the fit given a random size."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError
from narrows.identification.regression.batch import solve_many
from narrows.identification.regression.problem import Problem
from narrows.identification.uncertainty.clusters import Clusters
from narrows.identification.uncertainty.interval import LEVEL, bounded_interval
from narrows.identification.uncertainty.unbounded_fit import UnboundedFit, leverage
from narrows.terms.term import TermTable

BOOTSTRAPS = ("tests", "scores")
MIDDLE = (0.158655, 0.841345)
"""Between these a Gaussian holds two standard deviations; the few resamples that miss a kind of test do not count."""
CHUNK = 2048


@dataclass(frozen=True)
class Bootstrap:
    """Coefficients of many resamples of the tests.

    Parameters
    ----------
    terms : TermTable
        The terms.
    samples : array (resamples, n)
        Coefficients of each resample fitted under the constraints, each in its own unit.
    std : array (n,)
        Half of what holds the middle 68 % of the coefficients of resamples fitted without bounds.
    unbounded : UnboundedFit
        Of the tests themselves: the middle of the intervals, and how many clusters count behind each.
    kind : str
        ``tests`` or ``scores``.
    """

    terms: TermTable
    samples: np.ndarray
    std: np.ndarray
    unbounded: UnboundedFit
    kind: str

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the samples, (n, n)."""
        return np.atleast_2d(np.cov(self.samples.T))

    def intervals(self, level: float = LEVEL) -> Mapping[str, tuple[float, float]]:
        """Return a confidence interval for each coefficient, in its unit and within its bounds.

        They rest on the spread of fits that do not know the bounds: percentiles of constrained ones miss the truth
        where a coefficient, or one that it trades against, is near a bound.

        Parameters
        ----------
        level : float [1]
            Of confidence.

        References
        ----------
        Andrews (2000), Inconsistency of the bootstrap when a parameter is on the boundary of the parameter space.
        """
        seen = zip(self.terms.terms, self.unbounded.values, self.std, self.unbounded.counts, strict=True)
        return {
            term.name: bounded_interval(float(value), float(std), term.bound, float(count), level)
            for term, value, std, count in seen
        }


def resampled(
    problem: Problem, clusters: Clusters, unbounded: UnboundedFit, resamples: int, kind: str, seed: int
) -> Bootstrap:
    """Fit resamples of the tests, with the constraints and without.

    ``tests`` draws as many tests as there are, with replacement, and adds up their sums. ``scores`` leaves the tests
    as they are and perturbs their forces: the pull of each test on the fit, as leaving it out shows it, is multiplied
    by a random number that the whole test shares.

    Parameters
    ----------
    problem : Problem
        The joint problem.
    clusters : Clusters
        The tests.
    unbounded : UnboundedFit
        What is known of the coefficients without resampling.
    resamples : int
        How many.
    kind : str
        ``tests`` or ``scores``.
    seed : int
        Of the draws.

    Raises
    ------
    InputError
        Where the kind is neither, or there are fewer than 2 resamples.

    References
    ----------
    MacKinnon, Nielsen, Webb (2023), Fast and reliable jackknife and bootstrap methods for cluster-robust inference.
    """
    if kind not in BOOTSTRAPS:
        raise InputError(f"bootstrap kind {kind!r} is unknown; choose {' or '.join(BOOTSTRAPS)}")
    if resamples < 2 or seed < 0:
        raise InputError(f"{resamples} resamples with seed {seed} give no spread; ask for 1000 or more, seed 0 or more")
    make = _by_tests if kind == "tests" else _by_scores
    bounded, free = make(problem, clusters, resamples, np.random.default_rng(seed))
    low, high = np.quantile(problem.coefficients(free), MIDDLE, axis=0)
    return Bootstrap(problem.terms, problem.coefficients(bounded), (high - low) / 2, unbounded, kind)


def _both(problem: Problem, h: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Solve a stack of problems with the bounds and without."""
    everywhere = np.full(len(problem.scale), np.inf)
    return solve_many(h, g, problem.lower, problem.upper), solve_many(h, g, -everywhere, everywhere)


def _by_tests(
    problem: Problem, clusters: Clusters, resamples: int, draw: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    count = len(clusters.sums)
    times = draw.multinomial(count, np.full(count, 1 / count), size=resamples).astype(float)
    parts = [
        _both(problem, *problem.normal(np.tensordot(times[start : start + CHUNK], clusters.sums, axes=1)))
        for start in range(0, resamples, CHUNK)
    ]
    bounded, free = zip(*parts, strict=True)
    return np.concatenate(bounded), np.concatenate(free)


def _by_scores(
    problem: Problem, clusters: Clusters, resamples: int, draw: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    count, everywhere = len(clusters.sums), np.full(len(problem.scale), np.inf)
    total = clusters.sums.sum(axis=0)
    h, g = problem.normal(np.concatenate([total[None], clusters.without]))
    z = solve_many(h, g, -everywhere, everywhere)
    _, excess = leverage(h, problem.normal(clusters.sums)[0])
    pulls = ((z[0] - z[1:]) / np.sqrt(excess)) @ h[0]
    multipliers = draw.standard_normal((resamples, count)) * np.sqrt((count - 1) / count)
    return _both(problem, h[0], g[0] + multipliers @ pulls)
