"""What each record did to the answer, and how well the model foretells it without having seen it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from narrows.logbook.learning.log_posterior import scaled_covariance
from narrows.logbook.learning.nomoto import fitted_nomoto, heading_record, nomoto_missed
from narrows.logbook.learning.refined_search import Refined
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.record_search import record_best
from narrows.logbook.shooting.search_state import RecordTold
from narrows.logbook.shooting.window_equations import Pushes, RecordUnknowns, drifting

# Records up to which a Nomoto model is fitted beside, each left out in turn.
MOST_COMPARED = 40
# Records whose forecasts are kept to be drawn.
MOST_DRAWN = 4


@dataclass(frozen=True)
class Forecast:
    """Pieces of a voyage, each begun anew."""

    t: np.ndarray  # (n,) Nodes of all pieces, the end of one and the begin of the next at the same time [s]
    states: np.ndarray  # (n, 6) x, y, psi, u, v, r as foretold
    ends: np.ndarray  # (pieces,) Where each piece ends
    likely: np.ndarray  # (pieces, 6) Where the record makes it most likely that the ship was then
    rudder: np.ndarray  # (n,) As recorded, and its zero [rad]


@dataclass(frozen=True)
class RecordAnswer:
    """A record and the coefficients."""

    name: str  # Of the record
    duration: float  # How long [s]
    windows: int  # Into how many it was cut
    met: int  # In how many of them another ship passed
    zeros: dict[str, float]  # What was the same all through it, in SI; pushes as accelerations
    information: dict[str, float]  # Share of what is known of each coefficient that is gone without the record [1]
    moved: dict[str, float]  # How far the record moves each coefficient
    # Root mean square of what forecasts over 3.5 ship lengths miss of y [m], psi [rad] and r [rad/s]: by the model
    # before, and by one that learned from all other records
    missed: dict[str, tuple[float, float]]
    forecasts: tuple[Forecast, Forecast] | None = None  # By those two models, where they are kept to be drawn
    # (array, array) Times [s] and readings of x, y, psi and r, where forecasts are kept
    measured: Mapping[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    # Root mean square of what the whole record, sailed from a fitted start under its recorded rudder, misses of the
    # heading [rad]: by the model before, by one that learned from all other records, by a nonlinear Nomoto model fitted
    # to all other records; empty where gusts act
    whole: Mapping[str, float] = field(default_factory=dict)


def record_answers(refined: Refined, grids: Iterable[RecordGrid]) -> tuple[RecordAnswer, ...]:
    """Return what each record did."""
    pairs = zip(grids, refined.found.told, strict=False)
    answers = tuple(_answer(refined, grid, told, number < MOST_DRAWN) for number, (grid, told) in enumerate(pairs))
    if refined.problem.linked or refined.found.interrupted or len(answers) > MOST_COMPARED:
        return answers
    missed = _nomoto_missed(refined, grids)
    return tuple(
        replace(answer, whole={**answer.whole, "nomoto": miss}) if answer.whole else answer
        for answer, miss in zip(answers, missed, strict=True)
    )


def _nomoto_missed(refined: Refined, grids: Iterable[RecordGrid]) -> list[float]:
    """Headings missed by Nomoto models, each fitted to all other records; to the only record itself."""
    records = [heading_record(grid) for grid in grids]
    known = [record for record in records if record is not None]
    speed = float(refined.problem.motion.choices["u"])
    time = refined.problem.motion.model.configuration.ship.length / speed
    missed = []
    for record in records:
        others = [other for other in known if other is not record] or known
        missed.append(np.nan if record is None else nomoto_missed(fitted_nomoto(others, time), record))
    return missed


def _answer(refined: Refined, grid: RecordGrid, told: RecordTold, drawn: bool) -> RecordAnswer:
    prior, found, problem = refined.problem.prior, refined.found, refined.problem
    whole = np.diag(scaled_covariance(prior, found.information))
    without = scaled_covariance(prior, found.information - told.information)
    moved = np.where(prior.moves, without @ (found.pull_of(told) * prior.moves), 0.0)
    gone = np.clip(1 - whole / np.diag(without), 0.0, 1.0)
    before_it = np.zeros(len(moved))  # which is what is known without the only record, too
    without_it = found.scaled - moved if len(found.told) > 1 else before_it
    pieces = forecast_pieces(problem, found.scaled, grid, told.own)
    both = tuple(forecast(problem, at, grid, told.own, pieces) for at in (before_it, without_it))
    sailed: dict[str, float] = {} if problem.linked else {
        word: whole_missed(problem, at, grid, told.own) for word, at in (("before", before_it), ("after", without_it))
    }  # fmt: skip
    before, after = (missed(each) for each in both)
    return RecordAnswer(
        grid.record.name, float(grid.times[-1] - grid.times[0]), len(grid), int(grid.meetings.sum()),
        dict(zip(problem.zeros, told.own.zeros.tolist(), strict=True)),
        dict(zip(prior.names, gone.tolist(), strict=True)),
        dict(zip(prior.names, (moved * prior.scale).tolist(), strict=True)),
        {name: (before[name], after[name]) for name in STATES_JUDGED},
        (both[0], both[1]) if drawn else None,
        _measured(grid) if drawn else {}, sailed,
    )  # fmt: skip


def _measured(grid: RecordGrid) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    read = {name: grid.readings[name] for name in ("x", *STATES_JUDGED) if name in grid.readings}
    return {name: (grid.times[grid.first[own.window]] + own.elapsed, own.values) for name, own in read.items()}


# Forecasts of a record: begun now and then where the ship most likely was, sailed under the recorded rudder.
# Times of a ship length that a forecast reaches.
AHEAD = 3.5

# Of what a forecast is judged by: places among the states.
STATES_JUDGED = {"y": 1, "psi": 2, "r": 5}


class ForecastPieces(NamedTuple):
    """Where forecasts of a record begin and end."""

    first: np.ndarray  # (pieces + 1,) Nodes
    states: np.ndarray  # (pieces + 1, 6) Where the record makes it most likely that the ship was then
    chain: np.ndarray  # (pieces + 1, n) Numbers of the chain, which forecasts do not know: zeros


def forecast_pieces(problem: LogProblem, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns) -> ForecastPieces:
    """Cut a record into pieces of 3.5 ship lengths."""
    # scaled (p,)
    speed = max(float(np.abs(own.starts[:, 3]).mean()), 1e-3)
    reach = AHEAD * problem.motion.model.configuration.ship.length / speed
    if grid.window <= reach:
        every = max(1, min(round(reach / grid.window), (len(grid) - 1) // 2))
        begun = np.arange(0, len(grid), every)
        return ForecastPieces(grid.first[begun], own.starts[begun], 0 * own.chain[begun])
    pushes = Pushes.of(problem, scaled, own)
    states, _ = problem.at(scaled).of_records.sailed(
        own.starts, pushes.forces, grid.first, grid.times, grid.positions, pushes.rudder, pushes.current
    )
    first = np.arange(0, len(grid.times), max(1, round(reach / grid.step)))
    rows = first + np.searchsorted(grid.first[1:-1], first, side="right")
    return ForecastPieces(first, states[rows], np.zeros((len(first), own.chain.shape[1])))


def forecast(
    problem: LogProblem, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns, pieces: ForecastPieces
) -> Forecast:
    """Return forecasts of a record: what is steady of wind and errors is known, gusts are not."""
    # scaled (p,)
    first = pieces.first
    still = RecordUnknowns(pieces.states[:-1], pieces.chain[:-1], own.zeros)
    pushes = Pushes.of(problem, scaled, still)
    with np.errstate(all="ignore"):  # A model before the log may run away.
        states, _ = problem.at(scaled).sailed(
            still.starts, pushes.forces, first, grid.times, grid.positions, pushes.rudder, pushes.current
        )
    nodes = np.concatenate([np.arange(low, high + 1) for low, high in pairwise(first)])
    begun = np.repeat(grid.times[first[:-1]], np.diff(first) + 1)
    for state, place in drifting(problem):
        states[:, state] += own.zeros[place] * (grid.times[nodes] - begun)
    offset = float(pushes.rudder[0]) if len(pushes.rudder) else 0.0
    rudder = grid.positions.get("rudder", np.zeros(len(grid.times)))[nodes] + offset
    ends = first[1:] - first[0] + np.arange(len(first) - 1)
    return Forecast(grid.times[nodes], states, ends, pieces.states[1:], rudder)


def whole_missed(problem: LogProblem, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns) -> float:
    """Return what a whole record misses of the heading, the start of each window fitted and nothing else [rad]."""
    # scaled (p,)
    alone = replace(problem, zeros={})
    start = replace(own, zeros=np.zeros(0))
    best = record_best(alone, problem.at(scaled), scaled, grid, start, None)
    left = None if best is None else best.found.residuals.get("psi")
    return np.inf if best is None else np.nan if left is None else float(np.sqrt(np.mean(left**2)))


def missed(foretold: Forecast) -> dict[str, float]:
    """Return the root mean square of the ends of forecasts less where the ship most likely was, by state."""
    with np.errstate(all="ignore"):  # What ran away is far off, and may be so without end.
        off = foretold.states[foretold.ends] - foretold.likely
        root = np.sqrt(np.mean(off**2, axis=0)) if len(off) else np.full(6, np.nan)
    return {name: float(root[place]) for name, place in STATES_JUDGED.items()}
