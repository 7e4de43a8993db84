"""The likelihood of a record by the innovations of a Kalman filter, its score and information, and its maximum.

A record is a linear state-space model about a reference path, with the exact tangents of the engine. Schweppe (1965),
IEEE Trans. Inf. Theory 11, for the likelihood; Gupta and Mehra (1974), IEEE Trans. Autom. Control 19, for the
information by the slopes of innovations and of their variances. Scores and information of records add. The search over
all records is Fisher scoring with Levenberg's damping, within the bounds of the coefficients.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from narrows.base.progress import bar, is_shown
from narrows.codegen.cache import compiled_loops
from narrows.identification.least_squares import solve
from narrows.logbook.filtering import kalman_loops
from narrows.logbook.filtering.log_problem import CURRENT, INPUTS, PUSHES, LogProblem, StochasticModel, Unknowns
from narrows.logbook.filtering.record_grid import CURRENTS, OFFSET, RUDDER, RecordGrid, first_guess, predicted_signal

SPEED_WALK = 2e-3  # Random walk of a held speed in a second, over itself
# Standard deviation of a start about the first guess, over lengths, radians and speeds of the ship.
START = np.array([0.1, 0.1, 0.2, 0.2, 0.2, 0.3])
# A residual over its noise beyond which a reading counts less.
OUTLIER = 4.0
DIFFERENCE = 1e-4  # standard deviations before records, for slopes
LAGS = 400  # readings over which innovations may be correlated
UNCORRELATED = 0.05  # correlation of innovations below which they count as independent


class RecordPath(NamedTuple):
    states: np.ndarray  # (n, 6) x, y, psi, u, v, r at the start of each step
    processes: np.ndarray  # (n, m)
    weights: np.ndarray  # (N,) Weights of readings there


@np.errstate(all="ignore")
def deviance(innovations: np.ndarray) -> float:
    """Return minus twice the logarithm of the likelihood, to a constant, of innovations and their variances (2, N)."""
    e, s = innovations
    cost = float(np.sum(e**2 / s + np.log(s)))
    return cost if np.isfinite(cost) else np.inf


@dataclass(frozen=True)
class LinearRecord:
    grid: RecordGrid
    problem: LogProblem
    slopes: np.ndarray  # (n, 6, 6 + m)
    misses: np.ndarray  # (n, 6) End of a step of the reference, less the begin of the next
    rows: np.ndarray  # (N, 6 + m) Slopes of readings
    residual: np.ndarray  # (N,) Readings less those of the reference with no process
    left: np.ndarray  # (N,) Readings less those of the reference

    def variances(self, model: StochasticModel) -> np.ndarray:
        parts = [model.noise[name] ** 2 / read.counted for name, read in self.grid.readings.items()]
        return np.asarray(np.concatenate(parts)[self.grid.order])

    @np.errstate(all="ignore")
    def weights(self, model: StochasticModel) -> np.ndarray:
        """Weigh readings by what the reference leaves of them, (N,)."""
        # A reading beyond the limit counts as one at the limit, so that no spike sets the noise that is estimated.
        return np.asarray((OUTLIER / np.maximum(np.abs(self.left) / np.sqrt(self.variances(model)), OUTLIER)) ** 2)

    def filtered(
        self, model: StochasticModel, weights: np.ndarray, smooth: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return innovations with their variances (2, N), and if asked smoothed states and processes, (n, 6 + m)."""
        (count, size), step, scale = self.rows.shape, self.grid.step, self.problem.scales
        room, first, loops = len(self.slopes) * smooth, self.grid.first_readings, compiled_loops(kalman_loops)
        kept, stationary = model.kept(step), model.covariance()
        regular, started = (self.problem.walk * scale) ** 2, (START * scale) ** 2
        regular[3] += (SPEED_WALK * scale[3]) ** 2 * step * (self.problem.motion.integrator.ship.surge == "held")
        found, gains = np.empty((2, count)), np.empty((count, size))
        means, covariances = np.empty((room, size)), np.empty((room, size, size))
        start = np.diag(np.append(started, np.zeros(size - 6)))
        start[6:, 6:] = stationary
        walk = np.where(self.grid.whole[:, None], regular, started)  # Loose where the motion is not known
        loops.filter_readings(
            start, self.slopes, self.misses, kept, stationary * (1 - np.outer(kept, kept)), walk, first, self.rows,
            self.residual, self.variances(model) / weights, *found, gains, means, covariances,
        )  # fmt: skip
        if smooth:
            loops.smooth(self.slopes, kept, first, self.rows, *found, gains, means, covariances)
        return found, means


@dataclass(frozen=True)
class RecordScore:
    score: np.ndarray  # (P,) Slope of the log-likelihood
    information: np.ndarray  # (P, P)
    cost: float  # Minus twice the log-likelihood
    autocovariance: np.ndarray  # (LAGS,) Products of normalised innovations of a signal, so many readings apart
    ranges: np.ndarray  # (2, 2) Least distance off the middle and speed, and largest
    outliers: Mapping[str, tuple[int, int]]  # Readings of each signal that count less, and all of them
    path: RecordPath | None = None  # None in a long log


@dataclass(frozen=True)
class RecordLikelihood:
    """One record at sets of unknowns: scaled coefficients, then the estimated numbers of the stochastic model."""

    problem: LogProblem
    grid: RecordGrid

    @np.errstate(all="ignore")  # A model that cannot follow the record may run away.
    def linear(self, unknowns: np.ndarray, path: RecordPath) -> LinearRecord:
        grid, problem = self.grid, self.problem
        motion, inertia = problem.at(unknowns[: problem.count])
        model = problem.model_at(unknowns)
        names = [one.adds_to for one in model.processes]
        sums = {name: np.zeros(len(grid)) for name in (*INPUTS, *names)}
        for place, name in enumerate(names):
            sums[name] = sums[name] + path.processes[:, place]
        pushes = np.stack([sums[name] for name in PUSHES], axis=1) * inertia
        offsets = {name: sums[OFFSET(name)] for name in motion.positions if OFFSET(name) in sums}
        states, along = motion.sailed(
            path.states, pushes, np.arange(len(grid) + 1), grid.times, grid.positions, offsets,
            float(sums[CURRENTS[0]][0]),
        )  # fmt: skip
        ends, slopes = states[1::2], motion.slopes(along[1::2], np.diff(grid.times), inertia, names)
        if CURRENT not in motion.directions:
            ends[:, :2] += np.stack([sums[name] for name in CURRENTS], axis=1) * np.diff(grid.times)[:, None]
        driven = np.einsum("nij,nj->ni", slopes[:, :, 6:], path.processes)
        misses = ends - np.append(path.states[1:], ends[-1:], axis=0) - driven
        rows, residual, left, rudder = [], [], [], grid.positions.get(RUDDER, np.zeros(len(grid)))
        for name, read in grid.readings.items():
            share, at = read.share[:, None], read.step
            there = (1 - share) * path.states[at] + share * ends[at]
            errors = {key: value[at] for key, value in sums.items()}
            seen = predicted_signal(name, there, errors, grid.record.antenna, rudder[at])
            rows.append(read.gain * seen.rows(read, slopes, names))
            left.append(read.values - read.gain * seen.value)
            residual.append(left[-1] + np.einsum("ni,ni->n", rows[-1][:, 6:], path.processes[at]))
        ordered = (np.concatenate(parts)[grid.order] for parts in (rows, residual, left))
        return LinearRecord(grid, problem, slopes, misses, *ordered)

    @np.errstate(all="ignore")  # A model that cannot follow the record may run away.
    def smoothed(self, unknowns: np.ndarray, path: RecordPath | None, passes: int) -> RecordPath | None:
        """Smooth a path, from the readings alone if there is none; None where the motion diverges."""
        model = self.problem.model_at(unknowns)
        if path is None:
            guess = first_guess(self.grid, self.problem.motion.choices.get("waterway"))
            path = RecordPath(guess, np.zeros((len(guess), len(model.processes))), np.empty(0))
        about = self.linear(unknowns, path)
        for _ in range(passes):
            smooth = about.filtered(model, about.weights(model), smooth=True)[1]
            if not np.isfinite(smooth).all():
                return None
            path = RecordPath(path.states + smooth[:, :6], smooth[:, 6:], path.weights)
            about = self.linear(unknowns, path)
        return path._replace(weights=about.weights(model))

    @np.errstate(all="ignore")  # A model that cannot follow the record may run away.
    def cost(self, unknowns: np.ndarray, path: RecordPath) -> float:
        model = self.problem.model_at(unknowns)
        return deviance(self.linear(unknowns, path).filtered(model, path.weights)[0]) / self.problem.correlated

    @np.errstate(all="ignore")
    def slopes(self, unknowns: np.ndarray, path: RecordPath) -> tuple[np.ndarray, np.ndarray]:
        """Return innovations with their variances (2, N), and their slopes (P, 2, N) by differences, about a path."""
        problem = self.problem
        about = self.linear(unknowns, path)
        at = about.filtered(problem.model_at(unknowns), path.weights)[0]
        slopes = np.zeros((len(unknowns), *at.shape))
        for place in range(len(unknowns)):
            moved = unknowns + DIFFERENCE * (np.arange(len(unknowns)) == place)
            there = self.linear(moved, path) if place < problem.count else about
            slopes[place] = (there.filtered(problem.model_at(moved), path.weights)[0] - at) / DIFFERENCE
        return at, slopes

    @np.errstate(all="ignore")
    def scored(self, unknowns: np.ndarray, path: RecordPath) -> RecordScore:
        problem = self.problem
        at, slopes = self.slopes(unknowns, path)
        e, s = at[0], np.abs(at[1])  # The cost is infinite where the filter diverges.
        score, information = score_and_information(e, s, slopes)
        share, met, autocovariance = 1 / problem.correlated, np.abs(path.states[:, [1, 3]]), np.zeros(LAGS)
        for part in self.grid.by_signal(np.clip(e / np.sqrt(s), -OUTLIER, OUTLIER)).values():
            for lag in range(min(LAGS, len(part))):
                autocovariance[lag] += part[lag:] @ part[: len(part) - lag]
        return RecordScore(
            share * score, share * information, share * deviance(at), autocovariance,
            np.stack([met.min(axis=0), met.max(axis=0)]),
            {name: (int((own < 1.0).sum()), len(own)) for name, own in self.grid.by_signal(path.weights).items()}, path,
        )  # fmt: skip


def readings_for_one(autocovariance: np.ndarray) -> float:
    # Bayley and Hammersley (1946), The "effective" number of independent observations in an autocorrelated time series.
    correlation = autocovariance / max(autocovariance[0], 1e-300)
    below = np.flatnonzero(correlation < UNCORRELATED)
    return 1.0 + 2.0 * float(correlation[1 : below[0] if below.size else None].sum())


def score_and_information(e: np.ndarray, s: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the slope of the log-likelihood (P,) and the information (P, P) by slopes (P, 2, N)."""
    by_value, by_variance = slopes[:, 0], slopes[:, 1]
    score = -by_value @ (e / s) - 0.5 * by_variance @ (1 / s - (e / s) ** 2)
    return score, (by_value / s) @ by_value.T + 0.5 * (by_variance / s**2) @ by_variance.T


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
