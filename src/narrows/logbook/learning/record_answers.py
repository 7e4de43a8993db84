"""What each record did to the answer, and how well the model foretells it without having seen it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from narrows.logbook.learning.log_posterior import scaled_covariance
from narrows.logbook.learning.refined_search import Refined
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.search_state import RecordTold
from narrows.logbook.shooting.window_equations import Pushes, RecordUnknowns, drifting

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


def record_answers(refined: Refined, grids: Iterable[RecordGrid]) -> tuple[RecordAnswer, ...]:
    """Return what each record did."""
    pairs = zip(grids, refined.found.told, strict=False)
    return tuple(_answer(refined, grid, told, number < MOST_DRAWN) for number, (grid, told) in enumerate(pairs))


def _answer(refined: Refined, grid: RecordGrid, told: RecordTold, drawn: bool) -> RecordAnswer:
    prior, found, problem = refined.problem.prior, refined.found, refined.problem
    whole = np.diag(scaled_covariance(prior, found.information))
    without = scaled_covariance(prior, found.information - told.information)
    moved = np.where(prior.moves, without @ (found.pull_of(told) * prior.moves), 0.0)
    gone = np.clip(1 - whole / np.diag(without), 0.0, 1.0)
    before_it = np.zeros(len(moved))  # which is what is known without the only record, too
    without_it = found.scaled - moved if len(found.told) > 1 else before_it
    both = tuple(forecast(problem, at, grid, told.own) for at in (before_it, without_it))
    before, after = (missed(each) for each in both)
    return RecordAnswer(
        grid.record.name, float(grid.times[-1] - grid.times[0]), len(grid), int(grid.meetings.sum()),
        dict(zip(problem.zeros, told.own.zeros.tolist(), strict=True)),
        dict(zip(prior.names, gone.tolist(), strict=True)),
        dict(zip(prior.names, (moved * prior.scale).tolist(), strict=True)),
        {name: (before[name], after[name]) for name in STATES_JUDGED},
        (both[0], both[1]) if drawn else None,
        _measured(grid) if drawn else {},
    )  # fmt: skip


def _measured(grid: RecordGrid) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    read = {name: grid.readings[name] for name in ("x", *STATES_JUDGED) if name in grid.readings}
    return {name: (grid.times[grid.first[own.window]] + own.elapsed, own.values) for name, own in read.items()}


# Forecasts of a record: begun now and then where the ship most likely was, sailed under the recorded rudder.
# Times of a ship length that a forecast reaches.
AHEAD = 3.5

# Of what a forecast is judged by: places among the states.
STATES_JUDGED = {"y": 1, "psi": 2, "r": 5}


def forecast(problem: LogProblem, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns) -> Forecast:
    """Return forecasts of a record: what is steady of wind and errors is known, gusts are not."""
    # scaled (p,)
    speed = max(float(np.abs(own.starts[:, 3]).mean()), 1e-3)
    reach = AHEAD * problem.motion.model.configuration.ship.length / speed
    every = max(1, min(round(reach / grid.window), (len(grid) - 1) // 2))
    begun = np.arange(0, len(grid), every)
    first = grid.first[begun]
    still = RecordUnknowns(own.starts[begun[:-1]], 0 * own.chain[begun[:-1]], own.zeros)
    pushes = Pushes.of(problem, scaled, still)
    with np.errstate(all="ignore"):  # A model before the log may run away.
        states, _ = problem.at(scaled).sailed(
            still.starts, pushes.forces, first, grid.times, grid.positions, pushes.rudder, pushes.current
        )
    nodes = np.concatenate([np.arange(low, high + 1) for low, high in pairwise(first)])
    pieces = np.repeat(grid.times[first[:-1]], np.diff(first) + 1)
    for state, place in drifting(problem):
        states[:, state] += own.zeros[place] * (grid.times[nodes] - pieces)
    offset = float(pushes.rudder[0]) if len(pushes.rudder) else 0.0
    rudder = grid.positions.get("rudder", np.zeros(len(grid.times)))[nodes] + offset
    ends = first[1:] - first[0] + np.arange(len(first) - 1)
    return Forecast(grid.times[nodes], states, ends, own.starts[begun[1:]], rudder)


def missed(foretold: Forecast) -> dict[str, float]:
    """Return the root mean square of the ends of forecasts less where the ship most likely was, by state."""
    with np.errstate(all="ignore"):  # What ran away is far off, and may be so without end.
        off = foretold.states[foretold.ends] - foretold.likely
        root = np.sqrt(np.mean(off**2, axis=0)) if len(off) else np.full(6, np.nan)
    return {name: float(root[place]) for name, place in STATES_JUDGED.items()}
