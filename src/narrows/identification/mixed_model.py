"""A linear mixed model: coefficients, random effects with learned scales, and errors that runs and motions share.

``y = X theta + Z b + e``: the effects b of a group have the variance of that group's scale squared, and the rows of a
block (one motion and one force) share ``c I + a f f' + z 1 1'``: noise and form error, gain, zero. Log scales have
priors; the posterior of the coefficients is averaged over them.

References
----------
Henderson (1975), Best linear unbiased estimation and prediction under a selection model: the equations.
Gelman (2006), Prior distributions for variance parameters in hierarchical models: half-t priors of scales.
Ionides (2008), Truncated importance sampling: the weights.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

LOWEST, HIGHEST = -5.0, 5.0  # of log scales over their priors
# Of a coefficient's own information, added where rounding leaves columns that depend on each other.
JITTERS = (0.0, 1e-10, 1e-8, 1e-6, 1e-4)
SHAPES = 3  # of errors that all rows of a block share
POINTS, SEED = 128, 26
TAIL = 8.0  # degrees of freedom of the draws of log scales
LEAST_CURVATURE = 0.3  # of the log density: a scale that the data do not determine is drawn within a factor of exp(1.8)
APART, LESS_LIKELY = 1.0, 8.0  # log scales and log densities by which two modes are two and both count
LARGE = 4.0  # log scale at which the search for a rival explanation begins
RIDGE = 1e-6  # prior precision of a coefficient, over the force's level: so weak that it only keeps all finite


@dataclass(frozen=True)
class BlockErrors:
    """What the errors of a block's rows are made of; all arrays but ``shapes`` have a value for each block."""

    starts: np.ndarray  # first row
    shapes: np.ndarray  # (rows, 3) force of the fit, force of its bank, a constant of the force's root mean square
    noise: np.ndarray  # variance of each row by the noise within runs
    form: np.ndarray  # variance of each row for a form error of one
    scatter: np.ndarray  # variance of each row for a scatter from run to run of one
    runs: np.ndarray  # how many runs are averaged
    is_mean: np.ndarray  # whether it is a motion's mean; repeats share errors of form
    zero_group: np.ndarray  # which scale is the zero's; gain has scale 0, form 1, the bank's form 2, scatter 3


@dataclass(frozen=True)
class MixedModel:
    """The data and the priors."""

    x: np.ndarray  # (rows, p + q) columns of coefficients, then of effects, each of about unit size
    y: np.ndarray  # (rows,) measured
    fixed: int  # number p of coefficients
    group: np.ndarray  # (q,) the scale of each effect; the number of scales for effects whose scale is not learned
    errors: BlockErrors  # that rows share
    # (scales,) of each half-t prior: gain, form, the bank's form, scatter, zeros, groups of effects; 0 leaves one out
    prior: np.ndarray
    freedom: np.ndarray  # (scales,) degrees of freedom of each prior; many make it half-normal
    rivals: tuple[int, ...] = ()  # scales of effects that may explain by themselves what a coefficient does
    # (p, q) what a coefficient of the best-fitting terms takes of each effect that is part of the truth
    taken: np.ndarray | None = None

    @cached_property
    def _joined(self) -> np.ndarray:
        return np.column_stack([self.x, self.y])

    @cached_property
    def _shape_products(self) -> tuple[np.ndarray, np.ndarray]:
        """Shapes times all columns (blocks, 3, m), and times each other (blocks, 3, 3)."""
        w, starts = self.errors.shapes, self.errors.starts
        crossed = np.stack([np.add.reduceat(w[:, [i]] * self._joined, starts, axis=0) for i in range(SHAPES)], axis=1)
        own = np.add.reduceat(w[:, :, None] * w[:, None, :], starts, axis=0)
        return crossed, own

    @cached_property
    def _sizes(self) -> np.ndarray:
        return np.diff(np.append(self.errors.starts, len(self.y)))

    def at(self, log_scale: np.ndarray, gradient: bool = False) -> "Conditional":
        """Solve for coefficients and effects at given scales, exp(log_scale) times their priors."""
        scale = self.scales(log_scale)
        d, c = self._variances(scale)
        white, kernel, logdet = self._whitened(d, c)
        h = white.T @ white
        # In units of their standard deviations, so that the matrix stays well conditioned.
        unit = np.concatenate([1 / np.sqrt(np.diag(h)[: self.fixed] + RIDGE), scale[self.group]])
        precision = np.concatenate([RIDGE * unit[: self.fixed] ** 2, np.ones(len(self.group))])
        m = h[:-1, :-1] * np.outer(unit, unit) + np.diag(precision)
        m, lower = _factored(m)
        inverse = np.linalg.inv(m) * np.outer(unit, unit)
        beta = inverse @ h[:-1, -1]
        quadratic = h[-1, -1] - beta @ h[:-1, -1]
        logs = np.log(np.diag(lower)).sum() - np.log(unit[: self.fixed]).sum()
        value = -0.5 * (logdet + quadratic) - logs + self._log_prior(log_scale)
        slope = self._gradient(log_scale, scale, beta, inverse, kernel, c) if gradient else np.zeros(0)
        return Conditional(value, beta, inverse, slope)

    def _whitened(self, d: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Columns with independent errors of one, the kernel K of B^-1 = 1/c - W K W', and the log determinant of B."""
        crossed, own = self._shape_products
        root = np.sqrt(d)
        values, vectors = np.linalg.eigh(root[:, :, None] * own * root[:, None, :])
        values, half = np.maximum(values, 0.0), root[:, :, None] * vectors
        # Rows of B^-1/2: along each eigenvector they shrink by the root of 1 + value / c; 1/2c is the limit at 0.
        share = values / c[:, None]
        shrunk = np.where(share > 1e-8, 1 - 1 / np.sqrt(1 + share), 0.5 * share)
        ratio = shrunk / np.where(values > 0, values, 1.0)
        along = (half * ratio[:, None, :]) @ (np.swapaxes(half, 1, 2) @ crossed)
        block = self._block
        bent = np.einsum("rs,rsm->rm", self.errors.shapes, along[block])
        white = (self._joined - bent) / np.sqrt(c)[block, None]
        kernel = (half / (c[:, None] * (c[:, None] + values))[:, None, :]) @ np.swapaxes(half, 1, 2)
        return white, kernel, float((self._sizes * np.log(c)).sum() + np.log1p(share).sum())

    @cached_property
    def _block(self) -> np.ndarray:
        """The block of each row."""
        return np.repeat(np.arange(len(self.errors.starts)), self._sizes)

    def covariance_of(self, log_scale: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Covariance of the errors of some rows, without effects."""
        d, c = self._variances(self.scales(log_scale))
        block = self._block[rows]
        w = self.errors.shapes[rows]
        same = block[:, None] == block
        return np.asarray(np.where(same, (w * d[block]) @ w.T, 0.0) + np.diag(c[block]))

    def scales(self, log_scale: np.ndarray) -> np.ndarray:
        """Every scale, and 1 for the effects whose scale is not learned."""
        return np.append(self.prior * np.exp(log_scale), 1.0)

    def _variances(self, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Variance of each shape (blocks, 3), and of each row by itself (blocks,)."""
        e = self.errors
        form = np.where(e.is_mean, scale[1] ** 2, 0.0)
        bank = np.where(e.is_mean, scale[2] ** 2, 0.0)
        shapes = [scale[0] ** 2 / e.runs + 0.5 * form, bank, scale[e.zero_group] ** 2 / e.runs]
        return np.stack(shapes, axis=1), e.noise + form * e.form + scale[3] ** 2 * e.scatter

    def _log_prior(self, log_scale: np.ndarray) -> float:
        """Half-t of each scale, over its logarithm."""
        ratio = np.exp(2 * log_scale)
        # Of a scale that is said to be 0 this is a constant.
        return float((log_scale - 0.5 * (self.freedom + 1) * np.log1p(ratio / self.freedom)).sum())

    def _gradient(
        self, log_scale: np.ndarray, scale: np.ndarray, beta: np.ndarray, inverse: np.ndarray,
        kernel: np.ndarray, c: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Of the log posterior to each log scale: the identities of restricted maximum likelihood."""
        ratio = np.exp(2 * log_scale)
        slope = 1 - (self.freedom + 1) * ratio / (self.freedom + ratio)
        p, e = self.fixed, self.errors
        moment = (beta[p:] ** 2 + np.diag(inverse)[p:]) / scale[self.group] ** 2 - 1
        slope += np.bincount(self.group, moment, len(slope) + 1)[:-1]
        w = e.shapes
        crossed, own = self._shape_products
        # B^-1 applied to all columns, and to the residual.
        solved = self._joined / c[self._block, None] - np.einsum("rs,rsm->rm", w, (kernel @ crossed)[self._block])
        residual = solved[:, -1] - solved[:, :-1] @ beta
        inner = np.add.reduceat(w[:, :, None] * solved[:, None, :], e.starts, axis=0)
        fitted = inner[:, :, -1] - inner[:, :, :-1] @ beta
        spread = np.einsum("bsi,ij,bsj->bs", inner[:, :, :-1], inverse, inner[:, :, :-1], optimize=True)
        back = own / c[:, None, None] - own @ kernel @ own
        to_shape = 0.5 * (fitted**2 + spread - np.diagonal(back, axis1=1, axis2=2))
        trace = self._sizes / c - np.einsum("bij,bji->b", kernel, own)
        left = ((solved[:, :-1] @ inverse) * solved[:, :-1]).sum(axis=1) + residual**2
        to_row = 0.5 * (np.add.reduceat(left, e.starts) - trace)
        slope[0] += (2 * scale[0] ** 2 / e.runs * to_shape[:, 0]).sum()
        slope[1] += (2 * scale[1] ** 2 * (0.5 * to_shape[:, 0] + e.form * to_row))[e.is_mean].sum()
        slope[2] += (2 * scale[2] ** 2 * to_shape[:, 1])[e.is_mean].sum()
        slope[3] += (2 * scale[3] ** 2 * e.scatter * to_row).sum()
        np.add.at(slope, e.zero_group, 2 * scale[e.zero_group] ** 2 / e.runs * to_shape[:, 2])
        return np.asarray(slope)

    @cached_property
    def _learned(self) -> np.ndarray:
        """Scales that are not said to be 0."""
        return np.asarray(np.flatnonzero(self.prior > 0))

    def modes(self) -> list[np.ndarray]:
        """Log scales of the largest posterior density, from small effects and from each rival explanation."""
        from scipy import optimize

        minimize: Any = optimize.minimize

        def descend(log_scale: np.ndarray) -> tuple[float, np.ndarray]:
            at = self.at(log_scale, gradient=True)
            return -at.log_density, -at.gradient

        bounds = [(LOWEST, HIGHEST) if prior > 0 else (0.0, 0.0) for prior in self.prior]
        small = np.where(self.prior > 0, -1.0, 0.0)
        starts = [small, *(np.where(np.arange(len(small)) == scale, LARGE, small) for scale in self.rivals)]
        options = {"maxiter": 100, "ftol": 1e-5}
        found = [minimize(descend, at, jac=True, method="L-BFGS-B", bounds=bounds, options=options) for at in starts]
        found.sort(key=lambda one: float(one.fun))
        modes: list[np.ndarray] = []
        for one in found:
            near = any(np.abs(one.x - mode).max() < APART for mode in modes)
            if not near and one.fun - found[0].fun < LESS_LIKELY:
                modes.append(np.asarray(one.x))
        return modes

    def posterior(self, points: int = POINTS) -> "ScaleMixture":
        """Average over the scales: weighted draws about each mode, from Student's t with mirror images."""
        if not self._learned.size:
            nothing = np.zeros(len(self.prior))
            return ScaleMixture(self, nothing, nothing[None], np.ones(1), [self.at(nothing)])
        rng = np.random.default_rng(SEED)
        modes = self.modes()
        spreads = [self._spread(mode) for mode in modes]
        draws = []
        for mode, (root, _) in zip(modes, spreads, strict=True):
            half = rng.standard_normal((points // len(modes) // 2, len(root)))
            half *= np.sqrt(TAIL / rng.chisquare(TAIL, (len(half), 1)))
            moved = np.tile(mode, (2 * len(half), 1))
            moved[:, self._learned] += np.vstack([half, -half]) @ root.T
            draws.append(np.clip(moved, LOWEST, HIGHEST))
        drawn = np.vstack(draws)
        apart = [(drawn - mode)[:, self._learned] for mode in modes]
        proposal = np.logaddexp.reduce([_log_t(a, *spread) for a, spread in zip(apart, spreads, strict=True)])
        solved = [self.at(draw) for draw in drawn]
        log_weight = np.array([one.log_density for one in solved]) - proposal
        weight = np.exp(log_weight - log_weight.max())
        weight = np.minimum(weight, np.sqrt(points) * weight.mean())
        return ScaleMixture(self, modes[0], drawn, weight / weight.sum(), solved)

    def _spread(self, mode: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Root of the covariance of the log scales, and its inverse: differences of the gradient at the mode."""
        step, learned = 0.1, self._learned
        base = self.at(mode, gradient=True).gradient
        hessian = []
        for i in learned:
            moved = mode.copy()
            moved[i] += step
            hessian.append((base - self.at(moved, gradient=True).gradient)[learned] / step)
        curvature = np.array(hessian)
        values, vectors = np.linalg.eigh(0.5 * (curvature + curvature.T))
        scale = 1 / np.sqrt(np.maximum(values, LEAST_CURVATURE))
        # The symmetric root: it does not change with the signs and the order that a library gives eigenvectors.
        return (vectors * scale) @ vectors.T, (vectors / scale) @ vectors.T


def _log_t(apart: np.ndarray, root: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Log density of Student's t about a mode, up to a constant that all modes share."""
    distance = ((apart @ inverse.T) ** 2).sum(axis=1)
    return np.asarray(-0.5 * (TAIL + len(root)) * np.log1p(distance / TAIL) - np.linalg.slogdet(root)[1])


def _factored(m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A matrix of unit diagonal and its Cholesky factor, with as little added to its diagonal as that needs."""
    for jitter in JITTERS:
        try:
            raised = m + jitter * np.eye(len(m))
            return raised, np.linalg.cholesky(raised)
        except np.linalg.LinAlgError:
            continue
    # Beyond that the matrix is rounding in some direction: there its eigenvalues are raised.
    values, vectors = np.linalg.eigh(m)
    raised = (vectors * np.maximum(values, JITTERS[-1])) @ vectors.T
    return raised, np.linalg.cholesky(raised + JITTERS[1] * np.eye(len(m)))


@dataclass(frozen=True)
class Conditional:
    """Coefficients and effects at given scales."""

    log_density: float  # of the scales' posterior, up to a constant
    mean: np.ndarray  # (p + q,)
    covariance: np.ndarray  # (p + q, p + q)
    gradient: np.ndarray  # (scales,) of the log density; empty unless asked for


@dataclass(frozen=True)
class ScaleMixture:
    """A mixture of Gaussians, one for each draw of the scales."""

    model: MixedModel
    mode: np.ndarray
    log_scales: np.ndarray
    weights: np.ndarray
    parts: list[Conditional]

    @cached_property
    def _combined(self) -> np.ndarray:
        """Coefficients of the best-fitting terms by coefficients and effects, (p, p + q)."""
        p, taken = self.model.fixed, self.model.taken
        return np.hstack([np.eye(p), np.zeros((p, len(self.model.group))) if taken is None else taken])

    @cached_property
    def means(self) -> np.ndarray:
        """Coefficients of each draw, (draws, p)."""
        return np.asarray(np.stack([part.mean for part in self.parts]) @ self._combined.T)

    @cached_property
    def covariances(self) -> np.ndarray:
        """Covariance of each draw, (draws, p, p)."""
        return np.stack([self._combined @ part.covariance @ self._combined.T for part in self.parts])

    @cached_property
    def mean(self) -> np.ndarray:
        """Of the coefficients, (p,)."""
        return np.asarray(self.weights @ self.means)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Of the coefficients, (p, p)."""
        apart = self.means - self.mean
        return np.asarray(np.einsum("d,dij->ij", self.weights, self.covariances) + (apart.T * self.weights) @ apart)

    @cached_property
    def shifts(self) -> np.ndarray:
        """Bias of each coefficient by an effect of one that is there, (p, q)."""
        p = self.model.fixed
        shift = np.zeros((p, len(self.model.group)))
        for weight, draw, part in zip(self.weights, self.log_scales, self.parts, strict=True):
            scale = self.model.scales(draw)
            shift -= weight * (self._combined @ part.covariance[:, p:]) / scale[self.model.group] ** 2
        return shift
