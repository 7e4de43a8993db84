"""The likelihood of a record by the innovations of a Kalman filter, its score and information.

Schweppe (1965), IEEE Trans. Inf. Theory 11, for the likelihood; Gupta and Mehra (1974), IEEE Trans. Autom. Control 19,
for the information by the slopes of innovations and of their variances.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from narrows.logbook.filtering.linear_record import Innovations, LinearRecord, Reference, linear_record, weights_of
from narrows.logbook.filtering.log_problem import LogProblem
from narrows.logbook.filtering.record_grid import RecordGrid, first_guess

DIFFERENCE = 1e-4  # standard deviations before records, for slopes
LAGS = 400  # readings over which innovations may be correlated
UNCORRELATED = 0.05  # correlation of innovations below which they count as independent


@dataclass(frozen=True)
class RecordPath:
    """About what a record is linear, and how readings are weighed there."""

    reference: Reference
    weights: np.ndarray  # (N,) Weights of readings


@dataclass(frozen=True)
class RecordScore:
    """Contribution of one record."""

    score: np.ndarray  # (P,) Slope of the log-likelihood
    information: np.ndarray  # (P, P)
    cost: float  # Minus twice the log-likelihood
    autocovariance: np.ndarray  # (LAGS,) Products of normalised innovations of a signal, so many readings apart
    ranges: np.ndarray  # (2, 2) Least distance off the middle and speed, and largest
    outliers: Mapping[str, tuple[int, int]]  # Readings of each signal that count less, and all of them
    path: RecordPath | None = None  # None in a long log


class InnovationSlopes(NamedTuple):
    """Innovations of a record, and their slopes by the unknowns."""

    about: LinearRecord
    at: Innovations
    by_value: np.ndarray  # (P, N) Slopes of the innovations
    by_variance: np.ndarray  # (P, N) Slopes of their variances


@dataclass(frozen=True)
class RecordLikelihood:
    """One record at sets of unknowns: scaled coefficients, then the estimated numbers of the stochastic model."""

    problem: LogProblem
    grid: RecordGrid

    def linear(self, unknowns: np.ndarray, reference: Reference) -> LinearRecord:
        """Return the record about a reference path."""
        problem, count = self.problem, self.problem.count
        motion, inertia = problem.at(unknowns[:count])
        model = problem.model.at(unknowns[count:])
        return linear_record(self.grid, problem.scales, motion.of_records, inertia, model, reference)

    @np.errstate(all="ignore")  # A model that cannot follow the record may run away.
    def smoothed(self, unknowns: np.ndarray, reference: Reference | None, passes: int) -> RecordPath | None:
        """Smooth the reference path, from the readings alone if there is none; None where the motion diverges."""
        model = self.problem.model.at(unknowns[self.problem.count :])
        if reference is None:
            zeros = np.zeros((len(self.grid), len(model.processes)))
            reference = Reference(first_guess(self.grid, self.problem.motion.choices.get("waterway")), zeros)
        for _ in range(passes):
            about = self.linear(unknowns, reference)
            smooth = about.smoothed(model, weights_of(about, model))
            if not np.isfinite(smooth).all():
                return None
            reference = Reference(reference.states + smooth[:, :6], smooth[:, 6:])
        return RecordPath(reference, weights_of(self.linear(unknowns, reference), model))

    @np.errstate(all="ignore")  # A model that cannot follow the record may run away.
    def cost(self, unknowns: np.ndarray, path: RecordPath) -> float:
        """Return minus twice the log-likelihood about a path."""
        model = self.problem.model.at(unknowns[self.problem.count :])
        about = self.linear(unknowns, path.reference).innovations(model, path.weights)
        return about.cost / self.problem.correlated

    @np.errstate(all="ignore")
    def slopes(self, unknowns: np.ndarray, path: RecordPath) -> "InnovationSlopes":
        """Return innovations and their slopes by differences about a path."""
        problem, count = self.problem, self.problem.count
        about = self.linear(unknowns, path.reference)
        at = about.innovations(problem.model.at(unknowns[count:]), path.weights)
        by_value, by_variance = np.zeros((2, len(unknowns), len(at.values)))
        for place in range(len(unknowns)):
            moved = unknowns + DIFFERENCE * (np.arange(len(unknowns)) == place)
            there = self.linear(moved, path.reference) if place < count else about
            found = there.innovations(problem.model.at(moved[count:]), path.weights)
            by_value[place] = (found.values - at.values) / DIFFERENCE
            by_variance[place] = (found.variances - at.variances) / DIFFERENCE
        return InnovationSlopes(about, at, by_value, by_variance)

    @np.errstate(all="ignore")
    def scored(self, unknowns: np.ndarray, path: RecordPath) -> RecordScore:
        """Return score and information about a path."""
        problem = self.problem
        _, at, by_value, by_variance = self.slopes(unknowns, path)
        e, s = at.values, np.abs(at.variances)  # The cost is infinite where the filter diverges.
        score = -by_value @ (e / s) - 0.5 * by_variance @ (1 / s - (e / s) ** 2)
        information = (by_value / s) @ by_value.T + 0.5 * (by_variance / s**2) @ by_variance.T
        share = 1 / problem.correlated
        met = np.abs(path.reference.states[:, [1, 3]])
        return RecordScore(
            share * score, share * information, share * at.cost, self._autocovariance(e / np.sqrt(s)),
            np.stack([met.min(axis=0), met.max(axis=0)]), self._outliers(path.weights), path,
        )  # fmt: skip

    def _outliers(self, weights: np.ndarray) -> dict[str, tuple[int, int]]:
        return {name: (int((own < 1.0).sum()), len(own)) for name, own in self.grid.by_signal(weights).items()}

    def _autocovariance(self, normalised: np.ndarray) -> np.ndarray:
        """Products of normalised innovations so many readings apart, over the signals."""
        found = np.zeros(LAGS)
        for part in self.grid.by_signal(np.clip(normalised, -4.0, 4.0)).values():
            for lag in range(min(LAGS, len(part))):
                found[lag] += part[lag:] @ part[: len(part) - lag]
        return found


def readings_for_one(autocovariance: np.ndarray) -> float:
    """Return how many readings there are for each independent one [1]."""
    # Bayley and Hammersley (1946), The "effective" number of independent observations in an autocorrelated time series.
    correlation = autocovariance / max(autocovariance[0], 1e-300)
    below = np.flatnonzero(correlation < UNCORRELATED)
    return 1.0 + 2.0 * float(correlation[1 : below[0] if below.size else None].sum())
