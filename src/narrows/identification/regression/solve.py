"""Constrained least squares, exact: bounded active set on the factor of the scaled matrix, then checked."""

from dataclasses import dataclass

import numpy as np

from narrows.identification.regression.active_set import RANK_TOLERANCE as RANK_TOLERANCE
from narrows.identification.regression.active_set import active_set

KKT_TOLERANCE = 1e-8


@dataclass(frozen=True)
class Kkt:
    """How well a solution meets the Karush-Kuhn-Tucker conditions, relative to the largest entry of g."""

    stationarity: float  # Largest gradient among the free parameters [1]
    multiplier: float  # Most negative multiplier among the bound ones, as a positive number [1]
    infeasibility: float  # Largest distance outside a bound [1]

    @property
    def satisfied(self) -> bool:
        """Whether each is under the tolerance of 1e-8."""
        return max(self.stationarity, self.multiplier, self.infeasibility) <= KKT_TOLERANCE

    def to_dict(self) -> dict[str, bool | float]:
        """Give whether they are met, and how well."""
        return {"satisfied": self.satisfied, "stationarity": self.stationarity, "multiplier": self.multiplier}


@dataclass(frozen=True)
class Solution:
    """What the solver found."""

    z: np.ndarray  # (p,) Scaled parameters
    at_bound: np.ndarray  # (p,) Which of them sit at a bound
    kkt: Kkt  # Check of optimality


def solve(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Solution:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper."""
    # h (p, p); g (p,); lower, upper (p,)
    # A primal-dual active set finds which parameters sit at a bound, SciPy's BVLS on H's factor where it does not come
    # to rest or to an optimum. The free set is then solved anew, so that the result is as exact as a direct solve;
    # directions without data are left at their smallest norm.
    start, left = active_set(h[None], g[None], lower, upper)
    quick = _settled(h, g, start[0], lower, upper)
    if quick.kkt.satisfied and not left.size:
        return quick
    return _settled(h, g, _bvls(h, g, lower, upper), lower, upper)


def _settled(h: np.ndarray, g: np.ndarray, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Solution:
    """Solve once more with what sits at a bound held there."""
    at_bound = (z <= lower) | (z >= upper)
    z = _polished(h, g, np.clip(z, lower, upper), at_bound, lower, upper)
    z = np.where(np.diag(h) > 0, z, np.clip(0.0, lower, upper))
    return Solution(z, at_bound, check(h, g, z, lower, upper))


def _bvls(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """H = V diag(w) V' gives the small least-squares problem ``sqrt(w) V' z = V'g / sqrt(w)``."""
    from scipy.optimize import lsq_linear

    factor, target = _factor(h, g)
    if np.isinf(lower).all() and np.isinf(upper).all():
        return np.asarray(np.linalg.lstsq(factor, target, rcond=None)[0])
    with np.errstate(all="ignore"):  # It divides by steps of zero on its way; what it finds is checked later.
        optimum = lsq_linear(factor, target, (lower, upper), method="bvls", tol=1e-14)
    # Its last step to a bound may stop a rounding short of it: what it holds there is put there.
    return np.select([optimum.active_mask < 0, optimum.active_mask > 0], [lower, upper], optimum.x)


def _factor(h: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    values, vectors = np.linalg.eigh(h)
    kept = values > RANK_TOLERANCE**2 * max(values[-1], 1e-300)
    root = np.sqrt(values[kept])
    return root[:, None] * vectors[:, kept].T, vectors[:, kept].T @ g / root


def _polished(
    h: np.ndarray, g: np.ndarray, z: np.ndarray, at_bound: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """Solve the free set directly; keep what was there if that leaves the bounds."""
    free = ~at_bound
    if not free.any():
        return z
    fixed = g - h[:, at_bound] @ z[at_bound]
    better = z.copy()
    factor, target = _factor(h[np.ix_(free, free)], fixed[free])
    better[free] = np.linalg.lstsq(factor, target, rcond=None)[0]
    inside = (better >= lower).all() and (better <= upper).all()
    return better if inside else z


def check(h: np.ndarray, g: np.ndarray, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Kkt:
    """Measure how far a point is from optimal."""
    # z (p,); lower, upper (p,)
    gradient = (h @ z - g) / max(float(np.abs(g).max(initial=0.0)), 1e-300)
    low, high = z <= lower, z >= upper
    pushed = np.concatenate([-gradient[low & ~high], gradient[high & ~low], [0.0]])
    outside = np.concatenate([lower - z, z - upper, [0.0]])
    free = np.append(np.abs(gradient[~low & ~high]), 0.0)
    return Kkt(float(free.max()), float(pushed.max()), float(outside.max()))
