"""Score tests of faults, one parameter a fault, by the innovations of the filter that learns.

Rao (1948), Proc. Camb. Phil. Soc. 44: the score of an absent fault, projected orthogonally to the fitted numbers, over
the root of its information. One step of Fisher scoring gives the size of the fault. Where records
scatter more than the model predicts, White (1982), Econometrica 50, gives the variance of their common score.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from narrows.logbook.checking.faults import MISREADINGS, Fault, Misreading, faults_of
from narrows.logbook.checking.record_checks import longest_run
from narrows.logbook.filtering.likelihood import DIFFERENCE, RecordLikelihood, RecordScore, score_and_information
from narrows.logbook.filtering.log_problem import LogProblem
from narrows.logbook.filtering.record_grid import RecordGrid, grid_of
from narrows.logbook.filtering.search import FIRST_PASSES, SearchResult
from narrows.logbook.settings import FALSE_ALARM, MOVED, OUTLYING, STUCK_LENGTHS, STUCK_READINGS

# Signals that may be stuck, and their places among the states.
STATES = {"x": 0, "y": 1, "psi": 2, "r": 5}
# Least share of the information on a fault that is independent of the fitted numbers [1].
DETERMINED = 1e-6
# Least number of records from which a variance of scores is estimated.
FEWEST = 4


class FaultTest(NamedTuple):
    """A fault, tested."""

    place: int  # Among the numbers of the tests
    fault: Fault
    record: str
    size: float  # By one step of Fisher scoring
    error: float  # Its standard error
    probability: float  # Probability of such a score at any of the places that were tried, without a fault

    @property
    def significance(self) -> float:
        """Size over its standard error."""
        return self.size / self.error


@dataclass(frozen=True)
class FaultTests:
    """Scores of the unknowns and of all faults, record by record."""

    found: SearchResult
    faults: tuple[tuple[Fault, str], ...]  # Each with its record, or the name of all records together
    parts: tuple[np.ndarray, ...]  # (P + F, P + F) Information of each record
    scores: np.ndarray  # (records, P + F)

    @classmethod
    def of(cls, found: SearchResult, grids: Iterable[RecordGrid], together: str) -> "FaultTests":
        """Score every fault of each record, and those of one kind and signal in all records together."""
        done = [_of_record(found, *pair) for pair in zip(grids, found.records, strict=False)]
        count, faults = len(found.unknowns), [(fault, name) for name, own, *_ in done for fault in own]
        # Those of one kind and signal; a step belongs to one record.
        alike = list(dict.fromkeys(fault[:2] for fault, _ in faults if fault.kind != "step")) if len(done) > 1 else []
        size, first, parts, scores = count + len(faults) + len(alike), count, [], []
        for _, own, score, information in done:
            placed = np.zeros((count + len(own), size))
            placed[:count, :count] = np.eye(count)
            for row, fault in enumerate(own, start=count):
                placed[row, first + row - count] = 1.0
                if fault[:2] in alike:
                    placed[row, count + len(faults) + alike.index(fault[:2])] = 1.0
            parts.append(placed.T @ information @ placed)
            scores.append(placed.T @ score)
            first += len(own)
        pooled = [(next(fault for fault, _ in faults if fault[:2] == key), together) for key in alike]
        return cls(found, (*faults, *pooled), tuple(parts), np.array(scores))

    @cached_property
    def information(self) -> np.ndarray:
        """Information of all records with the prior, (P + F, P + F)."""
        whole, prior = np.sum(self.parts, axis=0), self.found.problem.precision
        whole[: len(prior), : len(prior)] += prior
        return np.asarray(whole)

    def tested(self, known: Sequence[int] = ()) -> list[FaultTest]:
        """Test each fault where known ones are estimated with the unknowns."""
        from scipy.stats import t

        problem, count = self.found.problem, len(self.found.unknowns)
        fitted = np.array([*range(count), *known])
        whole, score = self.information, self.scores.sum(axis=0)
        score[:count] -= problem.precision @ self.found.unknowns
        explained = np.linalg.solve(whole[np.ix_(fitted, fitted)], whole[fitted])
        tests = list[FaultTest]()
        for place, (fault, record) in enumerate(self.faults, start=count):
            left = whole[place, place] - whole[place, fitted] @ explained[:, place]
            if left <= DETERMINED * whole[place, place] or place in known:
                continue
            direction = np.zeros(len(whole))
            direction[fitted], direction[place] = -explained[:, place], 1.0
            size = float(score @ direction / left)
            variance, freedom = self._variance(place, direction, size, left)
            error = np.sqrt(variance) / left
            probability = min(1.0, 2 * float(t.sf(abs(size / error), freedom)) * fault.tries)
            tests.append(FaultTest(place, fault, record, size, float(error), probability))
        return tests

    def mended(self, test: FaultTest) -> tuple[np.ndarray, float]:
        """Return how far the coefficients move where a fault is mended, and how likely they are by their prior."""
        # (p,) in standard errors after the log; the probability of coefficients as far from their prior
        from scipy.stats import chi2

        problem, count = self.found.problem, len(self.found.unknowns)
        kinds = [(*fault[:2], record) for fault, record in self.faults]
        place = count + kinds.index((*test.fault[:2], test.record))  # The test may be of another filter.
        covariance = np.linalg.inv(self.information[:count, :count])
        shift = (-test.size * covariance @ self.information[:count, place])[: problem.count]
        after = self.found.scaled + shift
        probability = float(chi2.sf(after @ problem.prior.precision @ after, problem.count))
        return shift / np.sqrt(np.diag(covariance))[: problem.count], probability

    def _variance(self, place: int, direction: np.ndarray, size: float, left: float) -> tuple[float, float]:
        """Return the variance of a score, and its degrees of freedom."""
        holding = [i for i, part in enumerate(self.parts) if part[place, place] > 0]
        if len(holding) < FEWEST:
            return left, np.inf
        own = [self.scores[i] @ direction - size * (direction @ self.parts[i] @ direction) for i in holding]
        scattered = float(np.sum(np.square(own))) * len(own) / (len(own) - 1)
        return (scattered, len(own) - 1.0) if scattered > left else (left, np.inf)


@np.errstate(all="ignore")
def _of_record(
    found: SearchResult, grid: RecordGrid, record: RecordScore
) -> tuple[str, list[Fault], np.ndarray, np.ndarray]:
    """Return the faults of a record, the scores of unknowns and faults, and their information."""
    problem, path = found.problem, record.path
    likelihood = RecordLikelihood(problem, grid)
    path = path or likelihood.smoothed(found.unknowns, None, FIRST_PASSES)
    if path is None:
        return grid.record.name, [], record.score, record.information
    at, by_value, by_variance = likelihood.slopes(found.unknowns, path)
    model, e, s = problem.model_at(found.unknowns), at.values, at.variances
    faults = list(faults_of(grid, grid.by_signal(e / np.sqrt(s))))
    values, variances = [*by_value], [*by_variance]
    for fault in faults:
        size = DIFFERENCE * fault.scale
        about = RecordLikelihood(problem, fault.mended(size)).linear(found.unknowns, path)
        there = about.innovations(model, path.weights)
        values.append((there.values - e) / size)
        variances.append((there.variances - s) / size)
    score, information = score_and_information(e, s, np.array(values), np.array(variances))
    return grid.record.name, faults, score / problem.correlated, information / problem.correlated


def misreading(problem: LogProblem, grids: Sequence[RecordGrid]) -> tuple[float, Misreading] | None:
    """Return the most likely other way to read the records, and by how much the log-likelihood rises; None where the
    records are likely enough as they are.
    """
    found, recorded = [], [_fitted(problem, grid, grid) for grid in grids]
    here, most = sum(cost for cost, _ in recorded), max(OUTLYING, *(far for _, far in recorded))
    for other in MISREADINGS:
        if all(other.possible(grid.record) for grid in grids):
            again = [grid_of(other.reread(one.record), one.step, problem.motion.positions) for one in grids]
            read = sum(
                len(one.readings[name].values) for one in again for name in other.signals if name in one.readings
            )
            fits = [_fitted(problem, *pair) for pair in zip(again, grids, strict=True)]
            there = sum(cost for cost, _ in fits) + 2 * other.shrunk * read
            found.append((np.inf if max(far for _, far in fits) > most else there, other))
    cost, other = min(found, key=lambda pair: pair[0])
    return (here - cost, other) if here - cost > 2 * np.log(len(found) / FALSE_ALARM) and np.isfinite(cost) else None


def _fitted(problem: LogProblem, grid: RecordGrid, recorded: RecordGrid) -> tuple[float, float]:
    """Return minus twice the log-likelihood by the model before the log, and the largest share of outliers."""
    likelihood, unknowns = RecordLikelihood(problem, grid), np.zeros(len(problem.precision))
    for place, one in enumerate(problem.model.estimated, start=problem.count):
        if one.of == "noise" and (name := one.names[0]) in recorded.record:
            scatter = _scatter(recorded.record[name].values) / problem.model.noise[name]
            unknowns[place] = np.log(max(scatter, 1.0))
    path = likelihood.smoothed(unknowns, None, FIRST_PASSES)
    if path is None:
        return np.inf, 1.0
    far = max(float(np.mean(own < 1.0)) for own in grid.by_signal(path.weights).values() if len(own))
    return likelihood.cost(unknowns, path), far


def _scatter(values: np.ndarray) -> float:
    """Return the noise of a signal by its second differences."""
    return float(1.4826 * np.median(np.abs(np.diff(values, 2))) / np.sqrt(6.0)) if len(values) > 2 else 0.0


def stuck(problem: LogProblem, grid: RecordGrid) -> Iterator[tuple[str, float, float]]:
    """Yield signals that repeat one value for long while the ship moves by all others: from when to when [s]."""
    lasting = STUCK_LENGTHS * problem.scales[0] / problem.scales[3]
    for name, column in STATES.items():
        if name not in grid.readings:
            continue
        start, stop = longest_run(grid.record[name].values)
        begin, end = grid.record[name].t[[start, stop]].tolist()
        if stop - start < STUCK_READINGS or end - begin < lasting:
            continue
        read = grid.readings[name]
        t = grid.times_of(read)
        kept = (t < begin) | (t > end)
        without = {own: getattr(read, own)[kept] for own in ("values", "step", "share", "counted")}
        likelihood = RecordLikelihood(
            problem, replace(grid, readings={**grid.readings, name: replace(read, **without)})
        )
        path = likelihood.smoothed(np.zeros(len(problem.precision)), None, FIRST_PASSES)
        during = (grid.times[:-1] > begin) & (grid.times[:-1] < end)
        if path and during.any() and np.ptp(path.states[during, column]) > MOVED * problem.model.noise[name]:
            yield name, begin, end
