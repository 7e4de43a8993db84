"""What a record has of its own, at its best where the coefficients stay: a damped Gauss-Newton search."""

from dataclasses import dataclass

import numpy as np

from narrows.logbook.shooting.bordered_band import BorderedBand, Eliminated
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.recorded_motion import RecordedMotion
from narrows.logbook.shooting.window_equations import RecordUnknowns, WindowEquations, window_equations
from narrows.logbook.shooting.window_links import WindowLinks, banded

STEPS, SHRINKS, SHRUNK = 8, 6, 0.3
"""Steps of the search, shares of a step that are tried, and how much smaller each is."""
SETTLED = 0.05
"""Of a sum of squares, less than which a step need not gain."""


@dataclass(frozen=True)
class RecordBest:
    """A record at its best.

    Parameters
    ----------
    own : RecordUnknowns
        What it has of its own.
    found : WindowEquations
        Of its readings, there.
    band : BorderedBand
        The normal equations, there.
    left : Eliminated
        Of them, the coefficients alone.
    """

    own: RecordUnknowns
    found: WindowEquations
    band: BorderedBand
    left: Eliminated


def record_best(
    problem: LogProblem, motion: RecordedMotion, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns,
    links: WindowLinks | None,
) -> RecordBest | None:  # fmt: skip
    """Return a record at its best for coefficients, None where the motion goes to infinity (ours).

    Parameters
    ----------
    problem : LogProblem
        What is solved for.
    motion : RecordedMotion
        At the coefficients.
    scaled : array (p,) [1]
        The coefficients.
    grid : RecordGrid
        The record.
    own : RecordUnknowns
        Where to begin.
    links : WindowLinks, optional
        Between its windows.
    """

    def at(there: RecordUnknowns) -> tuple[WindowEquations, BorderedBand]:
        with np.errstate(all="ignore"):  # A motion that runs away is noticed by its cost.
            found = window_equations(problem, motion, scaled, grid, there)
            return found, banded(problem, grid, there, found, links)

    found, band = at(own)
    if not np.isfinite(band.cost):
        return None
    for _ in range(STEPS):
        inner = band.eliminated()
        left = inner.without(len(own.zeros))
        if band.cost - left.cost < SETTLED:
            return RecordBest(own, found, band, left)
        zeros = np.linalg.solve(inner.corner[: len(own.zeros), : len(own.zeros)], inner.right[: len(own.zeros)])
        tried = (own.moved(inner.windows(zeros), zeros, float(share)) for share in SHRUNK ** np.arange(SHRINKS))
        better = next(((there, *now) for there in tried if (now := at(there))[1].cost < band.cost), None)
        if better is None:
            break
        own, found, band = better
    return RecordBest(own, found, band, band.eliminated().without(len(own.zeros)))
