"""A linear mixed model: coefficients, random effects with learned scales, and errors that runs and motions share.

``y = X theta + Z b + e``: the effects b of a group have the variance of that group's scale squared, and the errors e of
a block of rows (one motion and one force) those of gain, zero, form and noise. Scales have half-t priors. They are
integrated over by importance sampling from Laplace approximations, in coordinates that are standard normal a priori.
About each mode the proposal is a split normal density: an axis has one width below the mode and another above. Points
are a fixed Sobol sequence, so that the result is a smooth function of the data.

References
----------
Henderson (1975), Best linear unbiased estimation and prediction under a selection model: the equations.
Gelman (2006), Prior distributions for variance parameters in hierarchical models: half-t priors of scales.
Geweke (1989), Bayesian inference in econometric models using Monte Carlo integration: split normal densities.
Raftery, Bao (2010), Estimating and projecting trends in HIV/AIDS generalized epidemics using incremental mixture
importance sampling: a mode is added where one point outweighs the others.
Ionides (2008), Truncated importance sampling: the weights.
Carvalho, Polson, Scott (2010), The horseshoe estimator for sparse signals: scales that are multiples of a global one.
"""

import pickle
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property, wraps
from hashlib import sha256
from threading import Lock
from typing import Any, NamedTuple, ParamSpec, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

P = ParamSpec("P")
R = TypeVar("R")
# Coordinate of a scale of 1e-6 of its prior, which counts as 0; SciPy's quantile of t is exactly 0 a little below.
NO_SCALE = -5.0
RIDGE = 1e-6  # Prior precision of a coefficient in units of the force's level: it only keeps the solution finite
LOWEST, HIGHEST = -4.0, 6.0  # Range of the coordinates of scales, which are standard normal a priori
POINTS = 128  # Points of importance sampling
SMALL, LARGE = -0.5, 3.0  # Starting coordinates of the search for a mode, and for a rival mode
LEAST_CURVATURE = 0.5  # Least curvature of the log density at a mode; 1 if the data do not determine a scale
STEP = 0.1  # Step of the finite differences for the curvature
REACH = 2.0  # Distance from the mode at which widths are measured [standard deviations]
NARROW, WIDE = 0.5, 2.0  # Limits of the widths over those from the curvature
APART, LESS_LIKELY = 1.0, 8.0  # Least distance of two modes, and largest difference of their log densities
LEAST_SHARE = 0.2  # Least share of the points for each mode
HEAVY = 0.15  # Weight of a point from which another mode is searched for
MOST_MODES = 5
KEPT_BYTES = 200e6  # Covariances of posteriors that are kept for the next fit of the same tests


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Run a function with one thread of the BLAS, which is faster for matrices as small as these."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        import scipy.linalg.lapack  # noqa: F401  # SciPy's own BLAS, which a limit set before its import does not reach

        with threadpool_limits(limits=1):
            return function(*args, **kwargs)

    return run


class Batch(NamedTuple):
    """Blocks of one force, either of one row or of more: short ones are filled up with zeros."""

    columns: np.ndarray  # (k,) Columns that are not zero in all of them: half of all take a quarter of the time
    places: np.ndarray  # (k, k) Places of their products in the flat matrix of all: faster than two indices
    data: np.ndarray  # (blocks, size, k + 1) These columns, then measured values
    own: np.ndarray  # (rows,) Which of their rows, one after the other, are not filled in
    shared: np.ndarray  # (blocks, size, errors)
    independent: np.ndarray  # (blocks, size, errors)
    noise: np.ndarray  # (blocks, size) 1 in what is filled in

    def whitening(self, variances: np.ndarray) -> np.ndarray:
        """Return the inverse Cholesky factors of the covariances of blocks, (blocks, size, size)."""
        v = (self.shared * variances) @ self.shared.swapaxes(1, 2)
        np.einsum("bii->bi", v)[...] += self.noise + self.independent @ variances
        return np.linalg.inv(np.linalg.cholesky(v)) if v.shape[1] > 1 else 1 / np.sqrt(v)


class Conditional(NamedTuple):
    log_density: float  # Log posterior density of the scales, up to a constant
    mean: np.ndarray  # (p + q,)
    covariance: np.ndarray  # (p + q, p + q)
    gradient: np.ndarray  # (scales,) Gradient of the log density; empty unless requested


@dataclass(frozen=True)
class MixedModel:
    """The data and the priors; the first scales are those of errors within blocks, the others of groups of effects."""

    names: tuple[str, ...]  # Names of the scales
    x: np.ndarray  # (rows, p + q) Columns of coefficients, then of effects, each of about unit size
    y: np.ndarray  # (rows,) Measured values
    starts: np.ndarray  # (blocks,) First row of each block
    noise: np.ndarray  # (rows,) Variance of the noise within runs
    shared: np.ndarray  # (rows, errors) Error, at scale 1, of the part that all rows of a block share
    independent: np.ndarray  # (rows, errors) Variance, at scale 1, of the part that is independent from row to row
    group: np.ndarray  # (q,) Index of each effect's scale; the number of scales where the scale is not learned
    prior: np.ndarray  # (scales,) Scale of each half-t prior
    freedom: np.ndarray  # (scales,) Degrees of freedom of each prior; with many it is half-normal
    absorbed: np.ndarray  # (p, q) Part of each effect that a coefficient of the best-fitting terms absorbs
    forces: int = 1  # Number of forces; each has as many blocks, one after the other
    confounding_scales: tuple[int, ...] = ()  # Scales of effects that may replace a coefficient
    multiples: tuple[int, ...] = ()  # Scales that are multiples of a global one, the last

    @property
    def fixed(self) -> int:
        return int(self.absorbed.shape[0])

    @cached_property
    def _batches(self) -> list[Batch]:
        sizes, forces = np.diff(self.starts, append=len(self.y)), np.split(np.arange(len(self.starts)), self.forces)
        kinds = [blocks[kind] for blocks in forces for kind in (sizes[blocks] == 1, sizes[blocks] > 1)]
        return [self._batch(blocks, sizes[blocks]) for blocks in kinds if blocks.size]

    def _batch(self, blocks: np.ndarray, sizes: np.ndarray) -> Batch:
        within = np.arange(sizes.max()) < sizes[:, None]
        rows = np.where(within, self.starts[blocks][:, None] + np.arange(sizes.max()), 0)

        def filled(part: np.ndarray) -> np.ndarray:
            return np.where(within[..., None], part[rows], 0.0)

        x = filled(self.x)
        used = np.flatnonzero(x.any(axis=(0, 1)))
        data = np.concatenate([x[..., used], filled(self.y[:, None])], axis=2)
        errors = filled(self.shared), filled(self.independent), np.where(within, self.noise[rows], 1.0)
        return Batch(used, used[:, None] * x.shape[2] + used, data, np.flatnonzero(within), *errors)

    def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
        """Solve for coefficients and effects at given scales: generalised least squares."""
        p, count, scale = self.fixed, self.x.shape[1], self.scales(z)
        h, right, roots, white = np.zeros(count**2), np.zeros(count), [], []
        for batch in self._batches:
            roots.append(batch.whitening(scale[: self.shared.shape[1]] ** 2))
            white.append((roots[-1] @ batch.data).reshape(-1, batch.data.shape[2])[batch.own])
            products = white[-1].T @ white[-1]
            h[batch.places] += products[:-1, :-1]
            right[batch.columns] += products[:-1, -1]
        # In units of their standard deviations, so that the matrix stays well conditioned.
        unit = np.concatenate([1 / np.sqrt(h[:: count + 1][:p] + RIDGE), scale[self.group]])
        precision, units = np.concatenate([RIDGE * unit[:p] ** 2, np.ones(len(self.group))]), np.outer(unit, unit)
        matrix = h.reshape(count, count) * units
        np.einsum("ii->i", matrix)[...] += precision
        inverse, logs = _inverse(matrix)
        inverse *= units
        beta = inverse @ right
        # By residuals and effects: a difference of large sums would be mostly rounding for nearly collinear columns.
        quadratic = (precision * (beta / unit) ** 2).sum() + z @ z
        for batch, root, part in zip(self._batches, roots, white, strict=True):
            part[:, -1] -= part[:, :-1] @ beta[batch.columns]
            quadratic += (part[:, -1] ** 2).sum()
            logs += np.log(np.einsum("bii->bi", root)).sum()
        slope = self._gradient(z, scale, beta, inverse, roots, white) if gradient else np.zeros(0)
        return Conditional(float(logs + np.log(unit[:p]).sum() - 0.5 * quadratic), beta, inverse, slope)

    def _gradient(
        self, z: np.ndarray, scale: np.ndarray, beta: np.ndarray, inverse: np.ndarray, roots: list[np.ndarray],
        white: list[np.ndarray],
    ) -> np.ndarray:  # fmt: skip
        """Return the gradient of the log posterior, by the identities of restricted maximum likelihood."""
        p, moved = self.fixed, np.zeros(self.shared.shape[1])
        moment = (beta[p:] ** 2 + np.diag(inverse)[p:]) / scale[self.group] ** 2 - 1
        slope = np.bincount(self.group, moment, len(scale))[:-1].astype(float)  # By the logarithm of each scale
        for batch, root, part in zip(self._batches, roots, white, strict=True):
            back = root.swapaxes(1, 2)
            both = np.zeros((2, *batch.data.shape))
            # One product of two large matrices, not one for each block.
            both.reshape(2, -1, part.shape[1])[:, batch.own] = (
                part, np.column_stack([part[:, :-1] @ inverse.ravel()[batch.places], part[:, -1]]),
            )  # fmt: skip
            solved, spread = back @ both
            excess = spread @ solved.swapaxes(1, 2) - back @ root
            moved += ((excess @ batch.shared) * batch.shared).sum(axis=(0, 1))
            moved += np.einsum("bii,bie->e", excess, batch.independent)
        slope[: len(moved)] += scale[: len(moved)] ** 2 * moved
        slope[-1:] += slope[list(self.multiples)].sum()
        # Derivative of the logarithm of each scale to its coordinate: normal density over half-t density.
        ratio = self._ratio(z)
        tail = np.exp(0.5 * (self.freedom + 1) * np.log1p(ratio**2 / self.freedom) - 0.5 * z**2)
        return np.asarray(slope * 0.5 * self._density_ratio * tail / ratio - z)

    @cached_property
    def _density_ratio(self) -> np.ndarray:
        """Density of the standard normal distribution over that of each prior's t distribution, both at 0."""
        from scipy.special import poch

        return np.asarray(np.sqrt(self.freedom / 2) / poch(self.freedom / 2, 0.5))

    def covariance_of(self, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Covariance of the errors of rows, at one point or at many, (..., rows, rows)."""
        variances = self.scales(z)[..., : self.shared.shape[1]] ** 2
        block, shared = np.searchsorted(self.starts, rows, side="right"), self.shared[rows]
        common = (block[:, None] == block) * ((shared * variances[..., None, :]) @ shared.T)
        alone = self.noise[rows] + variances @ self.independent[rows].T
        return np.asarray(common + alone[..., None] * np.eye(len(rows)))

    def scales(self, z: np.ndarray) -> np.ndarray:
        """Return the scales, half-t quantiles of the normal probability of z, and 1 for effects of no learned scale."""
        scale = self.prior * self._ratio(z)
        scale[..., list(self.multiples)] *= scale[..., -1:]
        return np.concatenate([scale, np.ones_like(scale[..., :1])], axis=-1)

    def _ratio(self, z: np.ndarray) -> np.ndarray:
        from scipy import special

        return np.asarray(-special.stdtrit(self.freedom, 0.5 * special.ndtr(-np.maximum(z, NO_SCALE))))


def _inverse(m: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the inverse of a matrix of unit diagonal, and half the logarithm of the inverse's determinant."""
    from scipy.linalg import lapack

    try:
        lower = np.linalg.cholesky(m)
    except np.linalg.LinAlgError:  # Some eigenvalues are rounding errors: raise them.
        values, vectors = np.linalg.eigh(m)
        values = np.maximum(values, 1e-10)
        return (vectors / values) @ vectors.T, -0.5 * np.log(values).sum()
    half = lapack.dpotri(lower.T)[0]  # Its lower triangle stays empty.
    inverse = half + half.T
    np.einsum("ii->i", inverse)[...] /= 2
    return inverse, -np.log(np.diag(lower)).sum()


@dataclass(frozen=True)
class SplitNormal:
    mode: np.ndarray  # (scales,)
    root: np.ndarray  # (scales, scales) Symmetric square root of the inverse curvature
    widths: np.ndarray  # (2, scales) Widths below and above the mode, relative to those of ``root``
    top: float  # Log density of the posterior at the mode

    def points(self, count: int) -> np.ndarray:
        """Fixed points of low discrepancy, (count, scales)."""
        from scipy import special, stats

        below, above = self.widths
        sobol = stats.qmc.Sobol(len(self.mode), seed=26).random(count)
        u, total = np.maximum(sobol, 1e-9), below + above  # Sobol points lie in [0, 1)
        half = np.where(u * total < below, u * total / (2 * below), 1 - (1 - u) * total / (2 * above))
        return np.asarray(self.mode + np.where(half < 0.5, below, above) * special.ndtri(half) @ self.root)

    def log_density(self, at: np.ndarray) -> np.ndarray:
        """Up to a constant that all modes share."""
        x = np.linalg.solve(self.root, (at - self.mode).T).T
        return np.asarray(-0.5 * ((x / np.where(x < 0, *self.widths)) ** 2).sum(axis=1) - self.log_volume)

    @property
    def log_volume(self) -> float:
        return float(np.linalg.slogdet(self.root)[1] + np.log(self.widths.mean(axis=0)).sum())


_KEPT: dict[bytes, "ScaleMixture"] = {}  # The last used come last
_LOCK = Lock()  # Fits may run in threads


def posterior_of(model: MixedModel) -> "ScaleMixture":
    """Return the posterior, which is kept a while: reports, comparisons and plans fit the same tests again."""
    key = sha256(pickle.dumps([getattr(model, one.name) for one in fields(model)])).digest()
    with _LOCK:
        found = _KEPT.pop(key, None)
    found = found or integrate(model)
    with _LOCK:
        _KEPT[key] = found
        while sum(one.stacked[1].nbytes for one in _KEPT.values()) > KEPT_BYTES:
            del _KEPT[next(iter(_KEPT))]
    return found


def integrate(model: MixedModel, points: int = POINTS) -> "ScaleMixture":
    """Integrate over the scales: points about each mode, weighted by the posterior over the proposal."""
    if not len(model.prior):
        nothing = np.zeros(0)
        return ScaleMixture(model, nothing, nothing[None], np.ones(1), stack([model.conditional(nothing)]))
    modes, densities = search(model), list[SplitNormal]()
    known: dict[bytes, Conditional] = {}  # A longer Sobol sequence begins with the points of the shorter one
    while True:
        densities += [_split_normal(model, mode) for mode, _ in modes[len(densities) :]]
        mixture, weight = _sample_modes(model, densities, points, known)
        heaviest = int(weight.argmax())
        if weight[heaviest] < HEAVY or len(modes) == MOST_MODES:
            return mixture
        more = _distinct([*modes, _find_mode(model, mixture.points[heaviest])])
        if len(more) == len(modes):
            return mixture
        modes = more


def _sample_modes(
    model: MixedModel, densities: list[SplitNormal], points: int, known: dict[bytes, Conditional]
) -> tuple["ScaleMixture", np.ndarray]:
    """Return the mixture, with truncated importance weights, and the weights before truncation."""
    sizes = np.array([one.top + one.log_volume for one in densities])
    share = np.exp(sizes - sizes.max())
    share = np.maximum(share / share.sum(), LEAST_SHARE)
    # Powers of two keep a Sobol sequence balanced.
    counts = 2 ** np.ceil(np.log2(points * share / share.sum())).astype(int)
    drawn = np.vstack([one.points(count) for one, count in zip(densities, counts, strict=True)])
    logs = [np.log(count) + one.log_density(drawn) for one, count in zip(densities, counts, strict=True)]
    within = np.clip(drawn, LOWEST, HIGHEST)
    known |= {z.tobytes(): model.conditional(z) for z in within if z.tobytes() not in known}
    parts = [known[z.tobytes()] for z in within]
    log_weight = np.array([one.log_density for one in parts]) - np.logaddexp.reduce(logs)
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    truncated = np.minimum(weight, np.sqrt(points) / len(weight))
    mode = densities[int(sizes.argmax())].mode
    return ScaleMixture(model, mode, within, truncated / truncated.sum(), stack(parts)), weight


def search(model: MixedModel) -> list[tuple[np.ndarray, float]]:
    """Find modes of the scales and their log densities, from small effects and from each rival explanation."""
    small = np.full(len(model.prior), SMALL)
    starts = [small, *(np.where(np.arange(len(small)) == scale, LARGE, small) for scale in model.confounding_scales)]
    return _distinct(sorted((_find_mode(model, start) for start in starts), key=lambda one: -one[1]))


def _find_mode(model: MixedModel, start: np.ndarray) -> tuple[np.ndarray, float]:
    from scipy import optimize

    minimize: Any = optimize.minimize

    def descend(z: np.ndarray) -> tuple[float, np.ndarray]:
        at = model.conditional(z, gradient=True)
        return -at.log_density, -at.gradient

    bounds, options = [(LOWEST, HIGHEST)] * len(start), {"maxiter": 100, "ftol": 1e-4}
    found = minimize(descend, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(found.x), -float(found.fun)


def _distinct(found: list[tuple[np.ndarray, float]]) -> list[tuple[np.ndarray, float]]:
    """Return the modes that are far from any earlier one, and not much less likely than the first."""
    modes: list[tuple[np.ndarray, float]] = []
    for at, value in found:
        near = any(np.abs(at - mode).max() < APART for mode, _ in modes)
        if not near and value > found[0][1] - LESS_LIKELY:
            modes.append((at, value))
    return modes


def _split_normal(model: MixedModel, mode: np.ndarray) -> SplitNormal:
    """Fit a split normal density: curvature by differences of the gradient, widths by the density on either side."""

    def slope(z: np.ndarray) -> np.ndarray:
        return model.conditional(z, gradient=True).gradient

    here = slope(mode)
    curvature = np.array([(here - slope(mode + e)) / STEP for e in STEP * np.eye(len(mode))])
    values, vectors = np.linalg.eigh(0.5 * (curvature + curvature.T))
    values = np.maximum(values, LEAST_CURVATURE)
    # Newton's steps, so that the mode does not depend on where the search stopped.
    for _ in range(2):
        mode = np.clip(mode + (vectors / values) @ vectors.T @ here, LOWEST, HIGHEST)
        here = slope(mode)
    # The symmetric root does not depend on sign and order of the eigenvectors, which differ between libraries.
    root, top = (vectors / np.sqrt(values)) @ vectors.T, model.conditional(mode).log_density
    logs = [[model.conditional(mode + step * axis).log_density for axis in root] for step in (-REACH, REACH)]
    widths = REACH / np.sqrt(2 * np.maximum(top - np.array(logs), 0.0) + 1e-12)
    return SplitNormal(mode, root, np.clip(widths, NARROW, WIDE), top)


def stack(parts: list[Conditional]) -> tuple[np.ndarray, np.ndarray]:
    """Return means and covariances of coefficients and effects, (draws, p + q) and (draws, p + q, p + q)."""
    return np.stack([part.mean for part in parts]), np.stack([part.covariance for part in parts])


@dataclass(frozen=True)
class ScaleMixture:
    """A mixture of Gaussians, one for each point of the scales."""

    model: MixedModel
    mode: np.ndarray
    points: np.ndarray  # (draws, scales) coordinates
    weights: np.ndarray
    stacked: tuple[np.ndarray, np.ndarray]  # Means and covariances of coefficients and effects, by ``stack``

    @cached_property
    def _combined(self) -> np.ndarray:
        """Matrix from coefficients and effects to the coefficients of the best-fitting terms, (p, p + q)."""
        return np.hstack([np.eye(self.model.fixed), self.model.absorbed])

    @cached_property
    def means(self) -> np.ndarray:
        """Coefficients of each draw, (draws, p)."""
        return np.asarray(self.stacked[0] @ self._combined.T)

    @cached_property
    def covariances(self) -> np.ndarray:
        """Covariance of each draw, (draws, p, p)."""
        return np.asarray(self._combined @ self.stacked[1] @ self._combined.T)

    @cached_property
    def shifts(self) -> np.ndarray:
        """Change of each coefficient per unit change of an effect, (p, q)."""
        # Regression of coefficients on effects. Data that contradict a unit effect do not reduce the change: other
        # effects may have absorbed it.
        covariances, p = self.stacked[1], self.model.fixed
        slopes = self._combined @ covariances[:, :, p:] / np.diagonal(covariances, axis1=1, axis2=2)[:, None, p:]
        return np.asarray(np.tensordot(self.weights, slopes, 1))
