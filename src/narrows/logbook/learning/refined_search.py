"""The search with noise and gusts estimated between: until neither moves."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from narrows.errors import InputError
from narrows.logbook.learning.posed_log import GridSource
from narrows.logbook.shooting.chain_likelihood import GustJudge, gust_doubt, likely_gusts
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.log_search import ENOUGH, MOST_STEPS, NEARLY_ENOUGH, searched
from narrows.logbook.shooting.noise_left import NoiseLeft, noise_left, overdispersion
from narrows.logbook.shooting.push_chain import WindowChain
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.record_search import first_guess
from narrows.logbook.shooting.search_state import Found, RecordState, samples_of
from narrows.logbook.shooting.window_links import WindowLinks
from narrows.progress import stage

# Of estimates of noise and gusts, and the change of their logarithms under which they stay.
ROUNDS, SETTLED = 10, 0.2
# Of the search before the first estimates: with gusts too weak many records would lead it far away.
FIRST_STEPS = (0, 2, 4)
# Records beyond which so many of the first are searched alone before: the others then begin near.
MANY, FEW = 6, 3
# Rounds in which gusts are estimated.
OF_GUSTS = 5
# Records by which gusts and noise are judged, spread over the log; and where windows stand alone.
SAMPLES, SAMPLES_ALONE = 24, 64
# Over the noise of a grade, from which what is left of a signal counts instead.
WORSE = 1.2
RUNS_AWAY = (
    "the model cannot follow this log at all: its motion goes to infinity; look at signs and axes with `check_log`"
)


@dataclass(frozen=True)
class Refined:
    """A search that is done."""

    problem: LogProblem  # With the noise and the gusts that were found
    found: Found  # Coefficients, and what each record tells
    states: tuple[RecordState, ...]  # Where each record stands
    left: dict[str, NoiseLeft]  # What the model leaves of each signal
    usual: WindowChain  # Gusts as they are taken to be before a log tells
    # (p, k) How far the coefficients go with each independent standard deviation of what gusts may be [1]
    gust_doubt: np.ndarray


# Of how wide windows are left, as far as it is known.
Slope = np.ndarray | float | None


class SearchedRecords(NamedTuple):
    """Records that are searched."""

    grids: Iterable[RecordGrid]  # Each laid out when its turn comes, again and again
    states: Sequence[RecordState]  # Where each stands


def refined_search(problem: LogProblem, source: GridSource, scaled: np.ndarray | None = None) -> Refined:
    """Search for coefficients, noise and gusts : of a long log by its first records, then by all of them."""
    # scaled (p,)
    scaled = np.zeros(len(problem.prior.groups)) if scaled is None else scaled
    least, usual = source.assumptions.least_noise, problem.chain
    states = begun(problem, source, scaled)
    if not states:
        raise InputError(f"no record of this log can be used: {' '.join(source.left_out) or 'it has none.'}")
    steps, slope = FIRST_STEPS if problem.linked else (), None
    if problem.linked and len(states) > MANY:
        part = SearchedRecords(tuple(islice(source, FEW)), states[:FEW])
        problem, found = _in_rounds(problem, scaled, part, least, usual, steps)
        if found.interrupted:
            return _refined(problem, found, part, states, usual)
        scaled, steps, slope = found.scaled, (), found.slope_of(states)
    every = SearchedRecords(source, states)
    problem, found = _in_rounds(problem, scaled, every, least, usual, steps, slope)
    if not found.interrupted:
        found = _searched(problem, found.scaled, every, ENOUGH, MOST_STEPS, found.slope)
    return _refined(problem, found, every, states, usual)


def _in_rounds(
    problem: LogProblem, scaled: np.ndarray, records: SearchedRecords, least: dict[str, float], usual: WindowChain,
    steps: Sequence[int], slope: Slope = None,
) -> tuple[LogProblem, Found]:  # fmt: skip
    """Search, and estimate noise and gusts, in turn; the first searches of so many steps."""
    for number in range(ROUNDS):
        most = steps[number] if number < len(steps) else MOST_STEPS
        found = _searched(problem, scaled, records, NEARLY_ENOUGH, most, slope)
        if found.interrupted:
            break
        try:
            after = _reestimated(problem, records, found, least, usual if number < OF_GUSTS else None)
        except KeyboardInterrupt:
            return problem, replace(found, interrupted=True)
        problem, scaled, moved = after, found.scaled, _moved(problem, after)
        slope = found.slope if number >= len(steps) else None
        if moved < SETTLED:
            break
    return problem, found


def _refined(
    problem: LogProblem, found: Found, records: SearchedRecords, states: Sequence[RecordState], usual: WindowChain
) -> Refined:
    """A search that is done or interrupted, with what doubts of the gusts do to it."""
    doubt = np.zeros((len(found.scaled), 0))
    if problem.linked and not found.interrupted:
        try:
            doubt = gust_doubt(GustJudge(problem, found, samples_of(records.grids, found, records.states), usual))
        except KeyboardInterrupt:
            found = replace(found, interrupted=True)
    return Refined(problem, found, tuple(states), noise_left(records.grids, found), usual, doubt)


def _searched(
    problem: LogProblem, scaled: np.ndarray, records: SearchedRecords, enough: float, steps: int, slope: Slope
) -> Found:
    kept = sampled(len(records.states), problem.linked)
    with stage("fitting the records"):
        found = searched(problem, scaled, records.grids, records.states, kept, enough, steps, slope)
    if found is None:
        raise InputError(RUNS_AWAY)
    return found


def begun(problem: LogProblem, source: GridSource, scaled: np.ndarray) -> list[RecordState]:
    """Return where records begin: what they say of the states themselves, and links by the motion there."""
    # scaled (p,)
    motion, states = problem.at(scaled), []
    for grid in source:
        own = first_guess(problem, grid)
        links = WindowLinks.of(problem, motion, scaled, grid, own) if problem.linked else None
        states.append(RecordState(own, links))
    return states


def sampled(count: int, linked: bool) -> frozenset[int]:
    """Return the records by which gusts and noise are judged."""
    most = min(count, SAMPLES if linked else SAMPLES_ALONE)
    return frozenset(np.linspace(0, count - 1, most).round().astype(int).tolist())


def _reestimated(
    problem: LogProblem, records: SearchedRecords, found: Found, least: dict[str, float], usual: WindowChain | None
) -> LogProblem:
    """Noise of the grade, or what the model leaves where that is more; gusts by their likelihood."""
    left = noise_left(records.grids, found)
    if not problem.linked:
        return problem.with_noise(_noise_alone(problem, found, left, least))
    noise = {name: own.size if own.size > WORSE * least[name] else least[name] for name, own in left.items()}
    problem = problem.with_noise(noise)
    if usual is not None:
        judge = GustJudge(problem, found, samples_of(records.grids, found, records.states), usual)
        problem = replace(problem, chain=likely_gusts(judge))
    return problem


def _noise_alone(
    problem: LogProblem, found: Found, left: dict[str, NoiseLeft], least: dict[str, float]
) -> dict[str, float]:
    """Noise where windows stand alone: the model's own error is in it, its memory, and how windows disagree."""
    counted = {name: max(least[name], own.counted) for name, own in left.items()}
    before = np.mean([np.log(problem.noise[name] / size) for name, size in counted.items()])
    windows = (told.best.found for told in found.told if told.best is not None)
    factor = np.sqrt(max(1.0, overdispersion(problem, windows) * float(np.exp(2 * before))))
    return {name: float(factor * size) for name, size in counted.items()}


def _moved(before: LogProblem, after: LogProblem) -> float:
    """The largest change of a logarithm."""
    pairs = [(before.noise[name], size) for name, size in after.noise.items()]
    pairs += list(zip(before.chain.std.tolist(), after.chain.std.tolist(), strict=True))
    return max((abs(float(np.log(new / old))) for old, new in pairs if old > 0 and new > 0), default=0.0)
