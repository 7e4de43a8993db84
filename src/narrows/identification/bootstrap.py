"""Bootstrap of the constrained fit: distinct motions drawn with replacement."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError
from narrows.identification.estimates import CoefficientEstimates
from narrows.identification.interval import LEVEL, bounded_interval
from narrows.identification.least_squares import Problem, solve_many
from narrows.identification.motions import DistinctMotions
from narrows.terms.term import TermTable

# Quantiles a standard deviation from a Gaussian's mean: the few resamples that miss a kind of test do not count.
MIDDLE = (0.158655, 0.841345)
CHUNK = 2048


@dataclass(frozen=True)
class Bootstrap:
    """Coefficients of many resamples of the tests."""

    terms: TermTable  # The terms
    # (resamples, n) Coefficients of each resample fitted under the constraints, each in its own unit
    samples: np.ndarray
    std: np.ndarray  # (n,) Half width of the central 68 % of the coefficients fitted without bounds
    estimates: CoefficientEstimates  # Estimates from the original tests: centres of the intervals

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the samples, (n, n)."""
        return np.atleast_2d(np.cov(self.samples.T))

    def intervals(self, level: float = LEVEL) -> Mapping[str, tuple[float, float]]:
        """Return a confidence interval for each coefficient, in its unit and within its bounds."""
        # They use the spread of fits without bounds: percentiles of constrained ones miss the truth
        # where a coefficient, or one that it trades against, is near a bound.
        # Andrews (2000), Inconsistency of the bootstrap when a parameter is on the boundary of the parameter space.
        seen = zip(self.terms.terms, self.estimates.free_values, self.std, strict=True)
        return {term.name: bounded_interval(float(value), float(std), term.bound, level) for term, value, std in seen}


def resampled(
    problem: Problem, motions: DistinctMotions, found: CoefficientEstimates, resamples: int, seed: int
) -> Bootstrap:
    """Draw as many distinct motions as there are, with replacement, and fit with the constraints and without."""
    if resamples < 2 or seed < 0:
        raise InputError(f"{resamples} resamples with seed {seed} give no spread; ask for 1000 or more, seed 0 or more")
    count, bounded, free = len(motions), [], []
    times = np.random.default_rng(seed).multinomial(count, np.full(count, 1 / count), size=resamples).astype(float)
    everywhere = np.full(len(problem.scale), np.inf)
    for start in range(0, resamples, CHUNK):
        h, g = problem.normal(np.tensordot(times[start : start + CHUNK], motions.sums, axes=1))
        bounded.append(solve_many(h, g, problem.lower, problem.upper))
        free.append(solve_many(h, g, -everywhere, everywhere))
    low, high = np.quantile(problem.coefficients(np.concatenate(free)), MIDDLE, axis=0)
    return Bootstrap(problem.terms, problem.coefficients(np.concatenate(bounded)), (high - low) / 2, found)
