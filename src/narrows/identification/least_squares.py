"""The paper's joint problem, reduced to one small matrix, and its exact solution within the bounds."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from narrows.errors import InputError, check_choice
from narrows.identification.design_matrix import ONE
from narrows.identification.normal_equations import NormalEquations
from narrows.terms.term import TermTable

Weights = Literal["paper", "variance"]
WEIGHTS = get_args(Weights)
KKT_TOLERANCE = 1e-8
# Smallest singular value, over the largest, that counts; sums of products keep about eight digits of it.
RANK_TOLERANCE = 1e-6
# Added to the unit diagonal: keeps directions without data at 0, a tenth of what still counts as data.
RIDGE = 0.1 * RANK_TOLERANCE**2
# Changes of the active set before a problem is given up.
ROUNDS = 25
# Problems of a stack that are solved at once.
CHUNK = 4096


@dataclass(frozen=True)
class Problem:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper, where z = free parameters x scale."""

    slot: Mapping[str, int]  # The free parameter of each coefficient; tied coefficients share one
    scale: np.ndarray  # (p,) Norm of each parameter's column; 1 where the column is zero
    lower: np.ndarray  # (p,) Bounds of z
    upper: np.ndarray  # (p,) Bounds of z
    weights: Mapping[str, float]  # Weight of each force in the sum
    terms: TermTable  # The terms
    columns: Mapping[str, int]  # Column of the sums of each coefficient's regressor or force

    def normal(self, sums: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Assemble H (..., p, p) and g (..., p) from sums of products (..., m, m)."""
        size = len(self.scale)
        h, g = np.zeros((*sums.shape[:-2], size, size)), np.zeros((*sums.shape[:-2], size))
        for force, terms in self.terms.forces.items():
            # Two coefficients of one force may share a parameter, so add entry by entry.
            for one in terms:
                i, column = self.slot[one.name], self.columns[one.name]
                weight = self.weights[force] / self.scale[i]
                g[..., i] += sums[..., column, self.columns[force]] * weight
                for other in terms:
                    j = self.slot[other.name]
                    h[..., i, j] += sums[..., column, self.columns[other.name]] * weight / self.scale[j]
        return h, g

    def solve(self, sums: np.ndarray) -> "Solution":
        """Fit to the rows behind some sums (m, m)."""
        return solve(*self.normal(sums), self.lower, self.upper)

    def fits(self, sums: np.ndarray) -> np.ndarray:
        """Coefficients (..., n) fitted to the rows behind each of some sums (groups, m, m)."""
        return self.coefficients(solve_many(*self.normal(sums), self.lower, self.upper))

    def coefficients(self, z: np.ndarray) -> np.ndarray:
        """Return the coefficients (..., n) of scaled parameters z (..., p)."""
        return np.asarray((z / self.scale)[..., [self.slot[name] for name in self.terms.names]])

    def named(self, z: np.ndarray) -> dict[str, float]:
        """Return the coefficients of scaled parameters z (p,) by name."""
        return dict(zip(self.terms.names, self.coefficients(z).tolist(), strict=True))


def reduced(equations: NormalEquations, terms: TermTable, weights: Weights = "paper") -> Problem:
    """Set up the joint problem of the paper, columns scaled to one and ties substituted."""
    check_choice("weights", weights, WEIGHTS)
    slot, total = free_parameters(terms), equations.total
    by_force = {f: _weight(equations, total, f) if weights == "variance" else 1.0 for f, t in terms.forces.items() if t}
    size = max(slot.values()) + 1
    square, lower, upper = np.zeros(size), np.full(size, -np.inf), np.full(size, np.inf)
    for force, part in terms.forces.items():
        for term in part:
            i, j = slot[term.name], equations.columns[term.name]
            square[i] += by_force[force] * total[j, j]
            lower[i], upper[i] = max(lower[i], term.bound[0]), min(upper[i], term.bound[1])
    for name, i in slot.items():
        if not lower[i] < upper[i]:
            raise InputError(f"bounds {lower[i]:g} to {upper[i]:g} leave {name} no room; widen them")
    scale = np.sqrt(np.where(square > 0, square, 1.0))
    return Problem(slot, scale, lower * scale, upper * scale, by_force, terms, equations.columns)


def free_parameters(terms: TermTable) -> dict[str, int]:
    """Index of the free parameter of each coefficient; tied coefficients share one."""
    leader = {name: name for name in terms.names}
    for first, second in terms.ties:
        old, new = leader[second], leader[first]
        leader = {name: new if head == old else head for name, head in leader.items()}
    order = list(dict.fromkeys(leader.values()))
    return {name: order.index(head) for name, head in leader.items()}


def _weight(equations: NormalEquations, total: np.ndarray, force: str) -> float:
    one, column = equations.columns[ONE], equations.columns[force]
    rows = total[one, one]
    variance = total[column, column] / rows - (total[one, column] / rows) ** 2
    return float(1 / variance) if variance > 0 else 1.0


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
    # A primal-dual active set finds which parameters sit at a bound, SciPy's BVLS on H's factor where it does not
    # converge or does not reach an optimum. The free set is then solved anew, so that the result is as exact as a
    # direct solve; directions without data are left at their smallest norm.
    start, left = _active_set(h[None], g[None], lower, upper)
    quick = _settled(h, g, start[0], lower, upper)
    if quick.kkt.satisfied and not left.size:
        return quick
    return _settled(h, g, _bvls(h, g, lower, upper), lower, upper)


def solve_many(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper for every problem of a stack, (n, p)."""
    # h (n, p, p) or (p, p); g (n, p); lower, upper (p,)
    h, z = np.broadcast_to(h, (len(g), *h.shape[-2:])), np.empty_like(g)
    for first in range(0, len(g), CHUNK):
        part = slice(first, first + CHUNK)
        z[part], left = _active_set(h[part], g[part], lower, upper)
        for i in left + first:
            z[i] = solve(h[i], g[i], lower, upper).z
    return z


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


def _active_set(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
