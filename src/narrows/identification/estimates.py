"""Estimate, standard error and credible interval of every coefficient: the mixed model's posterior, within bounds."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.identification.force_rows import ForceRows
from narrows.identification.interval import bounded_interval
from narrows.identification.least_squares import Problem, solve
from narrows.identification.mixed_model import one_thread
from narrows.identification.motions import DistinctMotions
from narrows.identification.normal_equations import NormalEquations
from narrows.identification.run_blocks import run_blocks
from narrows.identification.run_errors import RunErrors
from narrows.identification.scale_integration import ScaleMixture, integrate
from narrows.identification.systematic_effects import Effect, assemble
from narrows.ship.particulars import Configuration

# An estimate so many standard errors beyond a bound is held at the bound.
CERTAIN = 2.0
# Within so many half widths of a bound the true value may lie on it.
BOUND_HALF_WIDTHS = 1.5
# Draws from the posterior; if fewer than LEAST are within the bounds, all are used, clipped.
DRAWS, LEAST, SEED = 8000, 200, 26
# Half width of a 95 % interval over the standard error.
HALF = 1.959963985


@dataclass(frozen=True)
class ForcePosterior:
    """The posterior of the coefficients of one force, or of several that share coefficients or errors."""

    rows: ForceRows
    effects: list[Effect]
    unit: np.ndarray  # (p,) unit of each scaled coefficient
    posterior: ScaleMixture

    @property
    def free_parameters(self) -> list[int]:
        """Indices of the coefficients of these forces among all free ones."""
        return self.rows.free_parameters


@dataclass(frozen=True)
class CoefficientEstimates:
    """Estimates of the coefficients, in the order of ``terms.names``."""

    problem: Problem
    forces: tuple[ForcePosterior, ...]
    values: np.ndarray  # (n,)
    std: np.ndarray  # (n,)
    covariance: np.ndarray  # (n, n), zero where a coefficient is held at a bound
    free_values: np.ndarray  # (n,) without its own bound, given the other coefficients at their bounds
    free_half: np.ndarray  # (n,) half width of the 95 % interval without bounds
    ends: np.ndarray  # (n, 2) 95 % interval within the bounds
    held: np.ndarray  # (n,) held at a bound that the data reject

    @property
    def free_std(self) -> np.ndarray:
        """Standard errors that make the free intervals, (n,)."""
        return self.free_half / HALF

    @cached_property
    def tipping(self) -> dict[str, list[tuple[Effect, float]]]:
        """Size of each shared error that brings a coefficient's interval to 0, the least unusual first."""
        away = np.maximum(self.ends[:, 0], -self.ends[:, 1])
        return self._sizes(np.where((away > 0) & ~self.held, away, np.inf))

    @cached_property
    def limits(self) -> dict[str, list[tuple[Effect, float]]]:
        """Size of each shared error that moves a coefficient by its standard error, the least unusual first."""
        return self._sizes(np.where((self.std > 0) & ~self.held, self.std, np.inf))

    def _sizes(self, distance: np.ndarray) -> dict[str, list[tuple[Effect, float]]]:
        """Size of each shared error that moves each coefficient by a distance (n,)."""
        result: dict[str, list[tuple[Effect, float]]] = {name: [] for name in self.problem.terms.names}
        for part in self.forces:
            shifts = np.abs(part.posterior.shifts * part.unit[:, None])
            for i, name in enumerate(result):
                slot = self.problem.slot[name]
                if slot in part.free_parameters and np.isfinite(distance[i]):
                    needed = distance[i] / np.maximum(shifts[part.free_parameters.index(slot)], 1e-300)
                    sizes = [
                        (e, min(float(n * e.usual), e.linear))
                        for e, n in zip(part.effects, needed, strict=True)
                        if e.has_usual_size
                    ]
                    result[name] = sorted(
                        ((e, size) for e, size in sizes if size < e.most), key=lambda one: one[1] / one[0].usual
                    )
        return result


@one_thread
def estimates(
    equations: NormalEquations,
    motions: DistinctMotions,
    problem: Problem,
    errors: RunErrors,
    configuration: Configuration,
) -> CoefficientEstimates:
    """Fit the mixed model of every force and combine the posteriors."""
    parts = tuple(
        _posterior(equations, motions, problem, errors, configuration, forces) for forces in joint_forces(problem)
    )
    size = len(problem.scale)
    free, free_half = np.zeros(size), np.full(size, np.inf)
    values, std, covariance = np.zeros(size), np.zeros(size), np.zeros((size, size))
    ends, held = np.zeros((size, 2)), np.zeros(size, bool)
    for part in parts:
        at = np.array(part.free_parameters)
        bounds = np.stack([problem.lower, problem.upper], axis=1)[at] / problem.scale[at, None]
        one = _within_bounds(part, bounds)
        free[at], free_half[at], values[at], std[at], ends[at], held[at] = one[:6]
        covariance[np.ix_(at, at)] = one[6]
    order = np.array([problem.slot[name] for name in problem.terms.names])
    return CoefficientEstimates(
        problem, parts, values[order], std[order], covariance[np.ix_(order, order)], free[order], free_half[order],
        ends[order], held[order],
    )  # fmt: skip


def joint_forces(problem: Problem) -> list[tuple[str, ...]]:
    """Forces that share coefficients, and Y and N, which share errors of the motion."""
    groups = [[force] for force, part in problem.terms.forces.items() if part]
    slots = {force: {problem.slot[term.name] for term in part} for force, part in problem.terms.forces.items()}
    joined: list[list[str]] = []
    for group in groups:
        force = group[0]
        near = [one for one in joined if any(slots[force] & slots[f] for f in one) or (force == "N" and "Y" in one)]
        joined = [one for one in joined if one not in near] + [[f for one in near for f in one] + group]
    return [tuple(one) for one in joined]


def _posterior(
    equations: NormalEquations,
    motions: DistinctMotions,
    problem: Problem,
    errors: RunErrors,
    configuration: Configuration,
    forces: tuple[str, ...],
) -> ForcePosterior:
    blocks = run_blocks(equations, motions, forces)
    rows = ForceRows(blocks, motions, problem, equations.columns)
    model, effects, unit = assemble(rows, errors, configuration)
    return ForcePosterior(rows, effects, unit, integrate(model))


def _within_bounds(part: ForcePosterior, bounds: np.ndarray) -> tuple[np.ndarray, ...]:
    """Free estimates and half widths, then values, standard errors, ends, held and covariance within the bounds."""
    unit = part.unit
    means = part.posterior.means * unit
    spreads = part.posterior.covariances * np.outer(unit, unit)
    weights = part.posterior.weights
    held, beyond_bound, beyond_std = np.zeros(len(unit), bool), np.zeros(len(unit)), np.zeros(len(unit))
    for _ in range(len(unit)):
        mean = weights @ means
        variances = np.maximum(np.diagonal(spreads, axis1=1, axis2=2), 0.0)  # Rounding may make it negative.
        std = np.sqrt(weights @ (variances + (means - mean) ** 2))
        beyond = np.maximum(bounds[:, 0] - mean, mean - bounds[:, 1]) / np.maximum(std, 1e-12 * np.abs(mean) + 1e-150)
        beyond[held] = -np.inf
        if beyond.max() < CERTAIN:
            break
        worst = int(beyond.argmax())
        edge = bounds[worst, 0] if mean[worst] < bounds[worst, 0] else bounds[worst, 1]
        held[worst], beyond_bound[worst], beyond_std[worst] = True, mean[worst], std[worst]
        means, spreads = _conditioned(means, spreads, worst, edge)
    draws = _draws(means, spreads, weights)
    inside = draws[((draws >= bounds[:, 0]) & (draws <= bounds[:, 1]) | held).all(axis=1)]
    inside = inside if len(inside) >= LEAST else np.clip(draws, bounds[:, 0], bounds[:, 1])
    free = np.where(held, beyond_bound, weights @ means)
    quantiles = np.quantile(draws, [0.025, 0.975], axis=0)
    free_half = np.where(held, HALF * beyond_std, 0.5 * (quantiles[1] - quantiles[0]))
    low, high = np.quantile(inside, [0.025, 0.975], axis=0)
    ends = np.stack([low, high], axis=1)
    away = np.minimum(np.abs(free - bounds[:, 0]), np.abs(bounds[:, 1] - free))
    near = (away < BOUND_HALF_WIDTHS * free_half) & ~held
    for i in np.flatnonzero(near):
        # If the true value lies on this bound, the others follow their conditional distribution.
        edge = bounds[i, 0] if abs(free[i] - bounds[i, 0]) < abs(bounds[i, 1] - free[i]) else bounds[i, 1]
        given = np.quantile(_draws(*_conditioned(means, spreads, int(i), edge), weights), [0.025, 0.975], axis=0)
        given = np.clip(given, bounds[:, 0], bounds[:, 1])
        ends = np.stack([np.minimum(ends[:, 0], given[0]), np.maximum(ends[:, 1], given[1])], axis=1)
    for i in np.flatnonzero(near | held):
        # Near a bound the unified interval contains a true value on it; a truncated quantile never does.
        ends[i] = bounded_interval(float(free[i]), float(free_half[i]) / HALF, tuple(bounds[i]))
    covariance_free = np.atleast_2d(np.cov(draws.T))
    covariance = np.atleast_2d(np.cov(inside.T)) * np.outer(~held, ~held)
    values = _nearest(weights @ means, covariance_free, bounds)
    ends = np.stack([np.minimum(ends[:, 0], values), np.maximum(ends[:, 1], values)], axis=1)
    std = np.where(held, beyond_std * _truncated_std(np.abs(free - values), beyond_std), np.sqrt(np.diag(covariance)))
    return free, free_half, values, std, ends, held, covariance


def _truncated_std(beyond: np.ndarray, std: np.ndarray) -> np.ndarray:
    """Standard deviation of a normal tail, ``beyond`` the mean, relative to that of the distribution."""
    from scipy import special

    t = beyond / np.maximum(std, 1e-12 * beyond + 1e-150)
    near = np.minimum(t, 50.0)  # Farther out the tail is an exponential one, and the difference below is rounding.
    hazard = np.exp(-0.5 * near**2 - special.log_ndtr(-near)) / np.sqrt(2 * np.pi)
    return np.asarray(np.where(t < 50.0, np.sqrt(1 - hazard * (hazard - near)), 1 / np.maximum(t, 50.0)))


def _nearest(mean: np.ndarray, covariance: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """The values within the bounds that are most likely: nearest to the mean by the inverse of the covariance."""
    if ((mean >= bounds[:, 0]) & (mean <= bounds[:, 1])).all():
        return mean
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    inverse = np.linalg.pinv(covariance / np.outer(size, size), rcond=1e-10, hermitian=True)
    inverse /= np.diag(inverse).max()  # The ridge of the solver is for a matrix of this size.
    z = solve(inverse, inverse @ (mean / size), *(bounds / size[:, None]).T).z * size
    return np.where(size > 1e-140, np.clip(z, bounds[:, 0], bounds[:, 1]), mean)


def _conditioned(means: np.ndarray, spreads: np.ndarray, i: int, value: float) -> tuple[np.ndarray, np.ndarray]:
    """Gaussians given the value of one coefficient."""
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
    order = np.argsort((variances / np.maximum(variances.max(axis=0), 1e-300)).sum(axis=1))
    means, spreads, weights = means[order], spreads[order], weights[order]
    edges = np.round(np.cumsum(weights) * (DRAWS // 2)).astype(int)
    which = np.repeat(np.arange(len(weights)), np.diff(edges, prepend=0))
    # Symmetric roots of correlations: units, and the signs that a library gives eigenvectors, do not change the draws.
    size = np.sqrt(np.diagonal(spreads, axis1=1, axis2=2).max(axis=0))
    size = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(spreads / np.outer(size, size))
    roots = (vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]) @ np.swapaxes(vectors, 1, 2) * size[:, None]
    half = np.einsum("nij,nj->ni", roots[which], rng.standard_normal((len(which), means.shape[1])))
    return np.concatenate([means[which] + half, means[which] - half])


def scales_of(part: ForcePosterior) -> Mapping[str, float]:
    """Estimated size of each error: shares of the force, and multiples of the usual sizes."""
    forces = part.rows.blocks.forces
    of_forces = [f"{kind} of {force}" for kind in ("form", "zero") for force in forces]
    names = ["gain", "form of the bank", "scatter", *of_forces]
    groups = dict.fromkeys(effect.group for effect in part.effects if effect.learned)
    posterior = part.posterior
    found = posterior.model.scales(posterior.weights @ posterior.points)[:-1]
    return dict(zip([*names, *groups], found.tolist(), strict=True))
