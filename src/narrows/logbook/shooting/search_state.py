"""Where a search over records stands: what each record has of its own and tells of the coefficients."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from narrows.logbook.shooting.bordered_band import Eliminated
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.push_chain import WindowChain
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.record_search import FollowingUnknowns, RecordPlace
from narrows.logbook.shooting.window_equations import RecordUnknowns, WindowEquations, window_equations
from narrows.logbook.shooting.window_links import WindowLinks, banded


@dataclass
class RecordState:
    """A record in the search."""

    own: RecordUnknowns  # Where it stands
    links: WindowLinks | None  # Between its windows
    near: bool = False  # Whether it is likely to be at its best


@dataclass(frozen=True)
class RecordTold:
    """What one record tells of the coefficients, where the search stands."""

    information: np.ndarray  # (p, p) In units of the standard deviations before [1]
    pull: np.ndarray  # (p,) Half the slope of its sum of squares, downhill [1]
    cost: float  # Its sum of squares, all of its own at its best, and how wide its windows are left [1]
    own: RecordUnknowns  # What it has of its own
    wide: float = 0.0  # Of the cost, the logarithm of the determinant of its windows [1]
    residuals: Mapping[str, np.ndarray] | None = None  # Read less predicted, where the equations are kept
    best: RecordPlace | None = None  # All of it, where it was asked to be kept
    follows: FollowingUnknowns | None = None  # How what it has of its own follows the coefficients, where that is kept

    def own_after(self, step: np.ndarray) -> RecordUnknowns:
        """Return what it has of its own where the coefficients are a step on, to the first order."""
        # step (p,)
        return self.own if self.follows is None else self.follows.moved(self.own, step)


@dataclass(frozen=True)
class Found:
    """Where a search stands."""

    scaled: np.ndarray  # (p,) Coefficients in units of their standard deviations before [1]
    told: tuple[RecordTold, ...]  # By record
    cost: float  # Sum of squares with the prior, and how wide windows are left [1]
    # (p,) How half the logarithm of the determinant of windows goes with the coefficients; 0 where these stand alone
    # [1]
    slope: np.ndarray | float = 0.0
    rounds: int = 0  # Steps that it took
    settled: bool = False  # Whether a further step would gain nothing
    interrupted: bool = False  # Whether it was stopped by hand, perhaps before all records were looked at

    @property
    def information(self) -> np.ndarray:
        """Of all records, without the prior, (p, p) [1]."""
        return np.asarray(sum(told.information for told in self.told))

    @property
    def pull(self) -> np.ndarray:
        """Of all records, how wide windows are left included, (p,) [1]."""
        return np.asarray(sum(told.pull for told in self.told) - self.slope)

    @property
    def windows(self) -> int:
        """How many there are in all records."""
        return sum(len(told.own.starts) for told in self.told)

    def slope_of(self, states: Sequence[RecordState]) -> np.ndarray | float:
        """Return the slope of other records, were their windows left as wide, (p,) [1]."""
        return sum(len(state.own.starts) for state in states) / self.windows * self.slope

    def repeated(self, copies: float) -> "Found":
        """Return what so many records of the kind would tell for each, but for what they pull by chance."""
        told = tuple(replace(told, information=copies * told.information) for told in self.told)
        return replace(self, told=told, slope=copies * self.slope)

    def pull_of(self, told: RecordTold) -> np.ndarray:
        """Return that of one record, (p,) [1]."""
        return np.asarray(told.pull - len(told.own.starts) / self.windows * self.slope)


class SampledRecord(NamedTuple):
    """A record by which gusts, and how wide windows are left, are judged."""

    grid: RecordGrid  # The record
    told: RecordTold  # With its equations
    links: WindowLinks  # Between its windows

    @property
    def found(self) -> WindowEquations:
        """Its equations."""
        assert self.told.best is not None
        return self.told.best.found

    def follows(self, problem: LogProblem) -> FollowingUnknowns:
        """Return how its record-specific unknowns follow the coefficients.

        Parameters
        ----------
        problem : LogProblem
            With the chain that links its windows.
        """
        own = self.told.own
        band = banded(problem, self.grid, own, self.found, self.links)
        return FollowingUnknowns(*band.eliminated().followed(len(own.zeros)))

    def left(self, problem: LogProblem, found: WindowEquations) -> Eliminated:
        """Return what is left of its equations without all that it has of its own."""
        own = self.told.own
        return banded(problem, self.grid, own, found, self.links).eliminated().without(len(own.zeros))


def samples_of(grids: Iterable[RecordGrid], found: Found, states: Sequence[RecordState]) -> list[SampledRecord]:
    """Return the records whose equations are kept."""
    return [
        SampledRecord(grid, told, state.links)
        for grid, told, state in zip(grids, found.told, states, strict=False)
        if told.best is not None and state.links is not None
    ]


# What a likelihood of readings has beyond the best windows: how wide the windows are left, and how that moves. Starts
# and pushes that are at their best for the readings make a ship look as damped as suits them: with many windows the
# coefficients err by it. Integrated out instead, they leave the determinant of their equations.
# Of a difference, in standard deviations before.
STEP = 0.02


def determinant_slope(
    problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray, chains: Sequence[WindowChain] = ()
) -> np.ndarray:
    """Return the slope of half the logarithm of the determinant of a window by the coefficients, (chains, p)."""
    # scaled (p,)
    # Tierney and Kadane (1986), Accurate approximations for posterior moments and marginal densities, J. Am. Stat.
    # Assoc. 81, for the approximation; Neyman and Scott (1948), Econometrica 16, for what comes of leaving it out.
    linked = [replace(problem, chain=chain) for chain in chains] or [problem]
    none = np.zeros((len(linked), len(scaled)))
    try:
        slope = np.stack([_slope(problem, samples, scaled) for problem in linked])
    except np.linalg.LinAlgError:  # Windows of which nothing is known.
        return none
    return slope if np.isfinite(slope).all() else none


def _slope(problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray) -> np.ndarray:
    slope, windows = np.zeros(len(scaled)), sum(len(sample.grid) for sample in samples)
    follows = [sample.follows(problem) for sample in samples]
    at = _determinant(problem, samples, scaled, [sample.told.own for sample in samples])
    for place in np.flatnonzero(problem.prior.moves):
        step = STEP * (np.arange(len(scaled)) == place)
        # Starts and pushes follow the coefficients: held where they were, they leave out a part that can turn the sign.
        owns = [follow.moved(sample.told.own, step) for sample, follow in zip(samples, follows, strict=True)]
        slope[place] = _determinant(problem, samples, scaled + step, owns) - at
    return slope / (2 * STEP * max(windows, 1))


def _determinant(
    problem: LogProblem, samples: Sequence[SampledRecord], scaled: np.ndarray, owns: Sequence[RecordUnknowns]
) -> float:
    """Sum the log-determinants of the equations of all record-specific unknowns over the records."""
    motion, whole = problem.at(scaled).of_records, 0.0
    for sample, own in zip(samples, owns, strict=True):
        whole += sample.left(problem, window_equations(problem, motion, scaled, sample.grid, own)).determinant
    return whole
