"""Other choices of the distinct motions: drawn with replacement, left out in turn, and those of each depth alone."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from narrows.base.errors import InputError
from narrows.base.results import with_error
from narrows.identification.estimates import HALF, CoefficientEstimates, ForcePosterior, bounded_interval, estimates
from narrows.identification.least_squares import Problem, solve_many
from narrows.identification.mixed_model import one_thread
from narrows.identification.motions import DistinctMotions, distinct_motions, grouped
from narrows.identification.normal_equations import NormalEquations
from narrows.identification.systematic_effects import RunErrors
from narrows.quantities.names import FORCES
from narrows.ship.particulars import Configuration

if TYPE_CHECKING:
    import pandas as pd

# Resamples that are solved at once.
CHUNK = 2048


@dataclass(frozen=True)
class Bootstrap:
    """Coefficients of many resamples of the tests, a check of the mixed model's intervals."""

    problem: Problem
    # (resamples, n) Coefficients of each resample fitted under the constraints, each in its own unit
    samples: np.ndarray
    std: np.ndarray  # (n,) Half width of the central 68 % of the coefficients fitted without bounds
    estimates: CoefficientEstimates  # Estimates from the original tests: centres of the intervals

    def intervals(self) -> dict[str, tuple[float, float]]:
        """Return a 95 % interval for each coefficient, in its unit and within its bounds."""
        # They use the spread of fits without bounds: percentiles of constrained ones miss the truth where a
        # coefficient, or one that it trades against, is near a bound. Andrews (2000), Inconsistency of the bootstrap
        # when a parameter is on the boundary of the parameter space.
        seen = zip(self.problem.terms.terms, self.estimates.free_values.tolist(), self.std.tolist(), strict=True)
        return {term.name: bounded_interval(value, std, term.bound) for term, value, std in seen}


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
    # Quantiles a standard deviation from a Gaussian's mean: the few resamples that miss a kind of test do not count.
    low, high = np.quantile(problem.coefficients(np.concatenate(free)), (0.158655, 0.841345), axis=0)
    return Bootstrap(problem, problem.coefficients(np.concatenate(bounded)), (high - low) / 2, found)


@dataclass(frozen=True)
class Predictiveness:
    force: str
    held: float  # share of directions inside their 95 % predictive interval
    half: float  # median half width [N, N m]
    relative: float  # median half width over the motion's own force
    motions: int

    @property
    def sentence(self) -> str:
        return (
            f"{self.force} of {self.motions} motions left out in turn: {self.held:.0%} lie within the 95 % predictive "
            f"interval, whose median half width is {self.half:.2g} {FORCES[self.force].unit} ({self.relative:.0%} of "
            "the force)."
        )


@one_thread
def predictiveness(part: ForcePosterior) -> list[Predictiveness]:
    """Predict each motion by the others, at the scales that all motions together show."""
    rows, weights = part.rows, part.posterior.weights
    # For each force and motion: measured less predicted over its standard error, in the independent directions of the
    # motion's rows; half width of the predictive interval and the measured force, as root mean squares.
    found: dict[str, list[tuple[np.ndarray, float, float]]] = {force: [] for force in rows.forces}
    for _, own, mean_rows in _motions(part):
        without = [without_rows(part, i, own) for i in range(len(part.posterior.parts))]
        means = np.stack([mean for mean, _, _ in without])[:, mean_rows]
        spreads = np.stack([np.diag(covariance) for _, covariance, _ in without])[:, mean_rows]
        mean, chosen = weights @ means, own[mean_rows]
        std, measured = np.sqrt(weights @ (spreads + (means - mean) ** 2)), rows.y[chosen]
        for f, force in enumerate(rows.forces):
            at = chosen // rows.each == f
            sizes = np.stack([HALF * std, measured])[:, at] / rows.length[chosen[at] % rows.each]
            half, level = np.linalg.norm(sizes, axis=1).tolist()
            found[force].append((((measured - mean) / std)[at], half, level))
    result = []
    for force, motions in found.items():
        scores, halves, levels = zip(*motions, strict=True)
        held = float((np.abs(np.concatenate(scores)) < HALF).mean())
        relative = float(np.median(np.divide(halves, np.maximum(levels, 1e-300))))
        result.append(Predictiveness(force, held, float(np.median(halves)), relative, len(halves)))
    return result


@one_thread
def influence(motions: DistinctMotions, found: CoefficientEstimates) -> "pd.DataFrame":
    """Leave out each distinct motion in turn (the jackknife): 1 less the ratio of variances with it and without it."""
    import pandas as pd

    problem = found.problem
    gone = np.zeros((len(motions), len(problem.scale)))
    for part in found.forces:
        best, p = int(part.posterior.weights.argmax()), len(part.rows.free_parameters)
        variances = np.diag(part.posterior.parts[best].covariance)[:p]
        for motion, own, _ in _motions(part):
            added = without_rows(part, best, own)[2][:p]
            gone[motion, part.rows.free_parameters] = added / np.maximum(variances + added, 1e-300)
    shares = gone[:, [problem.slot[name] for name in problem.terms.names]]
    return pd.DataFrame(shares, motions.labels, problem.terms.names)


def _motions(part: ForcePosterior) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Each motion, its rows, and which of these are of its mean."""
    rows = part.rows
    for motion in np.unique(rows.motion):
        own = np.flatnonzero(rows.all(rows.motion == motion))
        yield int(motion), own, np.flatnonzero(rows.of_mean[own % rows.each])


def without_rows(part: ForcePosterior, draw: int, own: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Predict some rows from all others at given scales: mean, covariance with errors, variance that they remove."""
    # The last is the variance of coefficients and effects beyond that with the rows, (p + q,).
    # Update of a precision: with errors V and leverage H the residual is V (V - H)^-1 e.
    posterior, model = part.posterior, part.posterior.model
    conditional, x = posterior.parts[draw], model.x[own]
    lower = np.linalg.cholesky(model.covariance_of(posterior.points[draw], own))
    scaled = np.linalg.solve(lower, x)
    known = conditional.covariance @ scaled.T
    values, vectors = np.linalg.eigh(scaled @ known)
    # Without information from other rows only the prior remains, and rounding can make the difference negative.
    left = np.maximum(1 - values, 1e-9)
    error = vectors.T @ np.linalg.solve(lower, model.y[own] - x @ conditional.mean)
    back = lower @ vectors
    added = ((known @ vectors) ** 2 / left).sum(axis=1)
    return model.y[own] - back @ (error / left), (back / left) @ back.T, added


@dataclass(frozen=True)
class DepthTest:
    values: Mapping[float, float]  # Depth [m]: estimate from the tests at that depth alone, in the coefficient's unit
    std: Mapping[float, float]  # Depth [m]: its standard error, in the coefficient's unit
    p: float  # Probability of as large differences, were it one coefficient: chi-square test [1]

    @property
    def changes(self) -> bool:
        """True where the coefficient differs between depths by more than its errors allow, at 5 % significance."""
        return self.p < 0.05

    def sentence(self, name: str) -> str:
        values = ", ".join(f"{with_error(value, self.std[h])} at {h:.4g} m" for h, value in self.values.items())
        word = "it changes with the depth" if self.changes else "no change with the depth is seen"
        return f"{name} by each depth alone is {values}: {word} (p = {self.p:.2g})."


def depth_tests(
    equations: NormalEquations, motions: DistinctMotions, problem: Problem, errors: RunErrors,
    configuration: Configuration,
) -> dict[str, DepthTest]:  # fmt: skip
    """Compare the bank's coefficients by the tests at each depth; empty where there is one depth."""
    from scipy.special import chdtrc

    bank = [i for i, term in enumerate(problem.terms.terms) if term.from_bank]
    depth = motions.features["depth"]
    groups = sorted(grouped(depth), key=lambda members: float(depth[members].mean()))
    if len(groups) < 2 or not bank:
        return {}
    depths, found = [], []
    for members in groups:
        part = equations.of_tests({name for i in members for name in motions.members[i]})
        depths.append(round(float(depth[members].mean()), 9))
        found.append(estimates(part, distinct_motions(part), problem, errors, configuration))
    values, std = np.array([(one.free_values[bank], one.free_std[bank]) for one in found]).transpose(1, 2, 0)
    means = (values / std**2).sum(axis=1) / (1 / std**2).sum(axis=1)
    p = chdtrc(len(depths) - 1, (((values - means[:, None]) / std) ** 2).sum(axis=1))
    tests = {}
    for k, i in enumerate(bank):
        own, errors_of = (dict(zip(depths, part[k].tolist(), strict=True)) for part in (values, std))
        tests[problem.terms.names[i]] = DepthTest(own, errors_of, float(p[k]))
    return tests
