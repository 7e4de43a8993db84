"""Faults of a ship's sensors, each with one number, and their score tests by the innovations of the filter that learns.

Rao (1948), Proc. Camb. Phil. Soc. 44: the score of an absent fault, projected orthogonally to the fitted numbers, over
the root of its information. One step of Fisher scoring gives the size of the fault. Where records
scatter more than the model predicts, White (1982), Econometrica 50, gives the variance of their common score.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import special

from narrows.logbook.filtering.likelihood import (
    DIFFERENCE,
    FIRST_PASSES,
    RecordLikelihood,
    RecordScore,
    SearchResult,
    score_and_information,
)
from narrows.logbook.filtering.log_problem import LogProblem
from narrows.logbook.filtering.record_grid import RUDDER, STATES, Readings, RecordGrid, grid_of
from narrows.logbook.settings import FALSE_ALARM, MOST_ANGLE, MOVED, OUTLYING, STUCK_LENGTHS, STUCK_READINGS
from narrows.logbook.ship_log import SIGNALS, TURNING, ShipRecord, Signal
from narrows.quantities.names import DEGREE, KNOT

POSITION = ("x", "y")
JUMPING = ("x", "y", "psi")  # signals that a reset moves


# Sentence, with the signal, the size with its error, and the time; remedy
FAULTS = {
    "zero": ("{name} reads {size} {unit} too much", "correct its zero"),
    "gain": ("{name} truly is {size} times what is recorded", "check its unit, its sign and its calibration"),
    "delay": ("{name} is recorded {size} s late", "take the delay out: [late] {column} = {value:.2g}"),
    "antenna": (
        "the position is that of a point {size} m forward of where the antenna is said to be",
        "give the antenna's place, forward and to starboard of midship",
    ),
    "step": (
        "{name} jumps by {size} {unit} at t = {at:.6g} s",
        "a receiver, a compass or the clock was reset: begin another record there",
    ),
}


class Fault(NamedTuple):
    kind: str  # One of FAULTS
    signal: str
    grid: RecordGrid
    scale: float = 1.0  # A small size
    tries: int = 1  # Places among which this one was chosen
    at: float = -np.inf  # Time of a step [s]

    def mended(self, size: float) -> RecordGrid:
        kind, name, grid = self.kind, self.signal, self.grid
        if kind == "antenna":
            ahead, starboard = grid.record.antenna
            return replace(grid, record=replace(grid.record, antenna=(ahead + size, starboard)))
        if name == RUDDER:
            angle = grid.positions[RUDDER]
            change = {"zero": -np.ones(len(angle)), "gain": angle, "delay": np.gradient(angle, grid.times)}[kind]
            return replace(grid, positions={**grid.positions, RUDDER: angle + size * change})
        readings = dict(grid.readings)
        for own in POSITION if name == "x" and kind == "delay" else (name,):
            read = readings[own]
            if kind == "gain":
                readings[own] = read._replace(gain=1.0 - size)
            elif kind == "delay":
                readings[own] = read._replace(share=read.share - size / grid.step)
            else:
                readings[own] = read._replace(values=read.values - size * (grid.times_of(read) >= self.at))
        return replace(grid, readings=readings)


def faults_of(grid: RecordGrid, normalised: dict[str, np.ndarray]) -> Iterator[Fault]:
    """Yield the faults that a record may have; a step where the normalised innovations of a signal are largest."""
    for name, read in grid.readings.items():
        small = {"rad": DEGREE, "rad/s": 0.01 * DEGREE}.get(SIGNALS[name].unit, 0.1)
        if name != "x":  # Nothing fixes where x begins.
            yield Fault("zero", name, grid, small)
            if name not in (*TURNING, *POSITION):  # Neither angles that go round nor places by satellite have a gain.
                yield Fault("gain", name, grid)
        if name not in POSITION:
            yield Fault("delay", name, grid)
        if name in JUMPING and len(read.values) > 2:
            place = 1 + int(np.argmax(np.abs(normalised[name][1:])))
            yield Fault("step", name, grid, small, len(read.values), float(grid.times_of(read)[place]))
    if grid.readings.keys() >= set(POSITION):
        yield from (Fault(kind, "x", grid) for kind in ("delay", "antenna"))
    if RUDDER in grid.positions:
        yield from (Fault(kind, RUDDER, grid, scale) for kind, scale in (("zero", DEGREE), ("gain", 1), ("delay", 1)))


class Misreading(NamedTuple):
    """Another way to read signals: another sign, unit or axis."""

    signals: tuple[str, ...]
    remedy: str
    factor: float = 1.0  # By which they are multiplied
    turned: complex = 0.0  # By so many times the heading velocities over ground are turned
    least: float = 0.0  # Size that some recorded value must reach

    @property
    def sentence(self) -> str:
        if self.turned:
            return "u_ground and v_ground are along other axes"
        times = "counts the other way" if self.factor == -1 else f"is {1 / self.factor:.4g} times what it should be"
        return f"{' and '.join(self.signals)} {times}"

    def possible(self, record: ShipRecord) -> bool:
        return all(
            name in record and np.abs(record[name].values).max(initial=0.0) >= self.least for name in self.signals
        )

    def reread(self, record: ShipRecord) -> ShipRecord:
        if not self.turned:
            scaled = {name: Signal(record[name].t, self.factor * record[name].values) for name in self.signals}
            return record.with_signals(**scaled)
        t = record["u_ground"].t
        velocity = record["u_ground"].values + 1j * record["v_ground"].at(t)
        velocity = velocity * np.exp(self.turned * record["psi"].at(t))
        t, velocity = t[np.isfinite(velocity)], velocity[np.isfinite(velocity)]
        return record.with_signals(u_ground=Signal(t, velocity.real), v_ground=Signal(t, velocity.imag))


VELOCITIES = ("u_ground", "v_ground", "psi")
MISREADINGS = (
    *(Misreading((name,), f'turn its sign ([positive] {name} = "port")', -1.0)
      for name in (RUDDER, "psi", "r", "y", "v", "v_ground", "course")),
    # Read as degrees a rudder nearly vanishes; where the model's rudder is too strong, that alone is more likely.
    Misreading((RUDDER,), "it looks like degrees: head it 'rudder [deg]'", DEGREE, least=MOST_ANGLE),
    *(Misreading((name,), f"it looks like degrees: head it '{name} [deg]'", DEGREE) for name in ("psi", "course")),
    Misreading((RUDDER,), "radians were read as degrees: give its unit", 1 / DEGREE),
    Misreading(("r",), "r looks like degrees a second: give its unit", DEGREE),
    Misreading(("r",), "r looks like degrees a minute: give its unit", DEGREE / 60),
    Misreading(("psi", "r"), "psi looks like degrees and r like degrees a second: give their units", DEGREE),
    *(Misreading(names, "knots were read as metres a second: give the unit", KNOT)
      for names in (("u",), ("speed_over_ground",), ("u_ground", "v_ground"))),
    *(Misreading(("revolutions",), f"they look like turns a {unit}: give their unit", factor)
      for factor, unit in ((1 / 60, "minute"), (60.0, "second"))),
    Misreading(VELOCITIES, "they are along x and y, not along the ship: call them x_rate and y_rate", turned=-1j),
    Misreading(VELOCITIES, "they are along the ship already: call them u_ground and v_ground", turned=1j),
)  # fmt: skip


DETERMINED = 1e-6  # Least share of the information on a fault that is independent of the fitted numbers [1]
FEWEST = 4  # Least number of records from which a variance of scores is estimated


class FaultTest(NamedTuple):
    place: int  # Among the numbers of the tests
    fault: Fault
    record: str
    size: float  # By one step of Fisher scoring
    error: float  # Its standard error
    probability: float  # Probability of such a score at any of the places that were tried, without a fault

    @property
    def significance(self) -> float:
        return self.size / self.error


@dataclass(frozen=True)
class FaultTests:
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
            placed = np.eye(size)[[*range(count), *range(first, first + len(own))]]
            for row, fault in enumerate(own, start=count):
                if fault[:2] in alike:
                    placed[row, count + len(faults) + alike.index(fault[:2])] = 1.0
            parts.append(placed.T @ information @ placed)
            scores.append(placed.T @ score)
            first += len(own)
        pooled = [(next(fault for fault, _ in faults if fault[:2] == key), together) for key in alike]
        return cls(found, (*faults, *pooled), tuple(parts), np.array(scores))

    @cached_property
    def information(self) -> np.ndarray:  # (P + F, P + F)
        whole, prior = np.sum(self.parts, axis=0), self.found.problem.precision
        whole[: len(prior), : len(prior)] += prior
        return np.asarray(whole)

    def tested(self, known: Sequence[int] = ()) -> list[FaultTest]:
        """Test each fault where known ones are estimated with the unknowns."""
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
            probability = min(1.0, 2 * float(special.stdtr(freedom, -abs(size / error))) * fault.tries)
            tests.append(FaultTest(place, fault, record, size, float(error), probability))
        return tests

    def mended(self, test: FaultTest) -> tuple[np.ndarray, float]:
        """Return how far the coefficients move where a fault is mended, and how likely they are by their prior."""
        # (p,) in standard errors after the log; the probability of coefficients as far from their prior
        problem, count = self.found.problem, len(self.found.unknowns)
        kinds = [(*fault[:2], record) for fault, record in self.faults]
        place = count + kinds.index((*test.fault[:2], test.record))  # The test may be of another filter.
        covariance = np.linalg.inv(self.information[:count, :count])
        shift = (-test.size * covariance @ self.information[:count, place])[: problem.count]
        after = self.found.scaled + shift
        probability = float(special.chdtrc(problem.count, after @ problem.prior.precision @ after))
        return shift / np.sqrt(np.diag(covariance))[: problem.count], probability

    def _variance(self, place: int, direction: np.ndarray, size: float, left: float) -> tuple[float, float]:
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
    at, by_unknowns = likelihood.slopes(found.unknowns, path)
    (e, s), model, slopes = at, problem.model_at(found.unknowns), [*by_unknowns]
    faults = list(faults_of(grid, grid.by_signal(e / np.sqrt(s))))
    for fault in faults:
        size = DIFFERENCE * fault.scale
        about = RecordLikelihood(problem, fault.mended(size)).linear(found.unknowns, path)
        slopes.append((about.filtered(model, path.weights)[0] - at) / size)
    score, information = score_and_information(e, s, np.array(slopes))
    return grid.record.name, faults, score / problem.correlated, information / problem.correlated


def misreading(problem: LogProblem, grids: Sequence[RecordGrid]) -> tuple[float, Misreading] | None:
    """Return the rise of the log-likelihood by the best other way to read the records; None where it is not enough."""
    found, recorded = [], [_fitted(problem, grid, grid) for grid in grids]
    here, most = sum(cost for cost, _ in recorded), max(OUTLYING, *(far for _, far in recorded))
    for other in MISREADINGS:
        if all(other.possible(grid.record) for grid in grids):
            again = [grid_of(other.reread(one.record), one.step, problem.motion.positions) for one in grids]
            read = sum(
                len(one.readings[name].values) for one in again for name in other.signals if name in one.readings
            )
            fits = [_fitted(problem, *pair) for pair in zip(again, grids, strict=True)]
            # The Jacobian of the likelihood: readings become smaller.
            there = sum(cost for cost, _ in fits) - 2 * float(np.log(abs(other.factor))) * read
            found.append((np.inf if max(far for _, far in fits) > most else there, other))
    cost, other = min(found, key=lambda pair: pair[0])
    return (here - cost, other) if here - cost > 2 * np.log(len(found) / FALSE_ALARM) and np.isfinite(cost) else None


def _fitted(problem: LogProblem, grid: RecordGrid, recorded: RecordGrid) -> tuple[float, float]:
    """Return minus twice the log-likelihood by the model before the log, and the largest share of outliers."""
    likelihood, unknowns = RecordLikelihood(problem, grid), np.zeros(len(problem.precision))
    for place, one in enumerate(problem.model.estimated, start=problem.count):
        if one.of == "noise" and (name := one.names[0]) in recorded.record:
            values = recorded.record[name].values
            scatter = 1.4826 * np.median(np.abs(np.diff(values, 2))) / np.sqrt(6.0) if len(values) > 2 else 0.0
            unknowns[place] = np.log(max(scatter / problem.model.noise[name], 1.0))
    path = likelihood.smoothed(unknowns, None, FIRST_PASSES)
    if path is None:
        return np.inf, 1.0
    far = max(float(np.mean(own < 1.0)) for own in grid.by_signal(path.weights).values() if len(own))
    return likelihood.cost(unknowns, path), far


def stuck(problem: LogProblem, grid: RecordGrid) -> Iterator[tuple[str, float, float]]:
    """Yield signals that repeat one value for long while the ship moves by all others: from when to when [s]."""
    lasting = STUCK_LENGTHS * problem.scales[0] / problem.scales[3]
    for name in ("x", "y", "psi", "r"):
        if name not in grid.readings:
            continue
        ends = longest_run(grid.record[name].values)
        begin, end = grid.record[name].t[ends].tolist()
        if np.diff(ends) < STUCK_READINGS or end - begin < lasting:
            continue
        read = grid.readings[name]
        t = grid.times_of(read)
        kept = (t < begin) | (t > end)
        without = Readings(*(column[kept] for column in read[:4]))
        likelihood = RecordLikelihood(problem, replace(grid, readings={**grid.readings, name: without}))
        path = likelihood.smoothed(np.zeros(len(problem.precision)), None, FIRST_PASSES)
        during = (grid.times[:-1] > begin) & (grid.times[:-1] < end)
        moved = np.ptp(path.states[during, STATES.index(name)]) if path and during.any() else 0.0
        if moved > MOVED * problem.model.noise[name]:
            yield name, begin, end


def longest_run(values: np.ndarray) -> list[int]:
    edges = np.flatnonzero(np.diff(values, prepend=np.nan, append=np.nan) != 0)
    longest = int(np.argmax(np.diff(edges)))
    return [int(edges[longest]), int(edges[longest + 1]) - 1]
