"""Distinct motions of tests, and the rows of each for forces that are fitted together: a few with the same sums."""

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from narrows.identification.least_squares import Problem
from narrows.identification.normal_equations import ONE, NormalEquations
from narrows.model.term import Term

# Tolerance of each feature, or of a fifth of its largest value if more: within it two tests are one motion.
SAME_MOTION = 0.03
# Standard deviations within a test under which nothing oscillates: over speed, in radians, over the ship's length.
LEAST_MOTION = {"v": 0.015, "sin_psi": 0.01, "y": 0.01}
FLOOR = 0.2
# A value at a tolerance is within it, whatever the rounding of sums.
EDGE = 1 + 1e-6
# Share of the largest offset of the table: a mean offset beyond it lies on a side of the canal.
SIDE = 0.15
Moments = defaultdict[str, np.ndarray]


@dataclass(frozen=True)
class DistinctMotions:
    sums: np.ndarray  # (motions, m, m) Sums of products over all tests of a motion
    members: tuple[tuple[str, ...], ...]  # The tests of each motion: the first one and its repeats
    # (motions,) Mean ``speed`` [m/s], ``period`` [s], 0 of steady motions, ``depth`` [m], ``side`` (-1, 0 or 1) and
    # ``reach``, the offset from the centreline that a motion comes to, about [m]
    features: Mapping[str, np.ndarray]
    steady: np.ndarray  # (motions,) Nothing oscillates

    def __len__(self) -> int:
        return len(self.members)

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each motion: its first test, and its number of repeats."""
        repeats = ("", " and 1 repeat", *(f" and {n} repeats" for n in range(2, max(map(len, self.members)))))
        return tuple(first + repeats[len(more)] for first, *more in self.members)

    @cached_property
    def without(self) -> np.ndarray:
        """Sums over all but each motion, (motions, m, m): added up and not taken away, so that nothing cancels."""
        sums = np.zeros_like(self.sums)
        sums[1:] += np.cumsum(self.sums[:-1], axis=0)
        sums[:-1] += np.cumsum(self.sums[:0:-1], axis=0)[::-1]
        return sums

    @property
    def by_speed(self) -> list[np.ndarray]:
        return grouped(self.features["speed"])

    @property
    def sentence(self) -> str:
        tests, own = sum(map(len, self.members)), len(self)
        if tests == own:
            return f"Errors are those of {tests} runs, each a motion of its own."
        return f"Errors are those of {own} distinct motions: {tests - own} of the {tests} tests are repeats."


def distinct_motions(equations: NormalEquations, repeats: bool = True) -> DistinctMotions:
    """Group tests by their motion; without ``repeats`` each test is a motion."""
    moved, length, (mean, std) = equations.moved, equations.length, _moments(equations)
    speed = np.maximum(np.hypot(mean["u"], mean["v"]), 1e-9)
    sizes: dict[str, np.ndarray | float] = {"v": speed, "sin_psi": 1.0, "y": length}
    steady = np.all([std[name] < share * sizes[name] for name, share in LEAST_MOTION.items()], axis=0)
    # The period by v'' = -w2 v of the largest oscillation, 0 without one [s].
    sways = std["v"] / speed > std["r"] * length / speed
    ratio = np.where(sways, std["v"], std["r"]) / np.maximum(np.where(sways, std["vdot"], std["rdot"]), 1e-12)
    reach = np.abs(mean["y"]) + np.sqrt(2) * std["y"]
    done = {
        "speed": speed,
        "period": np.where(steady, 0.0, 2 * np.pi * ratio),
        "depth": mean["depth"] if "depth" in moved else np.ones(len(speed)),
        "side": np.where(np.abs(mean["y"]) > SIDE * max(reach.max(), 1e-9), np.sign(mean["y"]), 0.0),
        "reach": reach,
    }
    # Mean and amplitude of everything that moved, and the size that each is seen against.
    fast = float(speed.max())
    natural = {"u": fast, "v": fast, "r": fast / length, "y": 0.1 * length, "sin_psi": 1.0, "rudder": 1.0}
    natural |= {"udot": fast**2 / length, "vdot": fast**2 / length, "rdot": fast**2 / length**2}
    columns, scales = [done["period"]], [float(done["period"].max())]
    for name in moved:
        for values in (mean[name], np.sqrt(2) * std[name])[: 1 if name in ("udot", "vdot", "rdot") else 2]:
            columns.append(values)
            scales.append(max(float(np.abs(values).max()), natural.get(name, 0.0)))
    group = np.arange(len(steady))
    if repeats:
        group = _same_motion(np.stack(columns, axis=1), np.maximum(scales, 1e-12), steady)
    count, names = np.bincount(group), np.array(equations.names, dtype=object)
    sums = np.zeros((len(count), *equations.sums.shape[1:]))
    np.add.at(sums, group[equations.test], equations.sums)
    members = tuple(tuple(names[group == g]) for g in range(len(count)))
    features = {name: np.bincount(group, values) / count for name, values in done.items()}
    return DistinctMotions(sums, members, features, np.bincount(group, steady) / count > 0.5)


def _moments(equations: NormalEquations) -> tuple[Moments, Moments]:
    """Mean and standard deviation of what moved in each test, 0 if it is not in the table."""
    nothing = np.zeros(len(equations.names))
    mean, std = Moments(lambda: nothing), Moments(lambda: nothing)
    for name, parts in equations.moved.items():
        rows, total, squares = equations.by_test(parts).T
        mean[name], std[name] = total / rows, np.sqrt(np.maximum(squares / rows - (total / rows) ** 2, 0.0))
    return mean, std


def numbered(values: Sequence[float] | np.ndarray) -> np.ndarray:
    """Number values (n,) by the first one that each is within 5 % of."""
    # The smallest comes first, so that the order of the tests does not matter; a group is kept against its own first
    # member, never against its last: neighbours do not chain.
    values = np.asarray(values, float)
    group, first, count = np.zeros(len(values), int), np.nan, 0
    for i in np.argsort(values, kind="stable"):
        if not abs(values[i] - first) <= EDGE * 0.05 * abs(first):
            first, count = float(values[i]), count + 1
        group[i] = count
    return pd.factorize(group)[0]


def grouped(values: np.ndarray) -> list[np.ndarray]:
    """Indices of the values of each number, the smallest values first."""
    number = numbered(values)
    return sorted((np.flatnonzero(number == own) for own in range(number.max() + 1)), key=lambda own: values[own[0]])


def _same_motion(features: np.ndarray, scales: np.ndarray, steady: np.ndarray) -> np.ndarray:
    """Number of each test's motion; tests are taken by their features, so that their order does not matter."""
    firsts: list[int] = []
    group = np.zeros(len(features), int)
    for i in np.lexsort(features.T[::-1]):
        seen = features[firsts]
        near = np.abs(features[i] - seen) <= EDGE * SAME_MOTION * np.maximum(np.abs(seen), FLOOR * scales)
        same = np.flatnonzero(near.all(axis=1) & (steady[firsts] == steady[i]))
        if not same.size:
            firsts.append(int(i))
        group[i] = same[0] if same.size else len(firsts) - 1
    return pd.factorize(group)[0]


# Share of the largest eigenvalue of scaled products, below which a direction holds only rounding [1].
RANK = 1e-9
# Column of the velocity whose rate an inertial term takes.
VELOCITIES: dict[tuple[str, ...], str] = {("vdot",): "column v", ("rdot",): "column r"}
# Ridge of the first fit, a share of the information that one motion gives of a term as large as the force.
RIDGE = 4e-6
# Each block's rows, the mean's rows, the rows of the first stretches, motion, number of runs, whether it is of a mean.
Blocks = list[tuple[np.ndarray, np.ndarray, np.ndarray, int, float, bool]]
# Value of a coefficient beyond which no force of a towing tank puts it [SI]: its column is empty but for rounding.
MOST_UNIT = 1e16


class ForceRows:
    """Rows of some forces, one after the other: those of each motion's mean, of differences between its repeats."""

    def __init__(
        self, equations: NormalEquations, motions: DistinctMotions, blocks: Blocks, problem: Problem,
        forces: Sequence[str], noise: np.ndarray | None = None,
    ) -> None:  # fmt: skip
        self.problem, self.names, self.forces, self.count = problem, equations.columns, tuple(forces), len(forces)
        sums = equations.of_each_test
        total, y = np.diag(sums.sum(axis=0)), np.array([equations.columns[force] for force in forces])
        # (forces,) Root mean square of each force, and variance of a row of one run by the noise within it.
        self.level = np.sqrt(np.maximum(total[y] / total[equations.columns[ONE]], 1e-300))
        least = (1e-6 * self.level) ** 2  # Where the rows have no noise
        self.noise = np.maximum(_noise(equations, sums, y), least) if noise is None else noise
        columns, reference, early, motion, runs, is_mean = zip(*blocks, strict=True)
        # (rows, m) Every column of the sums; of the motion's mean, to which errors of gain are proportional; with the
        # first stretches of each run counted alone.
        self.columns, self.reference, self.early = np.vstack(columns), np.vstack(reference), np.vstack(early)
        # (blocks,) Number of rows, the first one, how many runs are averaged, and whether it is of a motion's mean.
        self.sizes = np.array([len(part) for part in columns])
        self.starts, self.runs, self.is_mean = np.cumsum(self.sizes) - self.sizes, np.array(runs), np.array(is_mean)
        # (rows,) The motion of each, whether it is of a mean, and the root of the number of rows of its block.
        self.motion, self.of_mean = np.repeat(motion, self.sizes), np.repeat(self.is_mean, self.sizes)
        rows = np.sqrt(np.add.reduceat(self.reference[:, self.names[ONE]] ** 2, self.starts))
        self.length, self.each = np.repeat(rows, self.sizes), len(self.motion)
        self.terms = [(f, term) for f, force in enumerate(forces) for term in problem.terms.forces[force]]
        self.free_parameters = sorted({problem.slot[term.name] for _, term in self.terms})
        self._describe(motions)
        self.y = np.concatenate([self.raw(force) for force in forces])
        self.x = np.zeros((len(self.y), len(self.free_parameters)))
        for f, term in self.terms:
            self.x[:, self.place(term)] += self.of(f, self.raw(term.name))
        self.theta = self._first_fit()

    def _describe(self, motions: DistinctMotions) -> None:
        """Motion of each row: speed, octaves of the period, depth, side, and whether nothing oscillates."""
        speed, period, depth = (np.asarray(motions.features[name]) for name in ("speed", "period", "depth"))
        self.speed, self.steady = speed[self.motion], motions.steady[self.motion].astype(float)
        self.mixed = bool(0 < self.steady.sum() < len(self.steady))
        harmonic, octaves, frequency = period > 0, np.zeros(len(period)), np.zeros(len(period))
        octaves[harmonic], frequency[harmonic] = np.log2(period[harmonic]), 2 * np.pi / period[harmonic]
        # Coefficients are those at the middle of the speeds and depths, and at the mean of the octaves.
        octaves[harmonic] -= octaves.sum() / max(harmonic.sum(), 1)
        self.frequency, self.octaves = frequency[self.motion], octaves[self.motion]
        logs = (np.log(self.speed), np.log(np.maximum(depth[self.motion], 1e-9)))
        self.speeds, self.depths = (values - 0.5 * (values.min() + values.max()) for values in logs)
        self.side = np.sign(self.reference[:, self.names["column y"]] * self.reference[:, self.names[ONE]])
        self.reach = float(max(motions.features["reach"].max(), 1e-9))

    def place(self, term: Term) -> int:
        return self.free_parameters.index(self.problem.slot[term.name])

    def of(self, force: int, column: np.ndarray) -> np.ndarray:
        return np.outer(np.arange(self.count) == force, column).ravel()

    def all(self, column: np.ndarray) -> np.ndarray:
        return np.tile(column, self.count)

    @property
    def lateral(self) -> list[int]:
        """Forces that a side force, an offset or another hull form changes: sway and yaw."""
        return [f for f, force in enumerate(self.forces) if force != "X"]

    def side_force(self, force: np.ndarray, lever: float) -> np.ndarray:
        levers = {"Y": 1.0, "N": lever}
        return np.outer([levers.get(name, 0.0) for name in self.forces], force).ravel()

    def raw(self, name: str) -> np.ndarray:
        return np.asarray(self.columns[:, self.names[name]])

    def rms(self, column: np.ndarray) -> float:
        mean = np.add.reduceat(column**2, self.starts) / self.length[self.starts] ** 2
        return float(np.sqrt(mean[self.is_mean].mean()))

    def size(self, force: int, term: Term) -> float:
        """Force per unit of a term's column that a change of the term by one is taken for."""
        # A small term whose slope is let vary counts as a tenth of the force's level.
        rms, level = max(self.rms(self.raw(term.name)), 1e-300), self.level[force]
        return float(np.clip(abs(self.theta[self.place(term)]) * rms, 0.1 * level, level) / rms)

    def units(self) -> np.ndarray:
        """Value of each coefficient at which its term is as large as the force."""
        unit = np.full(len(self.free_parameters), np.inf)
        for f, term in self.terms:
            own = self.level[f] / max(self.rms(self.raw(term.name)), 1e-300)
            unit[self.place(term)] = min(unit[self.place(term)], own)
        return np.where(unit < MOST_UNIT, unit, 1.0)  # Any unit serves for an empty column

    def fitted(self, columns: np.ndarray, bank: bool = False, prefix: str = "") -> np.ndarray:
        """Force of the first fit, or of its bank, by rows of the sums or of a derivative: (forces, rows)."""
        total = np.zeros((self.count, self.each))
        for f, term in self.terms:
            name = prefix + term.name
            if name in self.names and (term.from_bank or not bank):
                total[f] += self.theta[self.place(term)] * columns[:, self.names[name]]
        return total

    def shift(self, prefix: str) -> np.ndarray:
        """Force of the first fit along a derivative of its regressors, in the rows of every force."""
        return self.fitted(self.columns, prefix=f"{prefix} of ").ravel()

    def rate(self) -> np.ndarray:
        """Rate of the force of the first fit; in harmonic motion that of an acceleration is -w2 times the velocity."""
        total = self.shift("time")
        for f, term in self.terms:
            if velocity := VELOCITIES.get(term.inputs):
                inertia = -term.regressor(1.0) * self.theta[self.place(term)]  # In the unit of the acceleration
                total += self.of(f, inertia * self.frequency**2 * self.raw(velocity))
        return total

    def weights(self) -> np.ndarray:
        """Weight of each row by which each motion counts alike, over the force's level; 0 of repeats."""
        return np.asarray(self.all(self.of_mean / self.length) / np.repeat(self.level, self.each))

    def _first_fit(self) -> np.ndarray:
        """Ridge regression in which each motion counts alike."""
        weight, count = self.weights(), self.is_mean.sum()
        x, y = self.x * weight[:, None], self.y * weight
        size = np.sqrt((x**2).sum(axis=0) / count)
        # What rounding leaves of an empty column would have a coefficient of any size.
        size = np.where(size * MOST_UNIT > 1, size, np.inf)
        z = x / size
        return np.asarray(np.linalg.solve(z.T @ z + RIDGE * count * np.eye(len(size)), z.T @ y) / size)


def row_blocks(equations: NormalEquations, motions: DistinctMotions) -> Blocks:
    """Blocks of rows by sums of products of tests, the same for every force; exact copies of a test count once."""
    from scipy.linalg import helmert

    sums, position = equations.of_each_test, {name: i for i, name in enumerate(equations.names)}
    basis = np.unique([i for name, i in equations.columns.items() if not _is_measured(name)])
    one, total = equations.columns[ONE], sums.sum(axis=0)
    usual = np.sqrt(np.maximum(np.diag(total)[basis], 0.0) / total[one, one])
    # Sums of each test whose stretches count 1, 1/e, 1/e2 and so on.
    passed, order = Counter[str](), []
    for name in equations.tests:
        order.append(passed[name])
        passed[name] += 1
    early = equations.by_test(equations.unweighted * np.exp(-np.array(order))[:, None, None])
    blocks = []
    # In an order that does not depend on that of the tests, so that rounding does not either.
    for motion in sorted(range(len(motions)), key=[_key(gram) for gram in motions.sums].__getitem__):
        tests = [position[name] for name in motions.members[motion]]
        copies = {_key(sums[i]): i for i in reversed(tests)}  # A copy has the same sums of products to ten digits
        own = sums[[copies[key] for key in sorted(copies)]]
        mean = own.mean(axis=0)
        # Gains and form errors do not cover faint directions: there noise of the motion would outweigh the force.
        turn = _turn(mean[np.ix_(basis, basis)], usual * np.sqrt(mean[one, one]), least=0.1)
        rows = turn @ own[:, basis]
        mean = rows.mean(axis=0)
        begin = turn @ early[tests].mean(axis=0)[basis]
        blocks.append((mean, mean, begin, motion, float(len(own)), True))
        contrasts = np.tensordot(helmert(len(rows)), rows, 1)
        blocks += [(difference, mean, 0 * begin, motion, 1.0, False) for difference in contrasts]
    return blocks


def _is_measured(name: str) -> bool:
    return name in "XYN" or name.startswith(("column |X|", "column |Y|", "column |N|", "mount of"))


def _key(gram: np.ndarray) -> tuple[float, ...]:
    return tuple(float(f"{x:.10e}") for x in np.diag(gram))


def _turn(gram: np.ndarray, size: np.ndarray, least: float = 0.0) -> np.ndarray:
    """T with T G T' = 1 over the directions that hold data: T A' are the rows of orthonormal columns."""
    size = np.where(size > 0, size, np.inf)
    values, vectors = np.linalg.eigh(gram / np.outer(size, size))
    kept = values > max(least, RANK * max(values[-1], 1e-300))
    return np.asarray((vectors[:, kept] / np.sqrt(values[kept])).T / size)


def _noise(equations: NormalEquations, sums: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Variance of a row's noise, summed over a run, from the errors of fits to a run on its stretches."""
    # Correlation within a stretch is included, since the error of a stretch is a sum over it.
    names = [name for name in equations.columns if not _is_measured(name) and " " not in name]
    index, one = np.unique([equations.columns[name] for name in names]), equations.columns[ONE]
    pieces = equations.unweighted
    score, rest, freedom, rows = np.zeros(len(y)), np.zeros(len(y)), 0.0, 0.0
    for i in sorted(range(len(sums)), key=lambda i: _key(sums[i])):
        whole = sums[i]
        turn = _turn(whole[np.ix_(index, index)], np.sqrt(np.maximum(np.diag(whole)[index], 0.0)))
        seen = turn @ whole[np.ix_(index, y)]
        own = pieces[equations.test == i]
        grams = turn @ own[:, index[:, None], index] @ turn.T
        left = turn @ own[:, index[:, None], y] - grams @ seen
        score += (left**2).sum(axis=(0, 1))
        freedom += len(turn) - float((grams**2).sum())
        rest += np.maximum(whole[y, y] - (seen**2).sum(axis=0), 0.0)
        rows += whole[one, one] - len(turn)
    plain = rest / max(rows, 1.0) if rows >= 1 else np.zeros(len(y))
    return np.asarray(np.maximum(plain, score / freedom) if freedom > 1 else plain)
