"""How strong gusts are and how long they stay: by the likelihood of the records, their own unknowns integrated out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.push_chain import WindowChain, bounded_correlation, free_correlation
from narrows.logbook.shooting.recorded_motion import PUSHES
from narrows.logbook.shooting.search_state import Found, SampledRecord, determinant_slope
from narrows.logbook.shooting.window_links import link_determinant

# How long a gust stays before anything is known of it [s], and the standard deviation of its logarithm.
USUAL_MEMORY, SPREAD_OF_MEMORY = 40.0, 1.0
# Standard deviation of the logarithm of how strong gusts are, about what is usual: none at all would be bold.
SPREAD_OF_STRENGTH = 1.5
# Standard deviation of the inverse hyperbolic tangent of the correlation between sway and yaw: few records tell it.
SPREAD_OF_CORRELATION = 1.0
# Of logarithms, in the search: at most from where it began, and by which slopes are taken.
MOST_MOVE, SLOPE_STEP = 1.0, 0.1
# Where a chain has no likelihood.
UNLIKELY = 1e12
# How often the likelihood is asked for, at most; its logarithm, which a step is to gain.
ASKED, ENOUGH = 60, 0.1
# Records by which it is seen how the slope of how wide windows are left goes with gusts: it is dear.
ASKED_OF_WIDTH = 4
# Least curvature of the logarithm of the likelihood: of what is known before.
KNOWN = max(SPREAD_OF_STRENGTH, SPREAD_OF_MEMORY, SPREAD_OF_CORRELATION) ** -2.0


@dataclass(frozen=True)
class GustJudge:
    """What records say of gusts, by the equations where the search stood."""

    problem: LogProblem  # With the chain to begin with
    found: Found  # Where the search stood
    samples: Sequence[SampledRecord]  # Records that are asked
    usual: WindowChain  # As strong as gusts are before anything is known

    @cached_property
    def pushes(self) -> list[str]:
        """Those of the chain."""
        return [name for name in self.problem.chain.names if name in PUSHES]

    @cached_property
    def places(self) -> list[int]:
        """Of the pushes, in the chain."""
        return [self.problem.chain.names.index(name) for name in self.pushes]

    @cached_property
    def share(self) -> float:
        """How many windows there are for each that is asked."""
        asked = sum(len(sample.grid) for sample in self.samples)
        return self.found.windows / max(asked, 1)

    @cached_property
    def turned(self) -> np.ndarray:
        """How the slope of how wide windows are left goes with the free numbers, (p, k)."""
        beside = self.start + SLOPE_STEP * np.eye(len(self.start))
        chains = [self.problem.chain, *(self.chain(numbers) for numbers in beside)]
        slopes = determinant_slope(self.problem, self.samples[:ASKED_OF_WIDTH], self.found.scaled, chains)
        return np.asarray(self.found.windows * (slopes[1:] - slopes[0]).T / SLOPE_STEP)

    @property
    def start(self) -> np.ndarray:
        """The free numbers of the chain to begin with: logarithms of strengths and of the memory, a correlation."""
        chain = self.problem.chain
        logarithms = np.log([*chain.std[self.places], chain.memory[self.places[0]]])
        return np.append(logarithms, free_correlation(chain.correlation))

    def chain(self, numbers: np.ndarray) -> WindowChain:
        """Return the chain of free numbers."""
        # numbers (k,)
        sizes = dict(zip(self.pushes, np.exp(numbers[: len(self.pushes)]).tolist(), strict=True))
        memory, correlation = float(np.exp(numbers[-2])), bounded_correlation(float(numbers[-1]))
        return self.problem.chain.with_pushes(sizes, memory, correlation)

    def unlikely(self, numbers: np.ndarray, copies: float = 1.0) -> float:
        """Return less the logarithm of the likelihood, to a constant, the coefficients where they are."""
        # numbers (k,)
        # With weaker gusts they would move farther than these equations are straight.
        count = len(self.pushes)
        strong = (numbers[:count] - np.log(self.usual.std[self.places])) / SPREAD_OF_STRENGTH
        stays = (numbers[-2] - np.log(USUAL_MEMORY)) / SPREAD_OF_MEMORY
        known = strong @ strong + stays**2 + (numbers[-1] / SPREAD_OF_CORRELATION) ** 2
        problem, cost = replace(self.problem, chain=self.chain(numbers)), 0.0
        try:
            for sample in self.samples:
                left = sample.left(problem, sample.found.without_coefficients(problem))
                cost += left.cost + left.determinant + link_determinant(problem, sample.grid, sample.links)
        except np.linalg.LinAlgError:
            return UNLIKELY
        return 0.5 * float(known + copies * cost)

    def followed(self, numbers: np.ndarray, copies: float = 1.0) -> np.ndarray:
        """Return how far the best coefficients go, (p,): all records are taken to go as those that are asked."""
        # numbers (k,)
        problem, prior, found = replace(self.problem, chain=self.chain(numbers)), self.problem.prior, self.found
        information, pull = found.information, found.pull - self.turned @ (numbers - self.start)
        for sample in self.samples:
            left = sample.left(problem, sample.found)
            information = information + self.share * (left.corner - sample.told.information)
            pull = pull + self.share * (left.right - sample.told.pull)
        step, moves = np.zeros(len(pull)), prior.moves
        whole = copies * information + prior.precision
        right = np.sqrt(copies) * pull - prior.precision @ found.scaled
        step[moves] = np.linalg.solve(whole[np.ix_(moves, moves)], right[moves])
        return step


def likely_gusts(judge: GustJudge) -> WindowChain:
    """Return the chain with the pushes that the records make most likely."""
    # Byrd, Lu, Nocedal and Zhu (1995), A limited memory algorithm for bound constrained optimization, SIAM J. Sci.
    # Comput. 16.
    from scipy.optimize import minimize

    start = judge.start
    bounds = [(number - MOST_MOVE, number + MOST_MOVE) for number in start]
    first = judge.unlikely(start)
    options: Any = {"maxfun": ASKED, "eps": SLOPE_STEP, "ftol": ENOUGH / max(abs(first), 1.0), "gtol": 0.0}
    return judge.chain(minimize(judge.unlikely, start, method="L-BFGS-B", bounds=bounds, options=options).x)


def gust_doubt(judge: GustJudge, copies: float = 1.0) -> np.ndarray:
    """Return how far the coefficients go with each independent standard deviation of what gusts may be, (p, k)."""
    # What gusts may be is told where the coefficients stay, so that the doubt is the least that there is.
    try:
        return _doubt(judge, copies)
    except np.linalg.LinAlgError:
        return np.zeros((len(judge.found.scaled), 0))


def _doubt(judge: GustJudge, copies: float) -> np.ndarray:
    start, beside = judge.start, SLOPE_STEP * np.eye(len(judge.start))
    ends = [(judge.followed(start + one, copies), judge.followed(start - one, copies)) for one in beside]
    follows = np.stack([up - down for up, down in ends], axis=1)
    root = np.linalg.cholesky(_curvature(lambda numbers: judge.unlikely(numbers, copies), start, beside))
    return np.asarray(np.linalg.solve(root, follows.T).T / (2 * SLOPE_STEP))


def _curvature(function: Callable[[np.ndarray], float], at: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """Second slopes by differences, none less than what is known before."""
    value = function(at)
    up, down = (np.array([function(at + sign * one) for one in beside]) for sign in (1, -1))
    curvature = np.diag(up - 2 * value + down)
    for i in range(len(at)):
        for j in range(i):
            curvature[i, j] = curvature[j, i] = function(at + beside[i] + beside[j]) - up[i] - up[j] + value
    sizes, axes = np.linalg.eigh(curvature / SLOPE_STEP**2)
    return np.asarray(axes @ np.diag(np.maximum(sizes, KNOWN)) @ axes.T)
