"""The paper's joint problem, reduced to one small matrix, and its exact solution within the bounds."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from narrows.base.errors import InputError
from narrows.identification.normal_equations import NormalEquations
from narrows.model.term import TermTable

KKT_TOLERANCE = 1e-8  # Largest relative residual of an optimum [1]
# Smallest singular value over the largest that counts as data [1]; sums of products resolve about 1e-8 of it.
RANK_TOLERANCE = 1e-6
# Ridge on the unit diagonal: sets directions without data to 0; a tenth of the least eigenvalue that counts as data.
RIDGE = 0.1 * RANK_TOLERANCE**2
MOST_ROUNDS = 25  # Most updates of the active sets; a problem that still changes is solved by itself


@dataclass(frozen=True)
class Problem:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper, where z = free parameters x scale."""

    slot: Mapping[str, int]  # The free parameter of each coefficient; tied coefficients share one
    scale: np.ndarray  # (p,) Norm of each parameter's column; 1 where the column is zero
    bounds: np.ndarray  # (p, 2) of the parameters
    terms: TermTable
    columns: Mapping[str, int]  # Column of the sums of each coefficient's regressor or force

    @property
    def lower(self) -> np.ndarray:
        return np.asarray(self.bounds[:, 0] * self.scale)

    @property
    def upper(self) -> np.ndarray:
        return np.asarray(self.bounds[:, 1] * self.scale)

    @property
    def joint_forces(self) -> list[tuple[str, ...]]:
        """Forces that share coefficients, and Y and N, which share errors of the motion."""
        slots = {force: {self.slot[term.name] for term in part} for force, part in self.terms.forces.items() if part}
        lateral = tuple(force for force in slots if force != "X")
        shared = slots.get("X", set()) & {slot for force in lateral for slot in slots[force]}
        groups = [tuple(slots)] if shared else [("X",) if "X" in slots else (), lateral]
        return [group for group in groups if group]

    def normal(self, sums: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Assemble H (..., p, p) and g (..., p) from sums of products (..., m, m)."""
        size = len(self.scale)
        h, g = np.zeros((*sums.shape[:-2], size, size)), np.zeros((*sums.shape[:-2], size))
        fitted = {force: [term.name for term in terms] for force, terms in self.terms.forces.items() if terms}
        for force, names in fitted.items():
            slots, columns = [self.slot[name] for name in names], [self.columns[name] for name in names]
            scaled = np.eye(size)[slots] / self.scale  # Two coefficients of one force may share a parameter
            rows = sums[..., columns, :]
            h += scaled.T @ rows[..., columns] @ scaled
            g += rows[..., self.columns[force]] @ scaled
        return h, g

    def solve(self, sums: np.ndarray) -> "Solution":
        return solve(*self.normal(sums), self.lower, self.upper)

    def fits(self, sums: np.ndarray) -> np.ndarray:
        """Return the coefficients (groups, n) fitted to each of several sums of products (groups, m, m)."""
        return self.coefficients(solve_many(*self.normal(sums), self.lower, self.upper))

    def coefficients(self, z: np.ndarray) -> np.ndarray:
        """Return the coefficients (..., n) of scaled parameters z (..., p)."""
        return np.asarray((z / self.scale)[..., [self.slot[name] for name in self.terms.names]])

    def named(self, z: np.ndarray) -> dict[str, float]:
        return dict(zip(self.terms.names, self.coefficients(z).tolist(), strict=True))


def bounded_problem(equations: NormalEquations, terms: TermTable) -> Problem:
    slot = free_parameters(terms)
    size = len(set(slot.values()))
    square, bounds = np.zeros(size), np.tile([-np.inf, np.inf], (size, 1))
    for term in terms.terms:
        i, j = slot[term.name], equations.columns[term.name]
        square[i] += equations.total[j, j]
        bounds[i] = max(bounds[i, 0], term.bound[0]), min(bounds[i, 1], term.bound[1])
    for name, i in slot.items():
        low, high = bounds[i]
        if not (low < high or (low == high and np.isfinite(low))):
            raise InputError(f"bounds {low:g} to {high:g} leave {name} no room; widen them")
    scale = np.sqrt(np.where(square > 0, square, 1.0))
    return Problem(slot, scale, bounds, terms, equations.columns)


def free_parameters(terms: TermTable) -> dict[str, int]:
    """Index of the free parameter of each coefficient; tied coefficients share one."""
    leader = {name: name for name in terms.names}
    for first, second in terms.ties:
        old, new = leader[second], leader[first]
        leader = {name: new if head == old else head for name, head in leader.items()}
    order = list(dict.fromkeys(leader.values()))
    return {name: order.index(head) for name, head in leader.items()}


class Kkt(NamedTuple):
    """Residuals of the Karush-Kuhn-Tucker conditions, relative to the largest entry of g."""

    stationarity: float  # Largest gradient among the free parameters [1]
    multiplier: float  # Most negative multiplier among the bound ones, as a positive number [1]
    infeasibility: float  # Largest distance outside a bound [1]

    @property
    def satisfied(self) -> bool:
        return max(self) <= KKT_TOLERANCE


class Solution(NamedTuple):
    z: np.ndarray  # (p,) Scaled parameters
    at_bound: np.ndarray  # (p,) True at a bound
    kkt: Kkt  # Check of optimality


def solve(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Solution:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper, with the smallest norm in directions without data."""
    # h (p, p); g (p,); lower, upper (p,)
    from scipy.optimize import lsq_linear

    # H = V diag(w) V' gives the least-squares problem sqrt(w) V' z = V'g / sqrt(w).
    values, vectors = np.linalg.eigh(h)
    kept = values > RANK_TOLERANCE**2 * max(values[-1], 1e-300)
    root = np.sqrt(values, where=kept, out=np.zeros(len(g)))
    target = np.divide(vectors.T @ g, root, where=kept, out=np.zeros(len(g)))
    with np.errstate(all="ignore"):  # lsq_linear may divide by a step of zero; the result is checked below.
        above = np.maximum(upper, np.nextafter(lower, np.inf))  # It refuses equal bounds, those of fixed coefficients
        found = lsq_linear(root[:, None] * vectors.T, target, (lower, above), method="bvls", tol=1e-14)
    # Rounding may leave an active parameter just off its bound: set it to the bound.
    z = np.select([found.active_mask < 0, found.active_mask > 0], [lower, upper], found.x)
    z = np.where(np.diag(h) > 0, z, np.clip(0.0, lower, upper))
    return Solution(z, (z <= lower) | (z >= upper), kkt_residuals(h, g, z, lower, upper))


def kkt_residuals(h: np.ndarray, g: np.ndarray, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Kkt:
    gradient = (h @ z - g) / max(float(np.abs(g).max(initial=0.0)), 1e-300)
    low, high = z <= lower, z >= upper
    pushed = np.concatenate([-gradient[low & ~high], gradient[high & ~low]])
    outside, free = np.maximum(lower - z, z - upper), np.abs(gradient[~low & ~high])
    return Kkt(*(float(part.max(initial=0.0)) for part in (free, pushed, outside)))


def solve_many(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper for every problem of a stack, (n, p)."""
    # h (n, p, p) or (p, p); g (n, p); lower, upper (p,)
    # Primal-dual active set: solve for the free parameters; fix at its bound each that violates it, and free each whose
    # multiplier has the wrong sign, until nothing changes. Problems that still change are solved one by one.
    # Hintermueller, Ito, Kunisch (2002), The primal-dual active set strategy as a semismooth Newton method.
    h, z, left = np.broadcast_to(h, (len(g), *h.shape[-2:])), np.empty_like(g), np.arange(len(g))
    active = np.zeros(g.shape, np.int8)  # -1 at the lower bound, +1 at the upper
    for _ in range(MOST_ROUNDS if len(g) else 0):
        z[left] = best = _solve_with_active(h[left], g[left], active, lower, upper)
        multiplier = g[left] - np.einsum("nij,nj->ni", h[left], best)
        below = np.where(active < 0, multiplier < 0, best < lower)
        above = np.where(active > 0, multiplier > 0, best > upper)
        after = np.where(above, 1, np.where(below, -1, 0))
        changed = (after != active).any(axis=1)
        left, active = left[changed], after[changed]
        if not left.size:
            break
    for i in left:
        z[i] = solve(h[i], g[i], lower, upper).z
    return z


def _solve_with_active(
    h: np.ndarray, g: np.ndarray, active: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    free = active == 0
    fixed = np.select([active < 0, active > 0], [lower, upper], 0.0)
    right = np.where(free, g - np.einsum("nij,nj->ni", h, fixed), 0.0)
    matrix = h * (free[:, :, None] & free[:, None, :])
    diagonal = np.arange(len(lower))
    matrix[:, diagonal, diagonal] = np.where(free, matrix[:, diagonal, diagonal] + RIDGE, 1.0)
    return fixed + np.linalg.solve(matrix, right[..., None])[..., 0]
