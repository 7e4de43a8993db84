"""What a record has of its own, at its best where the coefficients stay: a damped Gauss-Newton search."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from narrows.logbook.shooting.bordered_band import BorderedBand, Eliminated
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.recorded_motion import RecordedMotion
from narrows.logbook.shooting.window_equations import RecordUnknowns, WindowEquations, window_equations
from narrows.logbook.shooting.window_links import WindowLinks, banded

STEPS, SHRINKS = 8, 6
"""Steps of the search, and shares of a step that are tried."""
LEAST_SHRUNK, MOST_SHRUNK = 0.1, 0.6
"""By which a share that does not help is made smaller."""
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

    def at(there: RecordUnknowns, coefficients: bool) -> tuple[WindowEquations, BorderedBand]:
        with np.errstate(all="ignore"):  # A motion that runs away is noticed by its cost, or by its equations.
            found = window_equations(problem, motion if coefficients else motion.of_records, scaled, grid, there)
            return found, banded(problem, grid, there, found, links)

    try:
        return _best(at, own)
    except np.linalg.LinAlgError:
        return None


Equations = Callable[[RecordUnknowns, bool], tuple[WindowEquations, BorderedBand]]
"""Of a record where it stands, the coefficients among their unknowns or not: those are dear, and asked for once."""


def _best(at: Equations, own: RecordUnknowns) -> RecordBest:
    _, band = at(own, False)
    if not np.isfinite(band.cost):
        raise np.linalg.LinAlgError("the motion goes to infinity")
    for _ in range(STEPS):
        moved = _moved(at, own, band)
        if moved is None:
            break
        own, band = moved
    found, band = at(own, True)
    return RecordBest(own, found, band, band.eliminated().without(len(own.zeros)))


def _moved(at: Equations, own: RecordUnknowns, band: BorderedBand) -> tuple[RecordUnknowns, BorderedBand] | None:
    """A step on, or the share of it that helps; None where nothing is to be gained."""
    inner = band.eliminated()
    gain = band.cost - inner.without(len(own.zeros)).cost
    if gain < SETTLED:
        return None
    zeros = np.linalg.solve(inner.corner, inner.right)
    windows, share = inner.windows(zeros), 1.0
    for _ in range(SHRINKS):
        there = own.moved(windows, zeros, share)
        _, after = at(there, False)
        if after.cost < band.cost:
            return there, after
        share = _shrunk(share, gain, after.cost - band.cost)
    return None


def _shrunk(share: float, gain: float, rise: float) -> float:
    """Where a parabola through what is known along a step has its lowest point."""
    bent = rise + 2 * gain * share
    best = gain * share**2 / bent if np.isfinite(bent) else 0.0
    return float(np.clip(best, LEAST_SHRUNK * share, MOST_SHRUNK * share))
