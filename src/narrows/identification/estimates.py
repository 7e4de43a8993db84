"""Estimate, standard error and credible interval of every coefficient: the mixed model's posterior, within bounds."""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from narrows.identification.least_squares import Problem, solve
from narrows.identification.mixed_model import ScaleMixture, integrate, one_thread
from narrows.identification.motions import DistinctMotions, ForceRows
from narrows.identification.normal_equations import NormalEquations
from narrows.identification.systematic_effects import Effect, RunErrors, assemble
from narrows.ship.particulars import Configuration

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
    """Estimates of the coefficients, in the order of ``terms.names``."""

    problem: Problem
    forces: tuple[ForcePosterior, ...]
    free_values: np.ndarray  # (n,) without its own bound, given the other coefficients at their bounds
    free_std: np.ndarray  # (n,) half width of the 95 % interval without bounds, as a standard error
    values: np.ndarray  # (n,)
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
            shifts = np.abs(part.posterior.shifts * part.unit[:, None])
            for name, away, held in zip(result, distance, self.held, strict=True):
                slot = self.problem.slot[name]
                if slot in part.rows.free_parameters and 0 < away < np.inf and not held:
                    needed = away / np.maximum(shifts[part.rows.free_parameters.index(slot)], 1e-300)
                    pairs = [(e, min(float(n * e.usual), e.linear)) for e, n in zip(part.effects, needed, strict=True)]
                    usual = [(effect, size) for effect, size in pairs if effect.unit and size < effect.most]
                    result[name] = sorted(usual, key=lambda one: one[1] / one[0].usual)
        return result


@one_thread
def estimates(
    equations: NormalEquations, motions: DistinctMotions, problem: Problem, errors: RunErrors,
    configuration: Configuration,
) -> CoefficientEstimates:  # fmt: skip
    parts, size = [], len(problem.scale)
    table, covariance = np.zeros((size, 7)), np.zeros((size, size))
    for forces in joint_forces(problem):
        rows = ForceRows(equations, motions, problem, forces)
        model, effects, unit = assemble(rows, errors, configuration)
        parts.append(part := ForcePosterior(rows, effects, unit, integrate(model)))
        at = np.array(rows.free_parameters)
        table[at], covariance[np.ix_(at, at)] = _within_bounds(part, problem.bounds[at])
    order = np.array([problem.slot[name] for name in problem.terms.names])
    table = table[order]
    (free, free_std, values, std), ends, held = table[:, :4].T, table[:, 4:6], table[:, 6] > 0
    covariance = covariance[np.ix_(order, order)]
    return CoefficientEstimates(problem, tuple(parts), free, free_std, values, std, ends, held, covariance)


def joint_forces(problem: Problem) -> list[tuple[str, ...]]:
    """Forces that share coefficients, and Y and N, which share errors of the motion."""
    slots = {force: {problem.slot[term.name] for term in part} for force, part in problem.terms.forces.items() if part}
    lateral = tuple(force for force in slots if force != "X")
    shared = slots.get("X", set()) & {slot for force in lateral for slot in slots[force]}
    groups = [tuple(slots)] if shared else [("X",) if "X" in slots else (), lateral]
    return [group for group in groups if group]


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
        given = np.quantile(_draws(*_conditioned(means, spreads, int(i), edge), weights), TAILS, axis=0)
        ends = _widened(ends, np.clip(given, low, high))
    for i in np.flatnonzero(near | held):
        # Near a bound the unified interval contains a true value on it; a truncated quantile never does.
        ends[:, i] = bounded_interval(float(free[i]), float(free_std[i]), tuple(bounds[i]))
    covariance = np.atleast_2d(np.cov(inside.T)) * np.outer(~held, ~held)
    std = np.where(held, _truncated_std(np.abs(free - values), free_std), np.sqrt(np.diag(covariance)))
    ends = _widened(ends, np.stack([values, values]))
    return np.column_stack([free, free_std, values, std, *ends, held]), covariance


def _widened(ends: np.ndarray, others: np.ndarray) -> np.ndarray:
    return np.stack([np.minimum(ends[0], others[0]), np.maximum(ends[1], others[1])])


def _truncated_std(beyond: np.ndarray, std: np.ndarray) -> np.ndarray:
    """Standard deviation of the tail of a normal distribution, ``beyond`` the mean."""
    from scipy import stats

    # Farther out than 50 standard deviations the tail is an exponential one, and the difference of moments is rounding.
    t = beyond / np.maximum(std, 1e-12 * beyond + 1e-150)
    near = stats.truncnorm.std(np.minimum(t, 50.0), np.inf)
    return np.asarray(std * np.where(t < 50.0, near, 1 / np.maximum(t, 50.0)))


def _nearest(mean: np.ndarray, covariance: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """The values within the bounds that are most likely: nearest to the mean by the inverse of the covariance."""
    if ((mean >= bounds[:, 0]) & (mean <= bounds[:, 1])).all():
        return mean
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
