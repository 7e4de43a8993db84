"""Estimates and credible intervals: the mixed model's posterior, within bounds; of other choices of the motions too."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING

import numpy as np

from narrows.base.errors import InputError
from narrows.base.named_values import Named
from narrows.base.results import Aliased, with_error
from narrows.identification.least_squares import Problem, solve, solve_many
from narrows.identification.mixed_model import ScaleMixture, one_thread, posterior_of
from narrows.identification.motions import DistinctMotions, ForceRows, distinct_motions, grouped, row_blocks
from narrows.identification.normal_equations import NormalEquations
from narrows.identification.systematic_effects import Effect, RunErrors, assemble
from narrows.quantities.names import FORCES
from narrows.ship.particulars import Configuration

if TYPE_CHECKING:
    import pandas as pd

# Draws from the posterior; if fewer than LEAST are within the bounds, all are used, clipped.
DRAWS, LEAST, SEED = 8000, 200, 26
# Half width of a 95 % interval over the standard error.
HALF = 1.959963985
TAILS = (0.025, 0.975)
# Truths of a grid of intervals near a bound; halvings of the bracket around the critical likelihood ratio.
GRID, HALVINGS = 201, 30


@dataclass(frozen=True)
class ForcePosterior:
    rows: ForceRows
    effects: list[Effect]
    unit: np.ndarray  # (p,) unit of each scaled coefficient
    posterior: ScaleMixture

    @property
    def scales(self) -> dict[str, float]:
        """Estimated size of each error: shares of the force, and multiples of the usual sizes."""
        found = self.posterior.model.scales(self.posterior.weights @ self.posterior.points)
        return dict(zip(self.posterior.model.names, found.tolist(), strict=False))


@dataclass(frozen=True)
class CoefficientEstimates:
    problem: Problem
    forces: tuple[ForcePosterior, ...]
    free_values: np.ndarray  # (n,) without its own bound, given the other coefficients at their bounds
    free_std: np.ndarray  # (n,) half width of the 95 % interval without bounds, as a standard error
    values: np.ndarray  # (n,) in the order of ``terms.names``, as the others are
    std: np.ndarray  # (n,)
    ends: np.ndarray  # (n, 2) 95 % interval within the bounds
    held: np.ndarray  # (n,) held at a bound that the data reject
    covariance: np.ndarray  # (n, n), zero where a coefficient is held at a bound

    @cached_property
    def tipping(self) -> dict[str, list[tuple[Effect, float]]]:
        """Size of each shared error that brings a coefficient's interval to 0, the least unusual first."""
        return self._sizes(np.maximum(self.ends[:, 0], -self.ends[:, 1]))

    @cached_property
    def limits(self) -> dict[str, list[tuple[Effect, float]]]:
        """Size of each shared error that moves a coefficient by its standard error, the least unusual first."""
        return self._sizes(self.std)

    def _sizes(self, distance: np.ndarray) -> dict[str, list[tuple[Effect, float]]]:
        """Size of each shared error that moves each coefficient by a distance (n,)."""
        result: dict[str, list[tuple[Effect, float]]] = {name: [] for name in self.problem.terms.names}
        for part in self.forces:
            shifts = dict(
                zip(part.rows.free_parameters, np.abs(part.posterior.shifts * part.unit[:, None]), strict=True)
            )
            for name, away, held in zip(result, distance, self.held, strict=True):
                shift = shifts.get(self.problem.slot[name])
                if shift is not None and 0 < away < np.inf and not held:
                    needed = zip(part.effects, (away / np.maximum(shift, 1e-300)).tolist(), strict=True)
                    sizes = [(e, min(n * e.usual, e.linear)) for e, n in needed if e.unit]
                    usual = [(effect, size) for effect, size in sizes if size < effect.most]
                    result[name] = sorted(usual, key=lambda one: one[1] / one[0].usual)
        return result


@one_thread
def estimates(
    equations: NormalEquations, motions: DistinctMotions, problem: Problem, errors: RunErrors,
    configuration: Configuration,
) -> CoefficientEstimates:  # fmt: skip
    parts, size = [], len(problem.scale)
    table, covariance = np.zeros((size, 7)), np.zeros((size, size))
    blocks = row_blocks(equations, motions)
    for forces in problem.joint_forces:
        rows = ForceRows(equations, motions, blocks, problem, forces)
        model, effects, unit = assemble(rows, errors, configuration)
        parts.append(part := ForcePosterior(rows, effects, unit, posterior_of(model)))
        at = np.array(rows.free_parameters)
        table[at], covariance[np.ix_(at, at)] = _within_bounds(part, problem.bounds[at])
    order = [problem.slot[name] for name in problem.terms.names]
    free, free_std, values, std, low, high, held = table[order].T
    ends, covariance = np.stack([low, high], axis=1), covariance[np.ix_(order, order)]
    return CoefficientEstimates(problem, tuple(parts), free, free_std, values, std, ends, held > 0, covariance)


def _within_bounds(part: ForcePosterior, bounds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Free estimates and standard errors, then values, standard errors, ends and held within the bounds; covariance."""
    unit, weights = part.unit, part.posterior.weights
    means, spreads = part.posterior.means * unit, part.posterior.covariances * np.outer(unit, unit)
    held, free, free_std = np.zeros(len(unit), bool), np.zeros(len(unit)), np.zeros(len(unit))
    for _ in range(len(unit)):
        mean = weights @ means
        variances = np.maximum(np.diagonal(spreads, axis1=1, axis2=2), 0.0)  # Rounding may make it negative.
        std = np.sqrt(weights @ (variances + (means - mean) ** 2))
        beyond = np.maximum(bounds[:, 0] - mean, mean - bounds[:, 1]) / np.maximum(std, 1e-12 * np.abs(mean) + 1e-150)
        beyond[bounds[:, 0] == bounds[:, 1]] = np.inf  # Fixed
        beyond[held] = -np.inf
        if beyond.max() < 2.0:  # So many standard errors beyond a bound, an estimate is held at it
            break
        worst = int(beyond.argmax())
        held[worst], free[worst], free_std[worst] = True, mean[worst], std[worst]
        means, spreads = _conditioned(means, spreads, worst, float(np.clip(mean[worst], *bounds[worst])))
    draws, low, high = _draws(means, spreads, weights), bounds[:, 0], bounds[:, 1]
    inside = draws[((draws >= low) & (draws <= high) | held).all(axis=1)]
    inside = inside if len(inside) >= LEAST else np.clip(draws, low, high)
    free = np.where(held, free, weights @ means)
    free_std = np.where(held, free_std, 0.5 / HALF * np.diff(np.quantile(draws, TAILS, axis=0), axis=0)[0])
    values = _nearest(weights @ means, np.atleast_2d(np.cov(draws.T)), bounds)
    for edge in (low, high):  # A value that differs from its bound by rounding is the bound.
        values = np.where(np.isclose(values, edge, rtol=1e-9, atol=0.0), edge, values)
    ends = np.quantile(inside, TAILS, axis=0)
    # Within 1.5 half widths of a bound the true value may lie on it.
    near = (np.abs(free[:, None] - bounds).min(axis=1) < 1.5 * HALF * free_std) & ~held
    for i in np.flatnonzero(near):
        # If the true value lies on this bound, the others follow their conditional distribution.
        edge = bounds[i, np.abs(free[i] - bounds[i]).argmin()]
        given = np.quantile(_draws(*_conditioned(means, spreads, int(i), edge), weights), TAILS, axis=0).clip(low, high)
        ends = np.stack([np.minimum(ends[0], given[0]), np.maximum(ends[1], given[1])])
    for i in np.flatnonzero(near | held):
        # Near a bound the unified interval contains a true value on it; a truncated quantile never does.
        ends[:, i] = bounded_interval(float(free[i]), float(free_std[i]), tuple(bounds[i]))
    covariance = np.atleast_2d(np.cov(inside.T)) * np.outer(~held, ~held)
    truncated = _truncated_std(np.abs(free - values), free_std * (low < high))
    std = np.where(held, truncated, np.sqrt(np.diag(covariance)))
    least, most = np.minimum(ends[0], values), np.maximum(ends[1], values)
    return np.column_stack([free, free_std, values, std, least, most, held]), covariance


def _truncated_std(beyond: np.ndarray, std: np.ndarray) -> np.ndarray:
    """Standard deviation of the tail of a normal distribution, ``beyond`` the mean."""
    from scipy.special import erfcx

    # Farther out than 50 standard deviations the tail is an exponential one, and the difference of moments is rounding.
    t = beyond / np.maximum(std, 1e-12 * beyond + 1e-150)
    start = np.minimum(t, 50.0)
    mean = np.sqrt(2 / np.pi) / erfcx(start / np.sqrt(2))
    return np.asarray(std * np.where(t < 50.0, np.sqrt(1 + mean * (start - mean)), 1 / np.maximum(t, 50.0)))


def _nearest(mean: np.ndarray, covariance: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """The values within the bounds that are most likely: nearest to the mean by the inverse of the covariance."""
    if ((mean >= bounds[:, 0]) & (mean <= bounds[:, 1])).all() or not covariance.any():
        return np.asarray(np.clip(mean, *bounds.T))
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    inverse = np.linalg.pinv(covariance / np.outer(size, size), rcond=1e-10, hermitian=True)
    inverse /= np.diag(inverse).max()  # The tolerances of the solver are for a matrix of this size.
    z = solve(inverse, inverse @ (mean / size), *(bounds / size[:, None]).T).z * size
    return np.where(size > 1e-140, np.clip(z, bounds[:, 0], bounds[:, 1]), mean)


def _conditioned(means: np.ndarray, spreads: np.ndarray, i: int, value: float) -> tuple[np.ndarray, np.ndarray]:
    slope = spreads[:, :, i] / spreads[:, i, i][:, None]
    moved = means + slope * (value - means[:, [i]])
    moved[:, i] = value
    left = spreads - slope[:, :, None] * spreads[:, [i], :]
    left[:, i, :] = left[:, :, i] = 0.0
    return moved, left


def _draws(means: np.ndarray, spreads: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Antithetic draws from a mixture of Gaussians, as many from each as its weight requires."""
    rng = np.random.default_rng(SEED)
    # The order is from narrow to wide: where rounding moves a draw to the next Gaussian, that one is almost the same.
    variances = np.diagonal(spreads, axis1=1, axis2=2)
    largest = variances.max(axis=0)
    order = np.argsort((variances / np.maximum(largest, 1e-300)).sum(axis=1))
    means, spreads, weights = means[order], spreads[order], weights[order]
    edges = np.round(np.cumsum(weights) * (DRAWS // 2)).astype(int)
    which = np.repeat(np.arange(len(weights)), np.diff(edges, prepend=0))
    # Symmetric roots of correlations: units, and the signs that a library gives eigenvectors, do not change the draws.
    size = np.sqrt(np.where(largest > 0, largest, 1.0))
    values, vectors = np.linalg.eigh(spreads / np.outer(size, size))
    roots = (vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]) @ np.swapaxes(vectors, 1, 2) * size[:, None]
    half = np.einsum("nij,nj->ni", roots[which], rng.standard_normal((len(which), means.shape[1])))
    return np.concatenate([means[which] + half, means[which] - half])


def bounded_interval(value: float, std: float, bound: tuple[float, float]) -> tuple[float, float]:
    """Return the 95 % interval of a coefficient that is known to lie within bounds."""
    # Away from the bounds it is the normal interval. Near one it is the unified interval: the values whose likelihood
    # ratio, to the best value within the bounds, is not surprising. Cutting the plain interval at the bound would cover
    # a coefficient at its bound too often, and could leave nothing.
    # Feldman, Cousins (1998), Unified approach to the classical statistical analysis of small signals.
    if not np.isfinite(std):
        return bound
    if std == 0:
        return value, value
    low, high = bound
    edge, inward = (low, 1.0) if value - low <= high - value else (high, -1.0)
    x = inward * (value - edge) / std
    if x > 2 * HALF:
        return max(low, value - HALF * std), min(high, value + HALF * std)
    truths, least, most = _accepted()
    near = float(np.interp(x, most, truths)) if x > most[0] else 0.0
    far = float(np.interp(x, least, truths)) if x < least[-1] else x + HALF
    ends = sorted(edge + inward * std * end for end in (near, far))
    return max(low, ends[0]), min(high, ends[1])


@cache
def _accepted() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Truths from 0 to the quantile, and the least and largest accepted estimate of each [standard errors]."""
    from scipy.special import ndtr

    def least(root: np.ndarray) -> np.ndarray:
        """Where the likelihood ratio to the best allowed truth reaches ``root`` squared."""
        return np.asarray(np.where(root <= truths, truths - root, (truths**2 - root**2) / (2 * truths)))

    truths = np.linspace(1e-3, 1, GRID) * HALF
    low, high = np.zeros(GRID), np.full(GRID, HALF)  # Bracket of the root of the critical ratio
    for _ in range(HALVINGS):
        root = (low + high) / 2
        inside = ndtr(root) - ndtr(least(root) - truths) < 0.95
        low, high = np.where(inside, root, low), np.where(inside, high, root)
    root = (low + high) / 2
    return truths, least(root), truths + root


@dataclass(frozen=True, repr=False)
class Bootstrap(Aliased):
    """Coefficients of many resamples of the tests, a check of the mixed model's intervals."""

    problem: Problem
    samples: np.ndarray  # (resamples, n) Coefficients of each fit under the constraints, each in its own unit
    std: Mapping[str, float]  # Half width of the central 68 % of each coefficient fitted without bounds
    estimates: CoefficientEstimates  # Estimates from the original tests: centres of the intervals

    def intervals(self) -> dict[str, tuple[float, float]]:
        """Return a 95 % interval for each coefficient, in its unit and within its bounds."""
        # They use the spread of fits without bounds: percentiles of constrained ones miss the truth where a
        # coefficient, or one that it trades against, is near a bound. Andrews (2000), Inconsistency of the bootstrap
        # when a parameter is on the boundary of the parameter space.
        seen = zip(self.problem.terms.terms, self.estimates.free_values.tolist(), self.std.values(), strict=True)
        return {term.name: bounded_interval(value, std, term.bound) for term, value, std in seen}


def resampled(
    problem: Problem, motions: DistinctMotions, found: CoefficientEstimates, resamples: int, seed: int
) -> Bootstrap:
    """Draw as many distinct motions as there are, with replacement, and fit with the constraints and without."""
    if resamples < 2 or seed < 0:
        raise InputError(f"{resamples} resamples with seed {seed} give no spread; ask for 1000 or more, seed 0 or more")
    count, everywhere = len(motions), np.full(len(problem.scale), np.inf)
    times = np.random.default_rng(seed).multinomial(count, np.full(count, 1 / count), size=resamples).astype(float)
    h, g = (np.tensordot(times, own, axes=1) for own in problem.normal(motions.sums))
    free = problem.coefficients(solve_many(h, g, -everywhere, everywhere))
    # Quantiles a standard deviation from a Gaussian's mean: the few resamples that miss a kind of test do not count.
    low, high = np.quantile(free, (0.158655, 0.841345), axis=0)
    bounded = problem.coefficients(solve_many(h, g, problem.lower, problem.upper))
    return Bootstrap(problem, bounded, Named(zip(problem.terms.names, ((high - low) / 2).tolist(), strict=True)), found)


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
        means, spreads, _ = without_rows(part, np.arange(len(weights)), own)
        means, spreads = means[:, mean_rows], np.diagonal(spreads, axis1=1, axis2=2)[:, mean_rows]
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
        best, p = part.posterior.weights.argmax(0, keepdims=True), len(part.rows.free_parameters)
        variances = np.diag(part.posterior.stacked[1][best[0]])[:p]
        for motion, own, _ in _motions(part):
            added = without_rows(part, best, own)[2][0, :p]
            gone[motion, part.rows.free_parameters] = added / np.maximum(variances + added, 1e-300)
    shares = gone[:, [problem.slot[name] for name in problem.terms.names]]
    return pd.DataFrame(shares, motions.labels, problem.terms.names)


def _motions(part: ForcePosterior) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Each motion, its rows, and which of these are of its mean."""
    rows = part.rows
    for motion in np.unique(rows.motion):
        own = np.flatnonzero(rows.all(rows.motion == motion))
        yield int(motion), own, np.flatnonzero(rows.of_mean[own % rows.each])


def without_rows(part: ForcePosterior, draws: np.ndarray, own: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Predict some rows from all others at the scales of each draw: mean, covariance with errors, variance removed."""
    # The last is the variance of coefficients and effects beyond that with the rows, (draws, p + q).
    # Update of a precision: with errors V and leverage H the residual is V (V - H)^-1 e.
    posterior, x, y = part.posterior, part.posterior.model.x[own], part.posterior.model.y[own]
    found, spread = (stack[draws] for stack in posterior.stacked)
    lower = np.linalg.cholesky(posterior.model.covariance_of(posterior.points[draws], own))
    scaled = np.linalg.solve(lower, x[None])
    known = spread @ scaled.swapaxes(1, 2)
    values, vectors = np.linalg.eigh(scaled @ known)
    # Without information from other rows only the prior remains, and rounding can make the difference negative.
    left = np.maximum(1 - values, 1e-9)[:, None]
    error = vectors.swapaxes(1, 2) @ np.linalg.solve(lower, (y - found @ x.T)[..., None])
    back = lower @ vectors
    added = ((known @ vectors) ** 2 / left).sum(axis=2)
    return y - (back / left @ error)[..., 0], (back / left) @ back.swapaxes(1, 2), added


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
    groups = grouped(depth)
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
