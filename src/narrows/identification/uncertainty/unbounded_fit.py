"""What the data say of each coefficient by itself: the fit with its bounds let go, but those that the data reject."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.identification.regression.problem import Problem
from narrows.identification.uncertainty.error_model import (
    LackOfFit,
    Repeatability,
    corrected,
    covariance,
    lack_of_fit,
    pseudo_inverse,
    repeatability,
)
from narrows.identification.uncertainty.linear_estimator import LinearEstimator, estimator
from narrows.identification.uncertainty.run_errors import RunErrors
from narrows.identification.uncertainty.second_level import SecondLevel, second_level

# Standard errors beyond a bound at which the data reject it.
CERTAIN = 2.0
# Degrees of freedom of a variance that is assumed and not estimated.
MANY = 1000.0
# Of the assumed variance, at least, when estimates are compared by the scatter that the data show.
LEAST_SCATTER = 0.1


@dataclass(frozen=True)
class ErrorModel:
    """The fit on motions and the errors about it, in scaled parameters."""

    level: SecondLevel  # The motions, held parameters taken out
    errors: RunErrors  # Corrected by repeats
    repeats: dict[str, Repeatability]  # By force, what repeats show
    fit: tuple[LackOfFit, ...]  # By force
    theta: np.ndarray  # (p,) The fit without bounds, but for those that the data reject
    held: np.ndarray  # (p,) Parameters held at a bound
    best: LinearEstimator  # That fit
    covariance: np.ndarray  # (blocks, q, q) Of the motions' errors, widened by lack of fit
    # (blocks, q, q) The same by the scatter that the data show, which may be less than what is assumed
    shown: np.ndarray
    factor: np.ndarray  # (forces,) Variance over the assumed one, of each force, in either
    factor_shown: np.ndarray  # (forces,) Variance over the assumed one, of each force, in either

    @cached_property
    def of_theta(self) -> np.ndarray:
        """Covariance of the parameters, (p, p)."""
        return self.best.covariance(self.covariance)

    @cached_property
    def freedom(self) -> np.ndarray:
        """Degrees of freedom of each force's variance: many where it is the assumed one."""
        return np.array([force.freedom if force.scatter > 1 else MANY for force in self.fit])

    @cached_property
    def left_out(self) -> list[LinearEstimator]:
        """The fit without each motion."""
        level = self.level
        count = int(level.motion.max()) + 1
        flat = level.d.reshape(level.forces, count, *level.d.shape[1:])
        grams = (np.swapaxes(flat, 2, 3) @ flat).sum(axis=0)
        inverses, known = pseudo_inverse(grams.sum(axis=0) - grams)
        masks = (level.motion[None] != np.arange(count)[:, None])[:, :, None, None]
        return [LinearEstimator(level.d * m, p, k) for m, p, k in zip(masks, inverses, known, strict=True)]

    @cached_property
    def jackknife(self) -> tuple[np.ndarray, np.ndarray]:
        """Standard error of each parameter by leaving out each motion, and its degrees of freedom; each (p,)."""
        # (M - 1)/M times the sum of squares of what each motion moves. Its freedom is that of a sum of squares of
        # numbers with the covariance that the error model gives them; where a motion alone determines a parameter both
        # are the error model's.
        # MacKinnon, Nielsen, Webb (2023), Fast and reliable jackknife and bootstrap methods for cluster-robust
        # inference. Satterthwaite (1946), An approximate distribution of estimates of variance components.
        moves, rows = [], []
        size = self.level.d.shape[2]
        root = np.linalg.cholesky(self.covariance)
        for one in self.left_out:
            change = one.z @ one.inverse.T - self.best.z @ self.best.inverse.T
            rows.append((np.swapaxes(root, 1, 2) @ change).reshape(-1, size))
            moves.append(np.tensordot(change, self.level.y, axes=((0, 1), (0, 1))))
        moved, errors = np.array(moves), np.array(rows)
        count = len(moved)
        std = np.sqrt((count - 1) / count * (moved**2).sum(axis=0))
        parts = errors.transpose(2, 0, 1)
        gram = parts @ np.swapaxes(parts, 1, 2)
        trace, square = np.trace(gram, axis1=1, axis2=2), (gram**2).sum(axis=(1, 2))
        freedom = np.where(square > 0, trace**2 / np.where(square > 0, square, 1.0), MANY)
        pinned = ~np.all([one.known for one in self.left_out], axis=0)
        model = np.sqrt(np.maximum(np.diag(self.of_theta), 0.0))
        return np.where(pinned, model, std), np.where(pinned, MANY, freedom)


@dataclass(frozen=True)
class UnboundedFit:
    """Estimates, standard errors and their covariance, a number for each coefficient."""

    # A coefficient's bound says nothing of its error, so intervals start from the fit that does not know the bounds.
    # Where the data put a coefficient beyond its bound for certain, the others are seen with it held there.

    values: np.ndarray  # (n,) Best values without the bounds that the data allow
    # (n,) Standard errors by the error model, or by what each motion moves where that reaches farther, and over what
    # other fits show; of a held coefficient 0
    std: np.ndarray
    # (n, n) By the error model, each force's block times the median of its ``std`` over the error model's, squared:
    # one number for each force, so that what coefficients determine together stays determined
    covariance: np.ndarray
    held: np.ndarray  # (n,) Which are held at a bound that the data reject
    counts: np.ndarray  # (n,) Degrees of freedom of each standard error, and one


def error_model(
    problem: Problem, equations: NormalEquations, motions: DistinctMotions, errors: RunErrors
) -> ErrorModel:
    """Let the bounds go, hold again one by one those that the data reject, and set up the errors about it."""
    terms = problem.terms
    repeats = {
        force: repeatability(equations, motions, force, [term.name for term in part])
        for force, part in terms.forces.items() if part
    }  # fmt: skip
    known = corrected(errors, repeats)
    level = second_level(equations, motions, problem)
    assumed = np.ones(level.forces)
    held, theta = np.zeros(len(problem.scale), bool), np.zeros(len(problem.scale))
    while True:
        free = level.less(theta, held)
        best = estimator(free.d)
        theta = np.where(held, theta, best.values(free.y))
        v = covariance(level, level.d @ theta, known, assumed)
        more = _rejected(problem, theta, np.sqrt(np.diag(best.covariance(v))), held | ~best.known)
        if more is None:
            break
        held[more] = True
        theta[more] = np.clip(theta[more], problem.lower[more], problem.upper[more])
    fit = lack_of_fit(free, v)
    scatter = np.array([force.scatter for force in fit])
    wide, shown = np.maximum(scatter, 1.0), np.maximum(scatter, LEAST_SCATTER)
    forces = (level.d @ theta, known)
    return ErrorModel(
        free,
        known,
        repeats,
        fit,
        theta,
        held,
        best,
        covariance(level, *forces, wide),
        covariance(level, *forces, shown),
        wide,
        shown,
    )


def _rejected(problem: Problem, theta: np.ndarray, std: np.ndarray, left: np.ndarray) -> int | None:
    """The parameter that the data put farthest beyond its bound for certain, if any."""
    excess = np.maximum(problem.lower - theta, theta - problem.upper) - CERTAIN * std
    excess[left] = -np.inf
    worst = int(excess.argmax())
    return worst if excess[worst] > 0 else None


def unbounded_fit(problem: Problem, model: ErrorModel, std: np.ndarray, counts: np.ndarray) -> UnboundedFit:
    """Bring the error model's fit to coefficients."""
    # std (n,); counts (n,)
    slots = np.array([problem.slot[name] for name in problem.terms.names])
    scale, held = problem.scale[slots], model.held[slots]
    plain = np.sqrt(np.maximum(np.diag(model.of_theta), 0.0))[slots]
    std = np.where(held, 0.0, std)
    stretch = _of_forces(problem, np.where(plain > 0, std / np.where(plain > 0, plain, 1.0), np.nan)) / scale
    covariance = model.of_theta[np.ix_(slots, slots)] * np.outer(stretch, stretch)
    return UnboundedFit(problem.coefficients(model.theta), std / scale, covariance, held, counts)


def _of_forces(problem: Problem, stretch: np.ndarray) -> np.ndarray:
    """The median of each force's coefficients, (n,): one for all, so that what trades against each other cancels."""
    middle, start = np.ones(len(stretch)), 0
    for part in problem.terms.forces.values():
        own = stretch[start : start + len(part)]
        if np.isfinite(own).any():
            middle[start : start + len(part)] = np.nanmedian(own)
        start += len(part)
    slots = np.array([problem.slot[name] for name in problem.terms.names])
    return np.array([middle[slots == slot].max() for slot in slots])


def freedoms(problem: Problem, model: ErrorModel) -> np.ndarray:
    """Return the degrees of freedom of each coefficient's variance, (n,); tied ones have the fewest of theirs."""
    forces = [part for part in problem.terms.forces.values() if part]
    of_force = np.array([model.freedom[i] for i, part in enumerate(forces) for _ in part])
    slots = np.array([problem.slot[name] for name in problem.terms.names])
    return np.array([of_force[slots == slot].min() for slot in slots])
