"""The search over all records: Gauss and Newton on the coefficients, damped by Levenberg where they go too far.

Each record is brought to its best for the coefficients and leaves a matrix of their size; these add. A record is laid
out when its turn comes, so that memory does not grow with records.
"""

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from narrows.identification.regression.solve import solve
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.record_search import RecordBest, record_best
from narrows.logbook.shooting.window_equations import RecordUnknowns
from narrows.logbook.shooting.window_links import WindowLinks
from narrows.progress import bar, is_shown

ROUNDS = 30
ENOUGH, NEARLY_ENOUGH = 0.02, 1.0
"""Of a sum of squares, which a step is to gain; else the search is done, or done for an estimate of noise."""
FIRST, GENTLER, HARDER, LEAST, MOST = 1e-4, 0.1, 10.0, 1e-9, 1e6
"""Damping over the information of the log: at first, after a step that helped, after one that did not, at least and at
most."""

Grids = Iterable[RecordGrid]
"""Records, each laid out when its turn comes, again and again."""


@dataclass
class RecordState:
    """A record in the search.

    Parameters
    ----------
    own : RecordUnknowns
        Where it stands.
    links : WindowLinks, optional
        Between its windows.
    """

    own: RecordUnknowns
    links: WindowLinks | None


@dataclass(frozen=True)
class RecordTold:
    """What one record tells of the coefficients, where the search stands.

    Parameters
    ----------
    information : array (p, p) [1]
        In units of the standard deviations before.
    pull : array (p,) [1]
        Half the slope of its sum of squares, downhill.
    cost : float [1]
        Its sum of squares, all of its own at its best, and what its windows are left to be.
    own : RecordUnknowns
        What it has of its own.
    residuals : mapping of str to array, optional
        Read less predicted, where the equations are kept.
    best : RecordBest, optional
        All of it, where it was asked to be kept.
    """

    information: np.ndarray
    pull: np.ndarray
    cost: float
    own: RecordUnknowns
    residuals: Mapping[str, np.ndarray] | None = None
    best: RecordBest | None = None


@dataclass(frozen=True)
class Found:
    """Where a search stands.

    Parameters
    ----------
    scaled : array (p,) [1]
        Coefficients in units of their standard deviations before.
    told : tuple of RecordTold
        By record.
    cost : float [1]
        Sum of squares with the prior.
    rounds : int
        Steps that it took.
    settled : bool
        Whether a further step would gain nothing.
    interrupted : bool
        Whether it was stopped by hand, perhaps before all records were looked at.
    """

    scaled: np.ndarray
    told: tuple[RecordTold, ...]
    cost: float
    rounds: int = 0
    settled: bool = False
    interrupted: bool = False

    @property
    def information(self) -> np.ndarray:
        """Of all records, without the prior, (p, p) [1]."""
        return np.asarray(sum(told.information for told in self.told))

    @property
    def pull(self) -> np.ndarray:
        """Of all records, (p,) [1]."""
        return np.asarray(sum(told.pull for told in self.told))


def evaluated(
    problem: LogProblem, scaled: np.ndarray, grids: Grids, states: Sequence[RecordState], kept: Container[int] = ()
) -> Found | None:
    """Bring every record to its best for coefficients; None where one goes to infinity (ours).

    Parameters
    ----------
    problem : LogProblem
        What is solved for.
    scaled : array (p,) [1]
        The coefficients.
    grids : iterable of RecordGrid
        The records.
    states : sequence of RecordState
        Where each record begins.
    kept : container of int
        Records whose equations are kept.
    """
    motion, told, stopped = problem.at(scaled), list[RecordTold](), False
    with bar(len(states), is_shown(), "records") as done:
        try:
            for number, (grid, state) in enumerate(zip(grids, states, strict=True)):
                best = record_best(problem, motion, scaled, grid, state.own, state.links)
                if best is None:
                    return None
                of_it = (best.found.residuals, best) if number in kept else (None, None)
                slope = len(grid) * problem.determinant_slope
                cost = best.band.cost + 2 * float(np.sum(slope * scaled))
                told.append(RecordTold(best.left.corner, best.left.right - slope, cost, best.own, *of_it))
                done(1)
        except KeyboardInterrupt:
            stopped = True
    cost = sum(part.cost for part in told) + float(scaled @ problem.prior.precision @ scaled)
    return Found(scaled, tuple(told), cost, interrupted=stopped)


def searched(
    problem: LogProblem, scaled: np.ndarray, grids: Grids, states: Sequence[RecordState], kept: Container[int] = (),
    enough: float = ENOUGH,
) -> Found | None:  # fmt: skip
    """Search for the most likely coefficients; None where the motion goes to infinity from the start (ours).

    Interrupted by hand, it gives what the records that were done tell.

    Parameters
    ----------
    problem : LogProblem
        What is solved for.
    scaled : array (p,) [1]
        Where to begin.
    grids : iterable of RecordGrid
        The records.
    states : sequence of RecordState
        Where each record begins; brought to their best.
    kept : container of int
        Records whose equations are kept.
    enough : float [1]
        Of a sum of squares, that a step is to gain at least.

    References
    ----------
    Bock (1987), Randwertproblemmethoden zur Parameteridentifizierung, for multiple shooting; Levenberg (1944), Quart.
    Appl. Math. 2, for the damping; Golub and Pereyra (1973), SIAM J. Numer. Anal. 10, for the elimination.
    """
    found = evaluated(problem, scaled, grids, states, kept)
    if found is None:
        return None
    if found.interrupted:
        if not found.told:
            raise KeyboardInterrupt
        return replace(found, scaled=found.scaled + _step(problem, found, FIRST)[0])
    damping = FIRST
    for number in range(1, ROUNDS + 1):
        _remember(states, found)
        step, gain = _step(problem, found, damping)
        if gain < enough:
            return replace(found, rounds=number, settled=True)
        after = evaluated(problem, found.scaled + step, grids, states, kept)
        if after is not None and after.interrupted:
            return replace(found, rounds=number, interrupted=True)
        if after is not None and after.cost < found.cost + ENOUGH / 10:
            found, damping = after, max(damping * GENTLER, LEAST)
        elif (damping := damping * HARDER) > MOST:
            break
    _remember(states, found)
    return replace(found, rounds=ROUNDS)


def _remember(states: Sequence[RecordState], found: Found) -> None:
    for state, told in zip(states, found.told, strict=True):
        state.own = told.own


def _step(problem: LogProblem, found: Found, damping: float) -> tuple[np.ndarray, float]:
    """The best step within the bounds by the equations, and what it is expected to gain."""
    prior, moves = problem.prior, problem.prior.moves
    information, right = found.information, (found.pull - prior.precision @ found.scaled)[moves]
    matrix = (information + prior.precision)[np.ix_(moves, moves)]
    damped = matrix + damping * np.diag(np.diag(information)[moves])
    root = np.sqrt(np.diag(damped))
    low, high = ((end - found.scaled)[moves] * root for end in prior.limits)
    inside = solve(damped / np.outer(root, root), right / root, np.minimum(low, 0.0), np.maximum(high, 0.0)).z / root
    step = np.zeros(len(found.scaled))
    step[moves] = inside
    return step, float(2 * right @ inside - inside @ matrix @ inside)
