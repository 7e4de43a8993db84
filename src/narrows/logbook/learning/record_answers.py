"""What each record did to the answer, and how well the model foretells it without having seen it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from narrows.logbook.learning.forecasts import STATES_JUDGED, Forecast, forecast, missed
from narrows.logbook.learning.log_posterior import scaled_covariance
from narrows.logbook.learning.refined_search import Refined
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.search_state import RecordTold

# Records whose forecasts are kept to be drawn.
MOST_DRAWN = 4


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
