"""How strong gusts are and how long they stay: by the likelihood of the records, all else integrated out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.log_search import RecordTold
from narrows.logbook.shooting.push_chain import WindowChain, bounded_correlation
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.recorded_motion import PUSHES
from narrows.logbook.shooting.window_links import WindowLinks, banded, link_determinant

USUAL_MEMORY, SPREAD_OF_MEMORY = 40.0, 1.0
"""How long a gust stays before anything is known of it [s], and the standard deviation of its logarithm."""
SPREAD_OF_CORRELATION = 1.0
"""Standard deviation before, of the inverse hyperbolic tangent of the correlation of sway and yaw."""
FIRST_MOVE, MOST_MOVE = 0.3, 1.0
"""Of logarithms, in the search: at first, and at most from where it began."""
ASKED = 80
"""How often the likelihood is asked for, at most."""


@dataclass(frozen=True)
class ChainSample:
    """A record by which gusts are judged.

    Parameters
    ----------
    grid : RecordGrid
        The record.
    told : RecordTold
        With its equations.
    links : WindowLinks
        Between its windows.
    """

    grid: RecordGrid
    told: RecordTold
    links: WindowLinks


def likelihood(problem: LogProblem, samples: Sequence[ChainSample], scaled: np.ndarray) -> float:
    """Return the logarithm of the likelihood of a chain, to a constant, by the equations where the search stood (ours).

    Parameters
    ----------
    problem : LogProblem
        With the chain to judge.
    samples : sequence of ChainSample
        Records.
    scaled : array (p,) [1]
        The coefficients there.
    """
    prior = problem.prior.precision
    corner, right, cost = prior.copy(), -prior @ scaled, float(scaled @ prior @ scaled)
    for sample in samples:
        best = sample.told.best
        assert best is not None
        band = banded(problem, sample.grid, best.own, best.found, sample.links)
        left = band.eliminated().without(len(best.own.zeros))
        corner, right = corner + left.corner, right + left.right - len(sample.grid) * problem.determinant_slope
        cost += left.cost + left.determinant + link_determinant(problem, sample.grid, sample.links)
    inner = np.linalg.cholesky(corner)
    best_step = np.linalg.solve(inner, right)
    return -0.5 * float(cost - best_step @ best_step + 2 * np.log(np.diag(inner)).sum())


def most_likely_chain(problem: LogProblem, samples: Sequence[ChainSample], scaled: np.ndarray) -> WindowChain:
    """Return the chain with the pushes that the records make most likely (ours).

    Parameters
    ----------
    problem : LogProblem
        With the chain to begin with.
    samples : sequence of ChainSample
        Records.
    scaled : array (p,) [1]
        The coefficients there.

    References
    ----------
    Nelder and Mead (1965), A simplex method for function minimization, Computer Journal 7.
    """
    from scipy.optimize import minimize

    chain = problem.chain
    pushes = [name for name in chain.names if name in PUSHES]
    places = [chain.names.index(name) for name in pushes]
    start = np.append(np.log([*chain.std[places], chain.memory[places[0]]]), np.arctanh(chain.correlation / 0.995))

    def chain_of(numbers: np.ndarray) -> WindowChain:
        sizes = dict(zip(pushes, np.exp(numbers[: len(pushes)]).tolist(), strict=True))
        return chain.with_pushes(sizes, float(np.exp(numbers[-2])), bounded_correlation(float(numbers[-1])))

    def unlikely(numbers: np.ndarray) -> float:
        if np.abs(numbers - start).max() > MOST_MOVE:
            return float("inf")
        stays = (numbers[-2] - np.log(USUAL_MEMORY)) / SPREAD_OF_MEMORY
        together = numbers[-1] / SPREAD_OF_CORRELATION
        try:
            return float(
                0.5 * (stays**2 + together**2) - likelihood(replace(problem, chain=chain_of(numbers)), samples, scaled)
            )
        except np.linalg.LinAlgError:
            return float("inf")

    simplex = np.vstack([start, start + FIRST_MOVE * np.eye(len(start))])
    return chain_of(
        minimize(
            unlikely, start, method="Nelder-Mead",
            options={"maxfev": ASKED, "xatol": 0.05, "fatol": 0.1, "initial_simplex": simplex},
        ).x
    )  # fmt: skip
