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
from narrows.logbook.shooting.window_equations import RecordUnknowns, window_equations

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
        slope = np.stack([_slope(problem, samples, scaled) for problem in linked])
    except np.linalg.LinAlgError:  # Windows of which nothing is known.
        return none
    return slope if np.isfinite(slope).all() else none


def _slope(problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray) -> np.ndarray:
    slope, windows = np.zeros(len(scaled)), sum(len(sample.grid) for sample in samples)
    follows = [sample.follows(problem) for sample in samples]
    at = _determinant(problem, samples, scaled, [sample.told.own for sample in samples])
    for place in np.flatnonzero(problem.prior.moves):
        step = STEP * (np.arange(len(scaled)) == place)
        # Starts and pushes follow the coefficients: held where they were, they leave out a part that can turn the sign.
        owns = [follow.moved(sample.told.own, step) for sample, follow in zip(samples, follows, strict=True)]
        slope[place] = _determinant(problem, samples, scaled + step, owns) - at
    return slope / (2 * STEP * max(windows, 1))


def _determinant(
    problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray, owns: Sequence[RecordUnknowns]
) -> float:
    """Sum the log-determinants of the equations of all record-specific unknowns over the records."""
    motion, whole = problem.at(scaled).of_records, 0.0
    for sample, own in zip(samples, owns, strict=True):
        whole += sample.left(problem, window_equations(problem, motion, scaled, sample.grid, own)).determinant
    return whole
