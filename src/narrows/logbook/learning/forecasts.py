"""Forecasts of a record: begun now and then where the ship most likely was, sailed under the recorded rudder."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.window_equations import Pushes, RecordUnknowns, drifting

# Times of a ship length that a forecast reaches.
AHEAD = 3.5
# Of what a forecast is judged by: places among the states.
STATES_JUDGED = {"y": 1, "psi": 2, "r": 5}


@dataclass(frozen=True)
class Forecast:
    """Pieces of a voyage, each begun anew."""

    t: np.ndarray  # (n,) Nodes of all pieces, the end of one and the begin of the next at the same time [s]
    states: np.ndarray  # (n, 6) x, y, psi, u, v, r as foretold
    ends: np.ndarray  # (pieces,) Where each piece ends
    likely: np.ndarray  # (pieces, 6) Where the record makes it most likely that the ship was then
    rudder: np.ndarray  # (n,) As recorded, and its zero [rad]


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
