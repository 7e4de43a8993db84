"""How the windows of a record hang together: where one ends the next begins, and the chain goes on.

A push is constant in a window; how it strays from its mean there moves the end of the window a little, and that much a
window may begin off the end of the one before.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.logbook.shooting import window_loops
from narrows.logbook.shooting.bordered_band import BorderedBand
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.push_chain import WindowChain
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.recorded_motion import RecordedMotion
from narrows.logbook.shooting.window_equations import START_SPREAD, Pushes, RecordUnknowns, WindowEquations

# By which a window may miss the end of the one before at least, in lengths, radians and speeds of the ship: for the
# numbers' sake alone.
LEAST = 1e-5 * np.array([1.0, 1.0, 0.3, 1.0, 1.0, 0.3])
# How far a held speed walks in a second, over itself.
SPEED_WALK = 2e-3
# Weight of a link out of a window in which the actuators are not known.
LOOSE = 1e-8
# Whose slopes are averaged.
MOST_WINDOWS = 64
# Weights of links that are kept, so that memory does not grow with records.
KEPT = 64


@dataclass(frozen=True, eq=False)
class WindowLinks:
    """What a window may miss the end of the one before by."""

    responses: np.ndarray  # (n, steps, 6) What one of the chain, put on in one step of a window, does to its end
    least: np.ndarray  # (6,) Least standard deviations
    step: float  # Lengths [s]
    window: float  # Lengths [s]

    @classmethod
    def of(
        cls, problem: LogProblem, motion: RecordedMotion, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns
    ) -> "WindowLinks":
        """Return the links of a record, by the motion where the search begins."""
        # scaled (p,)
        steps = int(grid.first[1] - grid.first[0])
        count = min(MOST_WINDOWS, max(len(grid) - 1, 1))
        part = slice(0, count)
        first = grid.first[: count + 1]
        pushes = Pushes.of(problem, scaled, own)
        with np.errstate(all="ignore"):  # A motion that runs away is noticed by its equations.
            _, slopes = motion.sailed(
                own.starts[part], pushes.forces[part], first, grid.times, grid.positions, pushes.rudder[part]
            )
        mean = slopes.reshape(count, -1, *slopes.shape[1:])[:, : steps + 1].mean(axis=0)
        columns = pushes.columns(motion)[:, 6 : 6 + len(problem.chain.names)]
        responses = np.diff(mean @ columns, axis=0)[::-1].transpose(2, 0, 1)
        return cls(responses, _least(problem, grid, own), grid.step, grid.window)

    def covariance(self, chain: WindowChain) -> np.ndarray:
        """Return the covariance of what a window's start and chain miss, (6 + n, 6 + n)."""
        count, steps, _ = self.responses.shape
        matrix = np.zeros((6 + count, 6 + count))
        matrix[6:, 6:] = chain.innovations(self.window)
        together = chain.covariance
        for i, j in zip(*np.nonzero(together), strict=True):
            strays = chain.within(int(i), steps, self.step)
            matrix[:6, :6] += together[i, j] * self.responses[i].T @ strays @ self.responses[j]
        matrix[range(6), range(6)] += self.least**2
        return np.asarray((matrix + matrix.T) / 2)


def _least(problem: LogProblem, grid: RecordGrid, own: RecordUnknowns) -> np.ndarray:
    length = problem.motion.model.configuration.ship.length
    speed = max(float(np.abs(own.starts[:, 3]).mean()), 1e-3)
    least = LEAST * np.array([length, length, 1.0, speed, speed, speed / length])
    if problem.motion.march.ship.surge == "held":
        least[3] = SPEED_WALK * speed * np.sqrt(grid.window)
    return np.asarray(least)


def banded(
    problem: LogProblem, grid: RecordGrid, own: RecordUnknowns, found: WindowEquations, links: WindowLinks | None
) -> BorderedBand:
    """Return the normal equations of a record with all that is known of it before."""
    m = problem.local
    diagonal, border = found.hessian[:, :m, :m].copy(), found.hessian[:, :m, m:].copy()
    corner, right = found.hessian[:, m:, m:].sum(axis=0), found.gradient[:, :m].copy()
    right_border, cost = found.gradient[:, m:].sum(axis=0), found.cost
    diagonal[:, range(6), range(6)] += _start_spread(problem, grid) ** -2.0
    q = len(own.zeros)
    corner[range(q), range(q)] += problem.zero_spread**-2.0
    right_border[:q] -= own.zeros / problem.zero_spread**2
    cost += float(np.sum((own.zeros / problem.zero_spread) ** 2))
    whole = BorderedBand(diagonal, None, border, corner, right, right_border, cost)
    return whole if links is None else _linked(problem, grid, own, found, links, whole)


def _start_spread(problem: LogProblem, grid: RecordGrid) -> np.ndarray:
    """Of a place that is not read, a length for each window: else a chain of them is as good as singular."""
    length = problem.motion.model.configuration.ship.length
    unread = np.array([name not in grid.readings for name in ("x", "y")])
    return np.append(np.where(unread, length, START_SPREAD[:2]), START_SPREAD[2:])


def _linked(
    problem: LogProblem, grid: RecordGrid, own: RecordUnknowns, found: WindowEquations, links: WindowLinks,
    alone: BorderedBand,
) -> BorderedBand:  # fmt: skip
    chain, m = problem.chain, problem.local
    kept, links_count, wide = chain.kept(grid.window), len(grid) - 1, found.hessian.shape[2]
    gap = np.concatenate([own.starts[1:] - found.ends[:-1], own.chain[1:] - kept * own.chain[:-1]], axis=1)
    weight = _weights(problem, grid, links)
    weighed, squares = np.empty((links_count, m, wide)), np.empty((links_count, wide, wide))
    pull, pulled = np.empty((links_count, m)), np.empty((links_count, wide))
    compiled_loops(window_loops).weigh_links(weight, found.end_slopes, kept, gap, weighed, squares, pull, pulled)
    diagonal, border, right = alone.diagonal, alone.border, alone.right
    diagonal[:-1] += squares[:, :m, :m]
    diagonal[1:] += weight
    border[:-1] += squares[:, :m, m:]
    border[1:] -= weighed[:, :, m:]
    right[:-1] += pulled[:, :m]
    right[1:] -= pull
    first = problem.in_meetings if grid.meetings[0] else chain
    known = np.linalg.inv(first.covariance) if chain.names else np.zeros((0, 0))
    diagonal[0, 6:, 6:] += known
    right[0, 6:] -= known @ own.chain[0]
    return BorderedBand(
        diagonal, -weighed[:, :, :m], border, alone.corner + squares[:, m:, m:].sum(axis=0), right,
        alone.right_border + pulled[:, m:].sum(axis=0),
        alone.cost + float(np.sum(gap * pull)) + float(own.chain[0] @ known @ own.chain[0]),
    )  # fmt: skip


def _met(grid: RecordGrid) -> np.ndarray:
    """Whether a link leads into or out of a window in which another ship passes, (windows - 1,)."""
    return np.asarray(grid.meetings[1:] | grid.meetings[:-1])


def _weights(problem: LogProblem, grid: RecordGrid, links: WindowLinks) -> np.ndarray:
    """Of what links miss, (windows - 1, m, m)."""
    loose, met = np.where(grid.whole[:-1], 1.0, LOOSE), _met(grid)
    weight = _weight(links, problem.chain) * loose[:, None, None]
    if met.any():
        weight[met] = _weight(links, problem.in_meetings) * loose[met, None, None]
    return np.asarray(weight)


@lru_cache(maxsize=KEPT)
def _weight(links: WindowLinks, chain: WindowChain) -> np.ndarray:
    """Of what one link misses: a record is linked by one chain again and again."""
    return np.linalg.inv(links.covariance(chain))


def link_determinant(problem: LogProblem, grid: RecordGrid, links: WindowLinks) -> float:
    """Return the logarithm of the determinant of what links windows: what a strong chain costs."""
    chain, met = problem.chain, int(_met(grid).sum())
    cost = (len(grid) - 1 - met) * _log_determinant(links.covariance(chain))
    if met:
        cost += met * _log_determinant(links.covariance(problem.in_meetings))
    first = problem.in_meetings if grid.meetings[0] else chain
    return cost + (_log_determinant(first.covariance) if chain.names else 0.0)


def _log_determinant(matrix: np.ndarray) -> float:
    return float(np.linalg.slogdet(matrix)[1])
