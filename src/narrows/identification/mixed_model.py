"""A linear mixed model: coefficients, random effects with learned scales, and errors that runs and motions share.

``y = X theta + Z b + e``: the effects b of a group have the variance of that group's scale squared, and the rows of a
block (one motion and one force) share ``c I + a f f' + z 1 1'``: noise and form error, gain, zero. Scales have half-t
priors and are integrated over for credible intervals, in coordinates of which each is standard normal before the data.

References
----------
Henderson (1975), Best linear unbiased estimation and prediction under a selection model: the equations.
Gelman (2006), Prior distributions for variance parameters in hierarchical models: half-t priors of scales.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, wraps
from typing import ParamSpec, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

P = ParamSpec("P")
R = TypeVar("R")
# Share of a coefficient's own information, added where rounding leaves dependent columns.
JITTERS = (0.0, 1e-10, 1e-8, 1e-6, 1e-4)
SHAPES = 3  # Number of shapes of errors that all rows of a block share
# Coordinate of a scale of 1e-6 of its prior, which counts as 0; SciPy's quantile of t is exactly 0 a little below.
NO_SCALE = -5.0
RIDGE = 1e-6  # Prior precision of a coefficient over the force's level: it only keeps the solution finite


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Run a function with one thread of the BLAS, which is faster for matrices as small as these."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        import scipy.linalg.lapack  # noqa: F401  # SciPy's own BLAS, which a limit set before its import does not reach

        with threadpool_limits(limits=1):
            return function(*args, **kwargs)

    return run


@dataclass(frozen=True)
class BlockErrors:
    """Error components of a block's rows; all arrays but ``shapes`` have a value for each block."""

    starts: np.ndarray  # first row
    shapes: np.ndarray  # (rows, 3) force of the fit, force of its bank, a constant of the force's root mean square
    noise: np.ndarray  # variance of each row by the noise within runs
    form: np.ndarray  # variance of each row for a form error of one
    scatter: np.ndarray  # variance of each row for a scatter from run to run of one
    runs: np.ndarray  # how many runs are averaged
    is_mean: np.ndarray  # whether it is a motion's mean; repeats share errors of form
    form_scale: np.ndarray  # which scale is the form's; gain has scale 0, the bank's form 1, scatter 2
    zero_scale: np.ndarray  # which scale is the zero's


@dataclass(frozen=True)
class MixedModel:
    """The data and the priors."""

    x: np.ndarray  # (rows, p + q) columns of coefficients, then of effects, each of about unit size
    y: np.ndarray  # (rows,) measured
    fixed: int  # number p of coefficients
    group: np.ndarray  # (q,) the scale of each effect; the number of scales for effects whose scale is not learned
    errors: BlockErrors  # that rows share
    # (scales,) of each half-t prior: of errors of blocks, then of groups of effects; 0 leaves one out
    prior: np.ndarray
    freedom: np.ndarray  # (scales,) degrees of freedom of each prior; many make it half-normal
    rivals: tuple[int, ...] = ()  # scales of effects that may explain by themselves what a coefficient does
    # (p, q) what a coefficient of the best-fitting terms takes of each effect that is part of the truth
    taken: np.ndarray | None = None

    @cached_property
    def learned(self) -> np.ndarray:
        """Scales that are not said to be 0."""
        return np.asarray(np.flatnonzero(self.prior > 0))

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

    def at(self, z: np.ndarray, gradient: bool = False) -> "Conditional":
        """Solve for coefficients and effects at given scales: generalised least squares."""
        scale = self.scales(z)
        d, c = self._variances(scale)
        white, kernel, logdet = self._whitened(d, c)
        h = white.T @ white
        # In units of their standard deviations, so that the matrix stays well conditioned.
        unit = np.concatenate([1 / np.sqrt(np.diag(h)[: self.fixed] + RIDGE), scale[self.group]])
        precision = np.concatenate([RIDGE * unit[: self.fixed] ** 2, np.ones(len(self.group))])
        m = h[:-1, :-1] * np.outer(unit, unit) + np.diag(precision)
        lower = _factored(m)
        inverse = _inverse(lower) * np.outer(unit, unit)
        beta = inverse @ h[:-1, -1]
        # Residuals and effects, not a difference of large sums: that is rounding where columns depend on each other.
        left = white[:, -1] - white[:, :-1] @ beta
        quadratic = left @ left + float((precision * (beta / unit) ** 2).sum())
        logs = np.log(np.diag(lower)).sum() - np.log(unit[: self.fixed]).sum()
        value = -0.5 * (logdet + quadratic) - logs - 0.5 * float(z @ z)
        slope = self._gradient(z, scale, beta, inverse, kernel, c) if gradient else np.zeros(0)
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

    def covariance_of(self, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Covariance of the errors of some rows, without effects."""
        d, c = self._variances(self.scales(z))
        block = self._block[rows]
        w = self.errors.shapes[rows]
        same = block[:, None] == block
        return np.asarray(np.where(same, (w * d[block]) @ w.T, 0.0) + np.diag(c[block]))

    def scales(self, z: np.ndarray) -> np.ndarray:
        """Every scale, the half-t quantile of the normal probability of z; 1 for effects whose scale is not learned."""
        return np.append(self.prior * self._ratio(z), 1.0)

    def _ratio(self, z: np.ndarray) -> np.ndarray:
        """Every scale over its prior."""
        from scipy import special

        return np.asarray(-special.stdtrit(self.freedom, 0.5 * special.ndtr(-np.maximum(z, NO_SCALE))))

    def _variances(self, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Variance of each shape (blocks, 3), and of each row by itself (blocks,)."""
        e = self.errors
        form = np.where(e.is_mean, scale[e.form_scale] ** 2, 0.0)
        bank = np.where(e.is_mean, scale[1] ** 2, 0.0)
        shapes = [scale[0] ** 2 / e.runs + 0.5 * form, bank, scale[e.zero_scale] ** 2 / e.runs]
        return np.stack(shapes, axis=1), e.noise + form * e.form + scale[2] ** 2 * e.scatter

    def _gradient(
        self, z: np.ndarray, scale: np.ndarray, beta: np.ndarray, inverse: np.ndarray,
        kernel: np.ndarray, c: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Gradient of the log posterior by each coordinate: the identities of restricted maximum likelihood."""
        p, e = self.fixed, self.errors
        moment = (beta[p:] ** 2 + np.diag(inverse)[p:]) / scale[self.group] ** 2 - 1
        slope = np.bincount(self.group, moment, len(z) + 1)[:-1]  # By the logarithm of each scale
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
        slope[1] += (2 * scale[1] ** 2 * to_shape[:, 1])[e.is_mean].sum()
        slope[2] += (2 * scale[2] ** 2 * e.scatter * to_row).sum()
        form = np.where(e.is_mean, 2 * scale[e.form_scale] ** 2 * (0.5 * to_shape[:, 0] + e.form * to_row), 0.0)
        np.add.at(slope, e.form_scale, form)
        np.add.at(slope, e.zero_scale, 2 * scale[e.zero_scale] ** 2 / e.runs * to_shape[:, 2])
        return np.asarray(slope * self._log_rate(z) - z)

    def _log_rate(self, z: np.ndarray) -> np.ndarray:
        """Derivative of the logarithm of each scale to its coordinate: normal density over half-t density."""
        from scipy import special

        ratio, nu = self._ratio(z), self.freedom
        log_t = special.gammaln(0.5 * (nu + 1)) - special.gammaln(0.5 * nu) - 0.5 * np.log(nu * np.pi)
        log_t -= 0.5 * (nu + 1) * np.log1p(ratio**2 / nu)
        return np.asarray(0.5 * np.exp(-0.5 * z**2 - 0.5 * np.log(2 * np.pi) - log_t) / ratio)


def _factored(m: np.ndarray) -> np.ndarray:
    """Cholesky factor of a matrix of unit diagonal, with as little added to its diagonal as that needs."""
    for jitter in JITTERS:
        try:
            return np.linalg.cholesky(m + jitter * np.eye(len(m)))
        except np.linalg.LinAlgError:
            continue
    # Beyond that the matrix is rounding in some direction: there its eigenvalues are raised.
    values, vectors = np.linalg.eigh(m)
    raised = (vectors * np.maximum(values, JITTERS[-1])) @ vectors.T
    return np.linalg.cholesky(raised + JITTERS[1] * np.eye(len(m)))


def _inverse(lower: np.ndarray) -> np.ndarray:
    """Inverse of a matrix by its Cholesky factor."""
    from scipy.linalg import lapack

    half = np.tril(lapack.dpotri(lower, lower=1)[0])
    return np.asarray(half + np.tril(half, -1).T)


@dataclass(frozen=True)
class Conditional:
    """Coefficients and effects at given scales."""

    log_density: float  # Log density of the scales' posterior, up to a constant
    mean: np.ndarray  # (p + q,)
    covariance: np.ndarray  # (p + q, p + q)
    gradient: np.ndarray  # (scales,) of the log density; empty unless asked for
