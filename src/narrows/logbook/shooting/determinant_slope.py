"""What a likelihood of readings has beyond the best windows: how wide the windows are left, and how that moves.

Starts and pushes that are at their best for the readings make a ship look as damped as suits them: with many windows
the coefficients err by it. Integrated out instead, they leave the determinant of their equations.
"""

from collections.abc import Sequence

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.search_state import SampledRecord
from narrows.logbook.shooting.window_equations import window_equations
from narrows.logbook.shooting.window_links import banded

STEP = 0.02
"""Of a difference, in standard deviations before."""


def determinant_slope(problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray) -> np.ndarray:
    """Return the slope of half the logarithm of the determinant of a window by the coefficients, (p,) [1] (ours).

    Parameters
    ----------
    problem : LogProblem
        What is solved for.
    samples : sequence of SampledRecord
        Records, at their best.
    scaled : array (p,) [1]
        The coefficients there.

    Returns
    -------
    array (p,)
        None where the windows or their motion have no finite one.

    References
    ----------
    Tierney and Kadane (1986), Accurate approximations for posterior moments and marginal densities, J. Am. Stat. Assoc.
    81, for the approximation; Neyman and Scott (1948), Econometrica 16, for what comes of leaving it out.
    """
    none = np.zeros(len(scaled))
    try:
        slope = _slope(problem, samples, scaled)
    except np.linalg.LinAlgError:  # Windows of which nothing is known.
        return none
    return slope if np.isfinite(slope).all() else none


def _slope(problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray) -> np.ndarray:
    slope, windows = np.zeros(len(scaled)), sum(len(sample.grid) for sample in samples)
    at = _determinant(problem, samples, scaled)
    for place in np.flatnonzero(problem.prior.moves):
        beside = scaled + STEP * (np.arange(len(scaled)) == place)
        slope[place] = _determinant(problem, samples, beside) - at
    return slope / (2 * STEP * max(windows, 1))


def _determinant(problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray) -> float:
    """The logarithm of that of all that records have of their own, where they stood."""
    motion, whole = problem.at(scaled).of_records, 0.0
    for grid, told, links in samples:
        found = window_equations(problem, motion, scaled, grid, told.own)
        left = banded(problem, grid, told.own, found, links).eliminated().without(len(told.own.zeros))
        whole += left.determinant
    return whole
