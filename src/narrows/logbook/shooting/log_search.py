"""The search over all records: Gauss and Newton on the coefficients, damped by Levenberg where they go too far.

Each record is brought to its best for the coefficients and leaves a matrix of their size; these add. A record is laid
out when its turn comes, so that memory does not grow with records.
"""

from collections.abc import Container, Iterable, Sequence
from dataclasses import replace

import numpy as np

from narrows.identification.regression.solve import solve
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.record_search import record_best
from narrows.logbook.shooting.search_state import Found, RecordState, RecordTold, determinant_slope, samples_of
from narrows.progress import bar, is_shown

MOST_STEPS = 30
# Of a sum of squares, which a step is to gain; else the search is done, or done for an estimate of noise; and what a
# step that does not help may have promised for it to be done all the same: sums are not known better.
ENOUGH, NEARLY_ENOUGH, FAINT = 0.02, 1.0, 0.1
# Damping over the information of the log: at first, after a step that helped, after one that did not, at least, at
# least after one that did not, and at most.
FIRST, GENTLER, HARDER, LEAST, FELT, MOST = 1e-4, 0.1, 10.0, 1e-9, 0.1, 1e3
# Of a square of a step, which is none.
TINY = 1e-12
# Windows of a log up to which records keep how they follow the coefficients; those of a longer one begin where they
# were.
LED = 50_000

# Records, each laid out when its turn comes, again and again.
Grids = Iterable[RecordGrid]


def evaluated(
    problem: LogProblem, scaled: np.ndarray, grids: Grids, states: Sequence[RecordState], kept: Container[int] = ()
) -> Found | None:
    """Bring every record to its best for coefficients; None where one goes to infinity."""
    # scaled (p,)
    motion, told, stopped = problem.at(scaled), list[RecordTold](), False
    short = sum(len(state.own.starts) for state in states) <= LED
    with bar(len(states), is_shown(), "records") as done:
        try:
            for number, (grid, state) in enumerate(zip(grids, states, strict=True)):
                best = record_best(problem, motion, scaled, grid, state.own, state.links, state.near)
                if best is None:
                    return None
                wide = best.left.determinant if problem.linked else 0.0
                part = RecordTold(best.left.corner, best.left.right, best.left.cost + wide, best.own, wide)
                if number in kept:
                    part = replace(part, residuals=best.found.residuals, best=best)
                told.append(replace(part, follows=best.follows if short else None))
                done(1)
        except KeyboardInterrupt:
            stopped = True
    cost = sum(part.cost for part in told) + float(scaled @ problem.prior.precision @ scaled)
    return Found(scaled, tuple(told), cost, interrupted=stopped)


def _sloped(problem: LogProblem, found: Found, grids: Grids, states: Sequence[RecordState]) -> Found:
    """With the slope of how wide windows are left, by the records whose equations are kept; interrupted, without."""
    if not problem.linked:
        return found
    try:
        slope = determinant_slope(problem, samples_of(grids, found, states), found.scaled)[0]
        return replace(found, slope=found.windows * slope)
    except KeyboardInterrupt:
        return replace(found, interrupted=True)


def found_at(
    problem: LogProblem, scaled: np.ndarray, grids: Grids, states: Sequence[RecordState], kept: Container[int] = ()
) -> Found | None:
    """Bring every record to its best for coefficients that stay, with the slope of how wide windows are left."""
    found = evaluated(problem, scaled, grids, states, kept)
    return found and _sloped(problem, found, grids, states)


def searched(
    problem: LogProblem, scaled: np.ndarray, grids: Grids, states: Sequence[RecordState], kept: Container[int] = (),
    enough: float = ENOUGH, steps: int = MOST_STEPS, slope: np.ndarray | float | None = None,
) -> Found | None:  # fmt: skip
    """Search for the most likely coefficients; None where the motion goes to infinity from the start."""
    # scaled (p,); slope (p,)
    # Interrupted by hand, it gives what the records that were done tell.
    # Bock (1987), Randwertproblemmethoden zur Parameteridentifizierung, for multiple shooting; Levenberg (1944),
    # Quart. Appl. Math. 2, for the damping; Golub and Pereyra (1973), SIAM J. Numer. Anal. 10, for the elimination.
    found = evaluated(problem, scaled, grids, states, kept)
    if found is None:
        return None
    if found.interrupted:
        if not found.told:
            raise KeyboardInterrupt
        return replace(found, scaled=found.scaled + _step(problem, found, FIRST)[0])
    damping, fresh = FIRST, slope is None or not problem.linked
    found = replace(found, slope=slope) if slope is not None else _sloped(problem, found, grids, states)
    for number in range(1, steps + 1):
        _remember(states, found)
        if found.interrupted:
            return replace(found, rounds=number)
        if (gain := _step(problem, found, FIRST)[1]) < enough:
            if fresh:
                return replace(found, rounds=number, settled=True)
            found, fresh = _sloped(problem, found, grids, states), True
            continue
        step, _ = _step(problem, found, damping)
        after = evaluated(problem, found.scaled + step, grids, _led(states, found, step), kept)
        if after is not None and after.interrupted:
            return replace(found, rounds=number, interrupted=True)
        if after is not None and after.cost < found.cost + ENOUGH / 10:
            found, damping, fresh = _carried(problem, found, after), max(damping * GENTLER, LEAST), not problem.linked
        elif not fresh:
            found, fresh = _sloped(problem, found, grids, states), True
        elif gain < FAINT:
            return replace(found, rounds=number, settled=True)
        elif (damping := max(damping * HARDER, FELT)) > MOST:
            break
    _remember(states, found)
    return replace(found, rounds=steps)


def _led(states: Sequence[RecordState], found: Found, step: np.ndarray) -> list[RecordState]:
    """Where records begin at coefficients a step on."""
    return [
        replace(state, own=told.own_after(step), near=told.follows is not None)
        for state, told in zip(states, found.told, strict=True)
    ]


def _carried(problem: LogProblem, before: Found, after: Found) -> Found:
    """With the slope of how wide windows are left carried on: turned by what it foretold wrongly of the step."""
    step = after.scaled - before.scaled
    wider = sum(new.wide - old.wide for new, old in zip(after.told, before.told, strict=True)) / 2
    heavy = (after.information + problem.prior.precision) @ step
    turn = 2 * (wider - np.sum(before.slope * step)) / max(step @ heavy, TINY) * heavy
    return replace(after, slope=before.slope + turn)


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
