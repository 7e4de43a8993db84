"""Constrained least squares, exact: bounded active set on the factor of the scaled matrix, then checked."""

from dataclasses import dataclass

import numpy as np

KKT_TOLERANCE = 1e-8


@dataclass(frozen=True)
class Kkt:
    """Residuals of the Karush-Kuhn-Tucker conditions, relative to the largest entry of g."""

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
    """Solution of the bounded least-squares problem."""

    z: np.ndarray  # (p,) Scaled parameters
    at_bound: np.ndarray  # (p,) True at a bound
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


# Active bounds of stacks of small problems at once: a primal-dual active set.
# Smallest singular value, over the largest, that counts; sums of products keep about eight digits of it.
RANK_TOLERANCE = 1e-6

# Changes of the active set before a problem is given up.
ROUNDS = 25

# Added to the unit diagonal: keeps directions without data at rest, a tenth of what still counts as data.
RIDGE = 0.1 * RANK_TOLERANCE**2


def active_set(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper for a stack: z (n, p), and the problems left open (k,)."""
    # h (n, p, p); g (n, p); lower, upper (p,)
    # Guess which parameters sit at a bound, solve the rest directly, put at their bound those that left it, free those
    # whose multiplier has the wrong sign, until nothing changes. A problem in which something still does is open.
    # Hintermueller, Ito, Kunisch (2002), The primal-dual active set strategy as a semismooth Newton method.
    held = np.zeros(g.shape, np.int8)  # -1 at the lower bound, +1 at the upper
    z = np.empty_like(g)
    left = np.arange(len(g))
    for _ in range(ROUNDS):
        best = _with_held(h[left], g[left], held[left], lower, upper)
        z[left] = best
        push = g[left] - np.einsum("nij,nj->ni", h[left], best)
        after = _held(best, push, held[left], lower, upper)
        changed = (after != held[left]).any(axis=1)
        held[left] = after
        left = left[changed]
        if not left.size:
            break
    return z, left


def _held(z: np.ndarray, push: np.ndarray, held: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Return the parameters beyond a bound, or at one and pushed beyond by the data."""
    below = np.where(held == -1, push < 0, z < lower)
    above = np.where(held == 1, push > 0, z > upper)
    return above.astype(np.int8) - (below & ~above).astype(np.int8)


def _with_held(h: np.ndarray, g: np.ndarray, held: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Solve with some parameters held at their bounds."""
    free = held == 0
    fixed = np.where(held < 0, lower, np.where(held > 0, upper, 0.0))
    right = np.where(free, g - np.einsum("nij,nj->ni", h, fixed), 0.0)
    matrix = h * (free[:, :, None] & free[:, None, :])
    diagonal = np.arange(h.shape[-1])
    matrix[:, diagonal, diagonal] = np.where(free, matrix[:, diagonal, diagonal] + RIDGE, 1.0)
    return fixed + np.linalg.solve(matrix, right[..., None])[..., 0]


# Thousands of small constrained fits at once: the same active-set conditions as ``solve``, on stacked arrays.
CHUNK = 4096


def solve_many(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper for every problem of a stack, (n, p)."""
    # h (n, p, p); g (n, p); lower, upper (p,)
    # By the active set of ``solve``; the few that it leaves open are solved one by one.
    h = np.broadcast_to(h, (len(g), *h.shape[-2:]))
    parts = [slice(i, i + CHUNK) for i in range(0, len(g), CHUNK)]
    return np.concatenate([_chunk(h[part], g[part], lower, upper) for part in parts]) if parts else np.empty_like(g)


def _chunk(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    z, left = active_set(h, g, lower, upper)
    for i in left:
        z[i] = solve(h[i], g[i], lower, upper).z
    return z
