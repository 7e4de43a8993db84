"""How strong gusts are and how long they stay: by the likelihood of the records, their own unknowns integrated out."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.push_chain import WindowChain, bounded_correlation, free_correlation
from narrows.logbook.shooting.recorded_motion import PUSHES
from narrows.logbook.shooting.search_state import SampledRecord
from narrows.logbook.shooting.window_links import banded, link_determinant

USUAL_MEMORY, SPREAD_OF_MEMORY = 40.0, 1.0
"""How long a gust stays before anything is known of it [s], and the standard deviation of its logarithm."""
SPREAD_OF_STRENGTH = 1.5
"""Standard deviation of the logarithm of how strong gusts are, about what is usual: none at all would be bold."""
SPREAD_OF_CORRELATION = 1.0
"""Standard deviation of the inverse hyperbolic tangent of the correlation between sway and yaw: few records tell it."""
MOST_MOVE, SLOPE_STEP = 1.0, 0.1
"""Of logarithms, in the search: at most from where it began, and by which slopes are taken."""
UNLIKELY = 1e12
"""Where a chain has no likelihood."""
ASKED, ENOUGH = 60, 0.1
"""How often the likelihood is asked for, at most; its logarithm, which a step is to gain."""


def likelihood(problem: LogProblem, samples: Sequence[SampledRecord]) -> float:
    """Return the logarithm of the likelihood of a chain, to a constant, by the equations where the search stood (ours).

    The coefficients stay: with weaker gusts they would move farther than these equations are straight.

    Parameters
    ----------
    problem : LogProblem
        With the chain to judge.
    samples : sequence of SampledRecord
        Records.
    """
    cost = 0.0
    for sample in samples:
        best = sample.told.best
        assert best is not None
        band = banded(problem, sample.grid, best.own, best.found.without_coefficients(problem), sample.links)
        left = band.eliminated().without(len(best.own.zeros))
        cost += left.cost + left.determinant + link_determinant(problem, sample.grid, sample.links)
    return -0.5 * cost


def most_likely_chain(problem: LogProblem, samples: Sequence[SampledRecord], usual: WindowChain) -> WindowChain:
    """Return the chain with the pushes that the records make most likely (ours).

    Parameters
    ----------
    problem : LogProblem
        With the chain to begin with.
    samples : sequence of SampledRecord
        Records.
    usual : WindowChain
        As strong as gusts are before anything is known.

    References
    ----------
    Byrd, Lu, Nocedal and Zhu (1995), A limited memory algorithm for bound constrained optimization, SIAM J. Sci.
    Comput. 16.
    """
    from scipy.optimize import minimize

    chain = problem.chain
    pushes = [name for name in chain.names if name in PUSHES]
    places = [chain.names.index(name) for name in pushes]
    start = np.append(np.log([*chain.std[places], chain.memory[places[0]]]), free_correlation(chain.correlation))

    def chain_of(numbers: np.ndarray) -> WindowChain:
        sizes = dict(zip(pushes, np.exp(numbers[: len(pushes)]).tolist(), strict=True))
        return chain.with_pushes(sizes, float(np.exp(numbers[-2])), bounded_correlation(float(numbers[-1])))

    def unlikely(numbers: np.ndarray) -> float:
        strong = (numbers[: len(pushes)] - np.log(usual.std[places])) / SPREAD_OF_STRENGTH
        stays = (numbers[-2] - np.log(USUAL_MEMORY)) / SPREAD_OF_MEMORY
        known = strong @ strong + stays**2 + (numbers[-1] / SPREAD_OF_CORRELATION) ** 2
        try:
            told = likelihood(replace(problem, chain=chain_of(numbers)), samples)
        except np.linalg.LinAlgError:
            return UNLIKELY
        return float(0.5 * known - told)

    bounds = [(number - MOST_MOVE, number + MOST_MOVE) for number in start]
    first = unlikely(start)
    options: Any = {"maxfun": ASKED, "eps": SLOPE_STEP, "ftol": ENOUGH / max(abs(first), 1.0), "gtol": 0.0}
    return chain_of(minimize(unlikely, start, method="L-BFGS-B", bounds=bounds, options=options).x)
