"""What a likelihood of readings has beyond the best windows: how wide the windows are left, and how that moves.

Starts and pushes that are at their best for the readings make a ship look as damped as suits them: with many windows
the coefficients err by it. Integrated out instead, they leave the determinant of their equations.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.push_chain import WindowChain
from narrows.logbook.shooting.search_state import SampledRecord
from narrows.logbook.shooting.window_equations import window_equations

# Of a difference, in standard deviations before.
STEP = 0.02


def determinant_slope(
    problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray, chains: Sequence[WindowChain] = ()
) -> np.ndarray:
    """Return the slope of half the logarithm of the determinant of a window by the coefficients, (chains, p)."""
    # scaled (p,)
    # Tierney and Kadane (1986), Accurate approximations for posterior moments and marginal densities, J. Am. Stat.
    # Assoc. 81, for the approximation; Neyman and Scott (1948), Econometrica 16, for what comes of leaving it out.
    linked = [replace(problem, chain=chain) for chain in chains] or [problem]
    none = np.zeros((len(linked), len(scaled)))
    try:
        slope = _slope(linked, samples, scaled)
    except np.linalg.LinAlgError:  # Windows of which nothing is known.
        return none
    return slope if np.isfinite(slope).all() else none


def _slope(linked: Sequence[LogProblem], samples: Sequence[SampledRecord], scaled: np.ndarray) -> np.ndarray:
    slope, windows = np.zeros((len(linked), len(scaled))), sum(len(sample.grid) for sample in samples)
    at = _determinants(linked, samples, scaled)
    for place in np.flatnonzero(linked[0].prior.moves):
        beside = scaled + STEP * (np.arange(len(scaled)) == place)
        slope[:, place] = _determinants(linked, samples, beside) - at
    return slope / (2 * STEP * max(windows, 1))


def _determinants(linked: Sequence[LogProblem], samples: Sequence[SampledRecord], scaled: np.ndarray) -> np.ndarray:
    """The logarithms of those of all that records have of their own, where they stood, by each linkage."""
    motion, whole = linked[0].at(scaled).of_records, np.zeros(len(linked))
    for sample in samples:
        found = window_equations(linked[0], motion, scaled, sample.grid, sample.told.own)
        whole += [sample.left(problem, found).determinant for problem in linked]
    return whole
