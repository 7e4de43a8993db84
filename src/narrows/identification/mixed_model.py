"""A linear mixed model: coefficients, random effects with learned scales, and errors that runs and motions share.

``y = X theta + Z b + e``: the effects b of a group have the variance of that group's scale squared, and the errors e of
a block of rows (one motion and one force) those of gain, zero, form and noise. Scales have half-t priors and are
integrated over, in coordinates of which each is standard normal before the data, by importance sampling from Laplace
approximations. About each mode the proposal is a split normal density: an axis has one width below the mode and another
above. Points are a fixed Sobol sequence, so that the answer is a smooth function of the data.

References
----------
Henderson (1975), Best linear unbiased estimation and prediction under a selection model: the equations.
Gelman (2006), Prior distributions for variance parameters in hierarchical models: half-t priors of scales.
Geweke (1989), Bayesian inference in econometric models using Monte Carlo integration: split normal densities.
Raftery, Bao (2010), Estimating and projecting trends in HIV/AIDS generalized epidemics using incremental mixture
importance sampling: a mode is added where one point outweighs the others.
Ionides (2008), Truncated importance sampling: the weights.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, wraps
from typing import Any, NamedTuple, ParamSpec, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

P = ParamSpec("P")
R = TypeVar("R")
# Coordinate of a scale of 1e-6 of its prior, which counts as 0; SciPy's quantile of t is exactly 0 a little below.
NO_SCALE = -5.0
RIDGE = 1e-6  # Prior precision of a coefficient over the force's level: it only keeps the solution finite
LOWEST, HIGHEST = -4.0, 6.0  # Range of the coordinates of scales, which are standard normal a priori
POINTS, SEED = 128, 26
SMALL, LARGE = -0.5, 3.0  # Starting coordinates of the search for a mode, and for a rival mode
LEAST_CURVATURE = 0.5  # Least curvature of the log density at a mode; 1 if the data do not determine a scale
STEP = 0.1  # Step of the finite differences for the curvature
REACH = 2.0  # Distance at which widths are measured [standard deviations]
NARROW, WIDE = 0.5, 2.0  # Limits of the widths over those from the curvature
APART, LESS_LIKELY = 1.0, 8.0  # Least distance of two modes, and largest difference of their log densities
LEAST_SHARE = 0.2  # Least share of the points for each mode
HEAVY = 0.15  # Weight of a point from which another mode is searched for
MOST_MODES = 5


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Run a function with one thread of the BLAS, which is faster for matrices as small as these."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        import scipy.linalg.lapack  # noqa: F401  # SciPy's own BLAS, which a limit set before its import does not reach

        with threadpool_limits(limits=1):
            return function(*args, **kwargs)

    return run


class Conditional(NamedTuple):
    log_density: float  # of the scales' posterior, up to a constant
    mean: np.ndarray  # (p + q,)
    covariance: np.ndarray  # (p + q, p + q)
    gradient: np.ndarray  # (scales,) of the log density; empty unless asked for


@dataclass(frozen=True)
class MixedModel:
    """The data and the priors; the first scales are those of errors within blocks, the others of groups of effects."""

    names: tuple[str, ...]  # of the scales
    x: np.ndarray  # (rows, p + q) columns of coefficients, then of effects, each of about unit size
    y: np.ndarray  # (rows,) measured
    starts: np.ndarray  # first row of each block
    noise: np.ndarray  # (rows,) variance by the noise within runs
    shared: np.ndarray  # (rows, errors) errors for a scale of one that all rows of a block share in proportion to it
    apart: np.ndarray  # (rows, errors) variances for a scale of one that each row has by itself
    group: np.ndarray  # (q,) the scale of each effect; the number of scales for effects whose scale is not learned
    prior: np.ndarray  # (scales,) scale of each half-t prior
    freedom: np.ndarray  # (scales,) degrees of freedom of each prior; many make it half-normal
    taken: np.ndarray  # (p, q) what a coefficient of the best-fitting terms takes of each effect
    rivals: tuple[int, ...] = ()  # scales of effects that may explain by themselves what a coefficient does

    @property
    def fixed(self) -> int:
        return int(self.taken.shape[0])

    @cached_property
    def _blocks(self) -> list[tuple[np.ndarray, ...]]:
        """Columns and forces, shared errors, variances apart and by noise, each (blocks, size, ...), for each size."""
        sizes, parts = np.diff(self.starts, append=len(self.y)), (np.column_stack([self.x, self.y]), self.shared)
        rows = [self.starts[sizes == size, None] + np.arange(size) for size in np.unique(sizes)]
        return [tuple(part[own] for part in (*parts, self.apart, self.noise)) for own in rows]

    def at(self, z: np.ndarray, gradient: bool = False) -> Conditional:
        """Solve for coefficients and effects at given scales: generalised least squares."""
        p, scale = self.fixed, self.scales(z)
        roots = [_root(scale[: self.shared.shape[1]] ** 2, *block[1:]) for block in self._blocks]
        white = [root @ block[0] for root, block in zip(roots, self._blocks, strict=True)]
        flat = np.concatenate([own.reshape(-1, own.shape[2]) for own in white])
        h = flat.T @ flat
        # In units of their standard deviations, so that the matrix stays well conditioned.
        unit = np.concatenate([1 / np.sqrt(np.diag(h)[:p] + RIDGE), scale[self.group]])
        precision = np.concatenate([RIDGE * unit[:p] ** 2, np.ones(len(self.group))])
        inverse, logs = _inverse(h[:-1, :-1] * np.outer(unit, unit) + np.diag(precision))
        inverse *= np.outer(unit, unit)
        beta = inverse @ h[:-1, -1]
        # Residuals and effects, not a difference of large sums: that is rounding where columns depend on each other.
        left = flat[:, -1] - flat[:, :-1] @ beta
        quadratic = left @ left + (precision * (beta / unit) ** 2).sum() + z @ z
        logs += np.log(unit[:p]).sum() + sum(np.log(np.diagonal(root, axis1=1, axis2=2)).sum() for root in roots)
        slope = self._gradient(z, scale, beta, inverse, roots, white) if gradient else np.zeros(0)
        return Conditional(float(logs - 0.5 * quadratic), beta, inverse, slope)

    def _gradient(
        self, z: np.ndarray, scale: np.ndarray, beta: np.ndarray, inverse: np.ndarray, roots: list[np.ndarray],
        white: list[np.ndarray],
    ) -> np.ndarray:  # fmt: skip
        """Gradient of the log posterior by each coordinate: the identities of restricted maximum likelihood."""
        from scipy import stats

        p, errors = self.fixed, self.shared.shape[1]
        moment = (beta[p:] ** 2 + np.diag(inverse)[p:]) / scale[self.group] ** 2 - 1
        slope = np.bincount(self.group, moment, len(scale))[:-1].astype(float)  # By the logarithm of each scale
        for (_, shared, apart, _), root, own in zip(self._blocks, roots, white, strict=True):
            back = root.swapaxes(1, 2)
            solved = back @ own
            solved[..., -1] -= solved[..., :-1] @ beta  # Residuals
            # One product of two large matrices, not one for each block.
            rows = solved.reshape(-1, own.shape[2])
            spread = np.column_stack([rows[:, :-1] @ inverse, rows[:, -1]])
            excess = spread.reshape(own.shape) @ solved.swapaxes(1, 2) - back @ root
            alone = np.diagonal(excess, axis1=1, axis2=2)
            slope[:errors] += scale[:errors] ** 2 * (
                ((excess @ shared) * shared).sum(axis=(0, 1)) + np.tensordot(alone, apart, 2)
            )
        # Derivative of the logarithm of each scale to its coordinate: normal density over half-t density.
        ratio = self._ratio(z)
        return np.asarray(slope * 0.5 * stats.norm.pdf(z) / stats.t.pdf(ratio, self.freedom) / ratio - z)

    def covariance_of(self, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
        own = self.scales(z)[: self.shared.shape[1]] ** 2
        block, shared = np.searchsorted(self.starts, rows, side="right"), self.shared[rows]
        same = block[:, None] == block
        return np.asarray(same * ((shared * own) @ shared.T) + np.diag(self.noise[rows] + self.apart[rows] @ own))

    def scales(self, z: np.ndarray) -> np.ndarray:
        """Every scale, the half-t quantile of the normal probability of z; 1 for effects whose scale is not learned."""
        return np.append(self.prior * self._ratio(z), 1.0)

    def _ratio(self, z: np.ndarray) -> np.ndarray:
        from scipy import special

        return np.asarray(-special.stdtrit(self.freedom, 0.5 * special.ndtr(-np.maximum(z, NO_SCALE))))


def _root(own: np.ndarray, shared: np.ndarray, apart: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Inverse of the Cholesky factor of the covariance of blocks, (blocks, rows, rows)."""
    v, places = (shared * own) @ shared.swapaxes(1, 2), np.arange(noise.shape[1])
    v[:, places, places] += noise + apart @ own
    return np.linalg.inv(np.linalg.cholesky(v))


def _inverse(m: np.ndarray) -> tuple[np.ndarray, float]:
    """Inverse of a matrix of unit diagonal, and half the logarithm of the inverse's determinant."""
    from scipy.linalg import lapack

    try:
        lower = np.linalg.cholesky(m)
    except np.linalg.LinAlgError:  # The matrix is rounding in some direction: there its eigenvalues are raised.
        values, vectors = np.linalg.eigh(m)
        values = np.maximum(values, 1e-10)
        return (vectors / values) @ vectors.T, -0.5 * np.log(values).sum()
    half = np.tril(lapack.dpotri(lower, lower=1)[0])
    return half + np.tril(half, -1).T, -np.log(np.diag(lower)).sum()


@dataclass(frozen=True)
class SplitNormal:
    mode: np.ndarray  # (scales,)
    root: np.ndarray  # (scales, scales) symmetric, of the inverse curvature
    widths: np.ndarray  # (2, scales) below and above the mode
    top: float  # Log density of the posterior at the mode

    def points(self, count: int) -> np.ndarray:
        """Fixed points of low discrepancy, (count, scales)."""
        from scipy import special, stats

        below, above = self.widths
        sobol = stats.qmc.Sobol(len(self.mode), seed=SEED).random(count)
        u, total = np.clip(sobol, 1e-9, 1 - 1e-9), below + above
        half = np.where(u * total < below, u * total / (2 * below), 1 - (1 - u) * total / (2 * above))
        return np.asarray(self.mode + np.where(half < 0.5, below, above) * special.ndtri(half) @ self.root)

    def log_density(self, at: np.ndarray) -> np.ndarray:
        """Up to a constant that all modes share."""
        x = np.linalg.solve(self.root, (at - self.mode).T).T
        return np.asarray(-0.5 * ((x / np.where(x < 0, *self.widths)) ** 2).sum(axis=1) - self.log_volume)

    @property
    def log_volume(self) -> float:
        return float(np.linalg.slogdet(self.root)[1] + np.log(self.widths.mean(axis=0)).sum())


def integrate(model: MixedModel, points: int = POINTS) -> "ScaleMixture":
    """Weigh points about every mode of the scales by the posterior over the proposal."""
    if not len(model.prior):
        nothing = np.zeros(0)
        return ScaleMixture(model, nothing, nothing[None], np.ones(1), [model.at(nothing)])
    modes, densities = search(model), list[SplitNormal]()
    known: dict[bytes, Conditional] = {}  # A longer Sobol sequence begins with the points of the shorter one
    while True:
        densities += [_fitted(model, mode) for mode, _ in modes[len(densities) :]]
        mixture, weight = _weighed(model, densities, points, known)
        heaviest = int(weight.argmax())
        if weight[heaviest] < HEAVY or len(modes) == MOST_MODES:
            return mixture
        more = _distinct([*modes, _climb(model, mixture.points[heaviest])])
        if len(more) == len(modes):
            return mixture
        modes = more


def _weighed(
    model: MixedModel, densities: list[SplitNormal], points: int, known: dict[bytes, Conditional]
) -> tuple["ScaleMixture", np.ndarray]:
    """The mixture, whose weights are truncated, and the weights before that."""
    sizes = np.array([one.top + one.log_volume for one in densities])
    share = np.exp(sizes - sizes.max())
    share = np.maximum(share / share.sum(), LEAST_SHARE)
    # Powers of two, for which the points of a Sobol sequence are balanced.
    counts = 2 ** np.ceil(np.log2(points * share / share.sum())).astype(int)
    drawn = np.vstack([one.points(count) for one, count in zip(densities, counts, strict=True)])
    logs = [np.log(count) + one.log_density(drawn) for one, count in zip(densities, counts, strict=True)]
    within = np.clip(drawn, LOWEST, HIGHEST)
    known |= {z.tobytes(): model.at(z) for z in within if z.tobytes() not in known}
    parts = [known[z.tobytes()] for z in within]
    log_weight = np.array([one.log_density for one in parts]) - np.logaddexp.reduce(logs)
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    truncated = np.minimum(weight, np.sqrt(points) / len(weight))
    mode = densities[int(sizes.argmax())].mode
    return ScaleMixture(model, mode, within, truncated / truncated.sum(), parts), weight


def search(model: MixedModel) -> list[tuple[np.ndarray, float]]:
    """Modes of the scales and their log densities, from small effects and from each rival explanation."""
    small = np.full(len(model.prior), SMALL)
    starts = [small, *(np.where(np.arange(len(small)) == scale, LARGE, small) for scale in model.rivals)]
    return _distinct(sorted((_climb(model, start) for start in starts), key=lambda one: -one[1]))


def _climb(model: MixedModel, start: np.ndarray) -> tuple[np.ndarray, float]:
    from scipy import optimize

    minimize: Any = optimize.minimize

    def descend(z: np.ndarray) -> tuple[float, np.ndarray]:
        at = model.at(z, gradient=True)
        return -at.log_density, -at.gradient

    bounds, options = [(LOWEST, HIGHEST)] * len(start), {"maxiter": 100, "ftol": 1e-4}
    found = minimize(descend, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(found.x), -float(found.fun)


def _distinct(found: list[tuple[np.ndarray, float]]) -> list[tuple[np.ndarray, float]]:
    """Modes that are no neighbours of an earlier one, and not much less likely than the first."""
    modes: list[tuple[np.ndarray, float]] = []
    for at, value in found:
        near = any(np.abs(at - mode).max() < APART for mode, _ in modes)
        if not near and value > found[0][1] - LESS_LIKELY:
            modes.append((at, value))
    return modes


def _fitted(model: MixedModel, mode: np.ndarray) -> SplitNormal:
    """Split normal density: the curvature by differences of the gradient, widths by the log density to both sides."""

    def slope(z: np.ndarray) -> np.ndarray:
        return model.at(z, gradient=True).gradient

    here = slope(mode)
    curvature = np.array([(here - slope(mode + e)) / STEP for e in STEP * np.eye(len(mode))])
    values, vectors = np.linalg.eigh(0.5 * (curvature + curvature.T))
    values = np.maximum(values, LEAST_CURVATURE)
    # Steps of Newton, so that the mode does not depend on when the search stopped.
    for _ in range(2):
        mode = np.clip(mode + (vectors / values) @ vectors.T @ here, LOWEST, HIGHEST)
        here = slope(mode)
    # The symmetric root: it does not change with the signs and the order that a library gives eigenvectors.
    root, top = (vectors / np.sqrt(values)) @ vectors.T, model.at(mode).log_density
    logs = [[model.at(mode + step * axis).log_density for axis in root] for step in (-REACH, REACH)]
    widths = REACH / np.sqrt(2 * np.maximum(top - np.array(logs), 0.0) + 1e-12)
    return SplitNormal(mode, root, np.clip(widths, NARROW, WIDE), top)


@dataclass(frozen=True)
class ScaleMixture:
    """A mixture of Gaussians, one for each point of the scales."""

    model: MixedModel
    mode: np.ndarray
    points: np.ndarray  # (draws, scales) coordinates
    weights: np.ndarray
    parts: list[Conditional]

    @cached_property
    def _combined(self) -> np.ndarray:
        """Coefficients of the best-fitting terms by coefficients and effects, (p, p + q)."""
        return np.hstack([np.eye(self.model.fixed), self.model.taken])

    @cached_property
    def means(self) -> np.ndarray:
        """Coefficients of each draw, (draws, p)."""
        return np.asarray(np.stack([part.mean for part in self.parts]) @ self._combined.T)

    @cached_property
    def covariances(self) -> np.ndarray:
        """Covariance of each draw, (draws, p, p)."""
        return np.stack([self._combined @ part.covariance @ self._combined.T for part in self.parts])

    @cached_property
    def shifts(self) -> np.ndarray:
        """Change of each coefficient for a change of an effect by one, the effect being given: (p, q)."""
        # Regression of coefficients on effects: data that contradict an effect of that size do not reduce the change,
        # since other effects may have absorbed it.
        p = self.model.fixed
        slopes = [(self._combined @ part.covariance[:, p:]) / np.diag(part.covariance)[p:] for part in self.parts]
        return np.asarray(np.tensordot(self.weights, slopes, 1))
