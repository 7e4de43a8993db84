"""Profile likelihood: how much worse the best fit gets as one coefficient is held elsewhere."""

from dataclasses import dataclass

import numpy as np

from narrows.identification.estimates import CoefficientEstimates
from narrows.identification.regression.problem import Problem
from narrows.identification.regression.solve import solve_many

POINTS = 61
# Standard errors on either side.
SPAN = 4.0


@dataclass(frozen=True)
class Profile:
    """The best fit under the constraints with one coefficient held, over a range of its values."""

    name: str  # The coefficient
    values: np.ndarray  # (points,) Where it is held, in its unit
    # (points,) Twice the loss of log-likelihood, scaled so that, away from bounds, it is the squared distance from
    # the best value in cluster-robust standard errors [1]
    deviance: np.ndarray
    others: np.ndarray  # (points, n) All coefficients along the way, each in its own unit


def profile(problem: Problem, total: np.ndarray, found: CoefficientEstimates, name: str) -> Profile | None:
    """Hold one coefficient at a range of values and fit the others."""
    # total (m, m)
    index, slot = problem.terms.names.index(name), problem.slot[name]
    std = found.free_std[index] * problem.scale[slot]
    h, g = problem.normal(total)
    if not std > 0 or h[slot, slot] == 0:
        return None
    free = np.arange(len(h)) != slot
    lower, upper = problem.lower[free], problem.upper[free]
    reduced = h[np.ix_(free, free)]
    middle = found.values[index] * problem.scale[slot]
    held = np.unique(np.clip(middle + np.linspace(-SPAN, SPAN, POINTS) * std, *_bounds(problem, slot)))
    rest = solve_many(reduced, g[free] - held[:, None] * h[free, slot], lower, upper)
    z = np.insert(rest, slot, held, axis=1)
    loss = 0.5 * np.einsum("ni,ij,nj->n", z, h, z) - z @ g
    stiffness = h[slot, slot] - h[slot, free] @ np.linalg.lstsq(reduced, h[free, slot], rcond=None)[0]
    deviance = 2 * (loss - loss.min()) / max(stiffness, 1e-300) / std**2
    return Profile(name, held / problem.scale[slot], deviance, problem.coefficients(z))


def _bounds(problem: Problem, slot: int) -> tuple[float, float]:
    return float(problem.lower[slot]), float(problem.upper[slot])
