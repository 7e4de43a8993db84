"""The paper's joint problem, reduced: ties substituted, columns scaled to one, one small matrix left."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from narrows.errors import InputError, check_choice
from narrows.identification.regression.normal_equations import ONE, NormalEquations
from narrows.terms.term import TermTable

Weights = Literal["paper", "variance"]
WEIGHTS = get_args(Weights)


@dataclass(frozen=True)
class Problem:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper, where z = parameters x scale."""

    slot: Mapping[str, int]  # The parameter of each coefficient; tied coefficients share one
    scale: np.ndarray  # (p,) Norm of each parameter's column; 1 where the column is zero
    lower: np.ndarray  # (p,) Bounds of z
    upper: np.ndarray  # (p,) Bounds of z
    weights: Mapping[str, float]  # Weight of each force in the sum
    terms: TermTable  # The terms
    columns: Mapping[str, int]  # Column of the sums of each coefficient's regressor or force

    def normal(self, sums: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Assemble H (..., p, p) and g (..., p) from sums of products."""
        # sums (..., m, m)
        size = len(self.scale)
        h, g = np.zeros((*sums.shape[:-2], size, size)), np.zeros((*sums.shape[:-2], size))
        for force, terms in self.terms.forces.items():
            if not terms:
                continue
            columns = np.array([self.columns[term.name] for term in terms])
            slots = np.array([self.slot[term.name] for term in terms])
            weight = self.weights[force] / self.scale[slots]
            part = sums[..., columns[:, None], columns[None, :]]
            # Two coefficients of one force may share a parameter, so add entry by entry.
            for i, row in enumerate(slots):
                g[..., row] += sums[..., columns[i], self.columns[force]] * weight[i]
                for j, column in enumerate(slots):
                    h[..., row, column] += part[..., i, j] * weight[i] / self.scale[column]
        return h, g

    def coefficients(self, z: np.ndarray) -> np.ndarray:
        """Return the coefficients (..., n) of scaled parameters z (..., p)."""
        # z (..., p)
        return np.asarray((z / self.scale)[..., [self.slot[name] for name in self.terms.names]])

    def named(self, z: np.ndarray) -> dict[str, float]:
        """Return the coefficients of scaled parameters by name."""
        # z (p,)
        return dict(zip(self.terms.names, self.coefficients(z).tolist(), strict=True))


def reduced(equations: NormalEquations, terms: TermTable, weights: Weights = "paper") -> Problem:
    """Set up the joint problem of the paper (ours: scaled, ties substituted)."""
    check_choice("weights", weights, WEIGHTS)
    slot = slots(terms)
    total = equations.total
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


def slots(terms: TermTable) -> dict[str, int]:
    """Return the parameter of each coefficient; tied coefficients share one."""
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
