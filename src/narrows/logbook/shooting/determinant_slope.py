"""What a likelihood of readings has beyond the best windows: how wide the windows are left, and how that moves.

Starts and pushes that are at their best for the readings make a ship look as damped as suits them: with many windows
the coefficients err by it. Integrated out instead, they leave the determinant of their equations.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.window_equations import RecordUnknowns, window_equations
from narrows.logbook.shooting.window_links import WindowLinks, banded

STEP = 0.02
"""Of a difference, in standard deviations before."""


class WindowedRecord(NamedTuple):
    """A record with its windows.

    Parameters
    ----------
    grid : RecordGrid
        The record.
    own : RecordUnknowns
        Where its windows stand.
    links : WindowLinks
        Between them.
    """

    grid: RecordGrid
    own: RecordUnknowns
    links: WindowLinks


def determinant_slope(problem: LogProblem, samples: Sequence[WindowedRecord], scaled: np.ndarray) -> np.ndarray:
    """Return the slope of half the logarithm of the determinant of a window by the coefficients, (p,) [1] (ours).

    Parameters
    ----------
    problem : LogProblem
        What is solved for.
    samples : sequence of WindowedRecord
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


def _slope(problem: LogProblem, samples: Sequence[WindowedRecord], scaled: np.ndarray) -> np.ndarray:
    slope, windows = np.zeros(len(scaled)), sum(len(sample.grid) for sample in samples)
    at = _determinant(problem, samples, scaled)
    for place in np.flatnonzero(problem.prior.moves):
        beside = scaled + STEP * (np.arange(len(scaled)) == place)
        slope[place] = _determinant(problem, samples, beside) - at
    return slope / (2 * STEP * max(windows, 1))


def _determinant(problem: LogProblem, samples: Sequence[WindowedRecord], scaled: np.ndarray) -> float:
    """The logarithm of that of all that records have of their own, where they stood."""
    motion, whole = problem.at(scaled).of_records, 0.0
    for grid, own, links in samples:
        found = window_equations(problem, motion, scaled, grid, own)
        left = banded(problem, grid, own, found, links).eliminated().without(len(own.zeros))
        whole += left.determinant
    return whole
