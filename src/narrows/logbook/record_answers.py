"""What each record did to the answer, and how well the model foretells it without having seen it."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from narrows.logbook.log_posterior import scaled_covariance
from narrows.logbook.refined_search import Refined
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.log_search import RecordTold
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.window_equations import Pushes, RecordUnknowns

AHEAD = 3.5
"""Times of a ship length that a forecast reaches."""
MISSED = {"y": 1, "psi": 2, "r": 5}
"""Of what a forecast is judged by: places among the states."""


@dataclass(frozen=True)
class RecordAnswer:
    """A record and the coefficients.

    Parameters
    ----------
    name : str
        Of the record.
    duration : float [s]
        How long.
    windows : int
        Into how many it was cut.
    zeros : mapping of str to float
        What was the same all through it, in SI; pushes as accelerations.
    information : mapping of str to float [1]
        Share of what is known of each coefficient that is gone without the record.
    moved : mapping of str to float
        How far the record moves each coefficient.
    missed : mapping of str to (float, float)
        Root mean square of what forecasts over 3.5 ship lengths miss of y [m], psi [rad] and r [rad/s]: by the model
        before, and by one that learned from all other records.
    """

    name: str
    duration: float
    windows: int
    zeros: dict[str, float]
    information: dict[str, float]
    moved: dict[str, float]
    missed: dict[str, tuple[float, float]]


def record_answers(refined: Refined, grids: Iterable[RecordGrid]) -> tuple[RecordAnswer, ...]:
    """Return what each record did (ours).

    Parameters
    ----------
    refined : Refined
        The search.
    grids : iterable of RecordGrid
        The records.
    """
    found, problem = refined.found, refined.problem
    return tuple(_answer(refined, problem, grid, told) for grid, told in zip(grids, found.told, strict=False))


def _answer(refined: Refined, problem: LogProblem, grid: RecordGrid, told: RecordTold) -> RecordAnswer:
    prior, found = problem.prior, refined.found
    whole = np.diag(scaled_covariance(prior, found.information))
    without = scaled_covariance(prior, found.information - told.information)
    moved = np.where(prior.moves, without @ (told.pull * prior.moves), 0.0)
    gone = np.clip(1 - whole / np.diag(without), 0.0, 1.0)
    before, after = (_missed(problem, at, grid, told.own) for at in (np.zeros(len(moved)), found.scaled - moved))
    return RecordAnswer(
        grid.record.name, float(grid.times[-1] - grid.times[0]), len(grid),
        dict(zip(problem.zeros, told.own.zeros.tolist(), strict=True)),
        dict(zip(prior.names, gone.tolist(), strict=True)),
        dict(zip(prior.names, (moved * prior.scale).tolist(), strict=True)),
        {name: (float(before[place]), float(after[place])) for name, place in MISSED.items()},
    )  # fmt: skip


def _missed(problem: LogProblem, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns) -> np.ndarray:
    """Root mean square of the ends of forecasts less the states that the record makes most likely there, (6,)."""
    speed = max(float(np.abs(own.starts[:, 3]).mean()), 1e-3)
    reach = AHEAD * problem.motion.model.configuration.ship.length / speed
    every = max(1, round(reach / grid.window))
    begun = np.arange(0, len(grid), every)
    if len(begun) < 2:
        return np.full(6, np.nan)
    still = RecordUnknowns(own.starts[begun[:-1]], 0 * own.chain[begun[:-1]], own.zeros)
    pushes = Pushes.of(problem, scaled, still)
    with np.errstate(all="ignore"):
        states, _ = problem.at(scaled).sailed(
            still.starts, pushes.forces, grid.first[begun], grid.times, grid.positions, pushes.rudder
        )
    ends = grid.first[begun][1:] - grid.first[begun[0]] + np.arange(len(begun) - 1)
    return np.asarray(np.sqrt(np.mean((states[ends] - own.starts[begun[1:]]) ** 2, axis=0)))
