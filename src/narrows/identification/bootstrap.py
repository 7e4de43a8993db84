"""Bootstrap of the constrained fit: residuals drawn anew, or distinct motions drawn anew."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from narrows.errors import InputError
from narrows.identification.estimates import CoefficientEstimates
from narrows.identification.interval import LEVEL, bounded_interval
from narrows.identification.least_squares import Problem, solve_many
from narrows.identification.motions import DistinctMotions
from narrows.terms.term import TermTable

Kind = Literal["errors", "tests"]
BOOTSTRAPS = get_args(Kind)
# Between these a Gaussian holds two standard deviations; the few resamples that miss a kind of test do not count.
MIDDLE = (0.158655, 0.841345)
CHUNK = 2048


@dataclass(frozen=True)
class Bootstrap:
    """Coefficients of many resamples of the tests."""

    terms: TermTable  # The terms
    # (resamples, n) Coefficients of each resample fitted under the constraints, each in its own unit
    samples: np.ndarray
    std: np.ndarray  # (n,) Half of what holds the middle 68 % of the coefficients of resamples fitted without bounds
    estimates: CoefficientEstimates  # Estimates of the tests themselves: the middle of the intervals
    kind: str  # ``errors`` or ``tests``

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the samples, (n, n)."""
        return np.atleast_2d(np.cov(self.samples.T))

    def intervals(self, level: float = LEVEL) -> Mapping[str, tuple[float, float]]:
        """Return a confidence interval for each coefficient, in its unit and within its bounds."""
        # They rest on the spread of fits that do not know the bounds: percentiles of constrained ones miss the truth
        # where a coefficient, or one that it trades against, is near a bound.
        # Andrews (2000), Inconsistency of the bootstrap when a parameter is on the boundary of the parameter space.
        seen = zip(self.terms.terms, self.estimates.free_values, self.std, strict=True)
        return {term.name: bounded_interval(float(value), float(std), term.bound, level) for term, value, std in seen}


def resampled(
    problem: Problem, motions: DistinctMotions, found: CoefficientEstimates, resamples: int, kind: str, seed: int
) -> Bootstrap:
    """Fit resamples of the tests, with the constraints and without."""
    # ``errors`` leaves the tests as they are and perturbs their pull on the fit by errors of the size that the fit
    # without bounds has. ``tests`` draws as many distinct motions as there are, with replacement, and adds up their
    # sums.
    if kind not in BOOTSTRAPS:
        raise InputError(f"bootstrap kind {kind!r} is unknown; choose {' or '.join(BOOTSTRAPS)}")
    if resamples < 2 or seed < 0:
        raise InputError(f"{resamples} resamples with seed {seed} give no spread; ask for 1000 or more, seed 0 or more")
    draw = np.random.default_rng(seed)
    if kind == "tests":
        bounded, free = _by_tests(problem, motions, resamples, draw)
    else:
        bounded, free = _by_errors(problem, motions, found, resamples, draw)
    low, high = np.quantile(problem.coefficients(free), MIDDLE, axis=0)
    std = (high - low) / 2
    if kind == "errors":  # what is drawn is as wide as a force's coefficients are at the median
        drawn = np.sqrt(np.diag(found.covariance))
        std = std * np.where(drawn > 0, found.free_std / np.where(drawn > 0, drawn, 1.0), 1.0)
    return Bootstrap(problem.terms, problem.coefficients(bounded), std, found, kind)


def _both(problem: Problem, h: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Solve a stack of problems with the bounds and without."""
    everywhere = np.full(len(problem.scale), np.inf)
    return solve_many(h, g, problem.lower, problem.upper), solve_many(h, g, -everywhere, everywhere)


def _by_tests(
    problem: Problem, motions: DistinctMotions, resamples: int, draw: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    count = len(motions)
    times = draw.multinomial(count, np.full(count, 1 / count), size=resamples).astype(float)
    parts = [
        _both(problem, *problem.normal(np.tensordot(times[start : start + CHUNK], motions.sums, axes=1)))
        for start in range(0, resamples, CHUNK)
    ]
    bounded, free = zip(*parts, strict=True)
    return np.concatenate(bounded), np.concatenate(free)


def _by_errors(
    problem: Problem, motions: DistinctMotions, found: CoefficientEstimates, resamples: int, draw: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    h, g = problem.normal(motions.sums.sum(axis=0))
    first = [list(problem.slot.values()).index(slot) for slot in range(len(g))]
    covariance = found.covariance[np.ix_(first, first)] * np.outer(problem.scale, problem.scale)
    values, vectors = np.linalg.eigh(covariance)
    errors = draw.standard_normal((resamples, len(g))) * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    return _both(problem, h, g + errors @ h)
