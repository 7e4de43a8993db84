"""Fisher scoring over all records with a trust region: Levenberg's damping, within the bounds of the coefficients.

Each record contributes a score and an information matrix; these add. A record is laid out when its turn comes.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from narrows.identification.least_squares import solve
from narrows.logbook.filtering.likelihood import RecordLikelihood, RecordPath, RecordScore, readings_for_one
from narrows.logbook.filtering.log_problem import LogProblem, Unknowns
from narrows.logbook.filtering.record_grid import RecordGrid
from narrows.progress import bar, is_shown

MOST_STEPS = 15
CONVERGED_GAIN = 0.1  # Smallest gain of a step in minus twice the log-posterior; below it the search ends
PASSES, FIRST_PASSES = 1, 4  # Smoothing passes of a reference path, and of the first one
LONGEST_MOVE = 2.0  # Longest step [prior standard deviations]
LEAST_GAIN = 0.1  # Smallest accepted gain, over the expected one [1]
# Damping over the information: initial, factors after an accepted and a rejected step, and the largest.
FIRST, GENTLER, HARDER, MOST = 1e-3, 0.1, 10.0, 1e4
KEPT_STEPS = 200_000  # Time steps of records whose paths are stored; longer logs smooth each path anew
RESTARTS = 3  # Restarts of the search with another number of correlated readings
SETTLED = 1.2  # Ratio of two such numbers below which the last one is kept
LOOSE_WALK = 1e-3  # Process noise over lengths and speeds of the ship, where no whole record can be followed

Grids = Iterable[RecordGrid]


@dataclass(frozen=True)
class SearchResult:
    problem: LogProblem
    unknowns: np.ndarray  # (P,) Scaled coefficients, then the estimated numbers of the stochastic model
    records: tuple[RecordScore, ...]
    steps: int = 0
    converged: bool = False
    interrupted: bool = False
    diverged: bool = False

    @property
    def scaled(self) -> np.ndarray:
        return self.unknowns[: self.problem.count]

    @property
    def information(self) -> np.ndarray:
        return np.asarray(sum(one.information for one in self.records))

    @property
    def score(self) -> np.ndarray:
        return np.asarray(sum(one.score for one in self.records))


def search(
    problem: LogProblem, grids: Grids, steps: int = MOST_STEPS, scaled: np.ndarray | None = None
) -> SearchResult | None:
    """Maximise the posterior, over short stretches where whole records diverge; None where these diverge too."""
    # It begins at scaled coefficients (p,), or those of the prior. Without disturbances the residuals of a record are
    # correlated: the likelihood then counts one of so many readings, as a composite likelihood does.
    begin = np.zeros(len(problem.precision))
    begin[: problem.count] = 0.0 if scaled is None else scaled
    found = _maximum(problem, grids, begin, (), steps)
    if found is None or found.diverged:
        problem = replace(problem, walk=LOOSE_WALK)
        found = _maximum(problem, grids, np.zeros(len(problem.precision)), (), steps)
    for _ in range(RESTARTS * (not problem.model.gusts)):
        if found is None or found.interrupted or not found.records:
            break
        counted = readings_for_one(np.sum([one.autocovariance for one in found.records], axis=0))
        if max(counted / problem.correlated, problem.correlated / counted) < SETTLED:
            break
        problem = replace(problem, correlated=counted)
        found = _maximum(problem, grids, found.unknowns, [one.path for one in found.records], steps) or found
    return found


def _maximum(
    problem: LogProblem, grids: Grids, unknowns: np.ndarray, paths: Iterable[RecordPath | None], steps: int
) -> SearchResult | None:
    damping, found, paths = FIRST, None, list(paths)
    for number in range(1, steps + 1):
        after = scored(problem, grids, unknowns, paths, PASSES if found else FIRST_PASSES)
        if after is None or (after.interrupted and found):
            return found and replace(found, interrupted=after is not None, diverged=after is None)
        found = replace(after, steps=number)
        step, gain = bounded_step(problem, unknowns, found.score, found.information)
        if gain < CONVERGED_GAIN or found.interrupted:
            return replace(found, unknowns=unknowns + step, converged=gain < CONVERGED_GAIN)
        paths = [one.path for one in found.records]
        try:
            moved = _helpful(problem, found, grids, damping)
        except KeyboardInterrupt:
            return replace(found, interrupted=True)
        if moved is None:
            return found
        unknowns, damping = unknowns + moved[0], moved[1] * GENTLER
    return found


def scored(
    problem: LogProblem, grids: Grids, unknowns: np.ndarray, paths: list[RecordPath | None], passes: int
) -> SearchResult | None:
    """Smooth the path of every record and score it there, the finished ones after Ctrl-C; None where one diverges."""
    scores, steps, total = list[RecordScore](), 0, len(paths)
    try:
        with bar(total, is_shown(), "records") as done:
            for number, grid in enumerate(grids):
                likelihood, before = RecordLikelihood(problem, grid), paths[number] if number < len(paths) else None
                path = likelihood.smoothed(unknowns, before, passes if before else FIRST_PASSES)
                if path is None:
                    return None
                one, steps = likelihood.scored(unknowns, path), steps + len(grid)
                if not np.isfinite(one.cost):
                    return None
                scores.append(one if steps <= KEPT_STEPS else replace(one, path=None))
                done(1)
    except KeyboardInterrupt:
        if not scores:
            raise
        return SearchResult(problem, unknowns, tuple(scores), interrupted=True)
    return SearchResult(problem, unknowns, tuple(scores))


def _helpful(problem: LogProblem, found: SearchResult, grids: Grids, damping: float) -> tuple[np.ndarray, float] | None:
    """An accepted step about the same paths, and its damping; None if no step gains enough."""

    def cost(unknowns: np.ndarray) -> float:
        parts = 0.0
        for grid, one in zip(grids, found.records, strict=True):
            likelihood = RecordLikelihood(problem, grid)
            path = one.path or likelihood.smoothed(found.unknowns, None, FIRST_PASSES)
            parts += likelihood.cost(unknowns, path) if path else np.inf
        return parts + float(unknowns @ problem.precision @ unknowns)

    here = sum(one.cost for one in found.records) + float(found.unknowns @ problem.precision @ found.unknowns)
    while damping < MOST:
        step, gain = bounded_step(problem, found.unknowns, found.score, found.information, damping)
        if here - cost(found.unknowns + step) > LEAST_GAIN * gain:
            return step, damping
        damping = max(damping, FIRST) * HARDER
    return None


def bounded_step(
    problem: Unknowns, unknowns: np.ndarray, score: np.ndarray, information: np.ndarray, damping: float = 0.0
) -> tuple[np.ndarray, float]:
    """Return the step of Fisher scoring within the bounds, and its expected gain in minus twice the log-posterior."""
    right, matrix = score - problem.precision @ unknowns, information + problem.precision
    damped, count = matrix + damping * np.diag(np.diag(matrix)), problem.count
    root = np.sqrt(np.diag(damped))
    low, high = np.full(len(right), -LONGEST_MOVE), np.full(len(right), LONGEST_MOVE)
    for ends, limit, pick in zip((low, high), problem.prior.limits, (np.maximum, np.minimum), strict=True):
        ends[:count] = pick(ends[:count], limit - unknowns[:count])
    low, high = np.minimum(low * root, 0.0), np.maximum(high * root, 0.0)
    step = solve(damped / np.outer(root, root), right / root, low, high).z / root
    return step, float(2 * right @ step - step @ matrix @ step)
