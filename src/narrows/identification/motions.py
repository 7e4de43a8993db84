"""Group tests: repeats of one motion, one speed, one period, one depth, one side of the canal."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.identification.normal_equations import NormalEquations

# Tolerance of each feature, or of a fifth of its largest value if more: within it two tests are one motion.
SAME_MOTION = 0.03
# Tolerance of speed, period or depth against the first test of a level.
SAME_LEVEL = 0.05
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
    """The distinct motions of a table, and what was done in them."""

    # A group is kept against its own first member, never against its last: neighbours do not chain.

    sums: np.ndarray  # (motions, m, m) Sums of products over all tests of a motion
    members: tuple[tuple[str, ...], ...]  # The tests of each motion: the first one and its repeats
    # (motions,) Mean ``speed`` [m/s], ``period`` [s], 0 of steady motions, ``depth`` [m], ``side`` (-1, 0 or 1) and
    # ``reach``, the offset from the centreline that a motion comes to, about [m]
    features: Mapping[str, np.ndarray]
    steady: np.ndarray  # (motions,) Nothing oscillates

    def __len__(self) -> int:
        return len(self.members)

    @property
    def reach(self) -> np.ndarray:
        """Offset from the centreline that each motion comes to, about [m]."""
        return self.features["reach"]

    def level(self, feature: str) -> np.ndarray:
        """Number of the speed, period, depth or side of each motion, (motions,)."""
        return numbered(self.features[feature])

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
        """The motions of each speed, slowest first."""
        group = self.level("speed")
        groups = [np.flatnonzero(group == number) for number in range(group.max() + 1)]
        return sorted(groups, key=lambda members: float(self.features["speed"][members[0]]))

    @property
    def sentence(self) -> str:
        """One sentence of the tests taken as independent."""
        tests = sum(len(members) for members in self.members)
        if tests == len(self):
            return f"Errors are those of {tests} runs, each a motion of its own."
        return (
            f"Errors are those of {len(self)} distinct motions: {tests - len(self)} of the {tests} tests are repeats."
        )


def distinct_motions(equations: NormalEquations) -> DistinctMotions:
    """Group tests by what was done in them."""
    runs = _Runs(equations)
    group = _same_motion(runs)
    count = np.bincount(group)
    mean = {name: np.bincount(group, values) / count for name, values in runs.done.items()}
    names = np.array(equations.names, dtype=object)
    sums = np.zeros((len(count), *equations.sums.shape[1:]))
    np.add.at(sums, group[equations.test], equations.sums)
    members = tuple(tuple(names[group == g]) for g in range(len(count)))
    return DistinctMotions(sums, members, mean, np.bincount(group, runs.steady) / count > 0.5)


def numbered(values: Sequence[float] | np.ndarray, tolerance: float = SAME_LEVEL) -> np.ndarray:
    """Number values by the first one that each is within a tolerance of."""
    # values (n,)
    # The smallest comes first, so that the order of the tests does not matter.
    values = np.asarray(values, float)
    group, first, count = np.zeros(len(values), int), np.nan, 0
    for i in np.argsort(values, kind="stable"):
        if not abs(values[i] - first) <= EDGE * tolerance * abs(first):
            first, count = float(values[i]), count + 1
        group[i] = count
    return _in_order_of_appearance(group)


def _in_order_of_appearance(group: np.ndarray) -> np.ndarray:
    _, first, inverse = np.unique(group, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[inverse.ravel()])


class _Runs:
    """Mean and standard deviation of what moved in each test, 0 if it is not in the table; what was done in it."""

    def __init__(self, equations: NormalEquations) -> None:
        self.length, nothing = equations.length, np.zeros(len(equations.names))
        self.mean: Moments = defaultdict(lambda: nothing)
        self.std: Moments = defaultdict(lambda: nothing)
        for name, parts in equations.moved.items():
            rows, total, squares = equations.by_test(parts).T
            self.mean[name] = total / rows
            self.std[name] = np.sqrt(np.maximum(squares / rows - (total / rows) ** 2, 0.0))
        self.moved, mean, std = tuple(equations.moved), self.mean, self.std
        speed = np.maximum(np.hypot(mean["u"], mean["v"]), 1e-9)
        sizes: dict[str, np.ndarray | float] = {"v": speed, "sin_psi": 1.0, "y": self.length}
        self.steady = np.all([std[name] < share * sizes[name] for name, share in LEAST_MOTION.items()], axis=0)
        # The period by v'' = -w2 v of the largest oscillation, 0 without one [s].
        sways = std["v"] / speed > std["r"] * self.length / speed
        ratio = np.where(sways, std["v"], std["r"]) / np.maximum(np.where(sways, std["vdot"], std["rdot"]), 1e-12)
        reach = np.abs(mean["y"]) + np.sqrt(2) * std["y"]
        self.done = {
            "speed": speed,
            "period": np.where(self.steady, 0.0, 2 * np.pi * ratio),
            "depth": mean["depth"] if "depth" in self.moved else np.ones(len(nothing)),
            "side": np.where(np.abs(mean["y"]) > SIDE * max(reach.max(), 1e-9), np.sign(mean["y"]), 0.0),
            "reach": reach,
        }

    def features(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and amplitude of everything that moved, (tests, features), and the size that each is seen against."""
        fast, long, period = float(self.done["speed"].max()), self.length, self.done["period"]
        natural = {"u": fast, "v": fast, "r": fast / long, "y": 0.1 * long, "sin_psi": 1.0, "rudder": 1.0}
        natural |= {"udot": fast**2 / long, "vdot": fast**2 / long, "rdot": fast**2 / long**2}
        columns, scales = [period], [float(period.max())]
        for name in self.moved:
            rates = name in ("udot", "vdot", "rdot")
            for values in (self.mean[name],) if rates else (self.mean[name], np.sqrt(2) * self.std[name]):
                columns.append(values)
                scales.append(max(float(np.abs(values).max()), natural.get(name, 0.0)))
        return np.stack(columns, axis=1), np.maximum(scales, 1e-12)


def _same_motion(runs: _Runs) -> np.ndarray:
    """Number of each test's motion; tests are taken by their features, so that their order does not matter."""
    features, scales = runs.features()
    firsts: list[int] = []
    group = np.zeros(len(features), int)
    for i in np.lexsort(features.T[::-1]):
        seen = features[firsts]
        near = np.abs(features[i] - seen) <= EDGE * SAME_MOTION * np.maximum(np.abs(seen), FLOOR * scales)
        same = np.flatnonzero(near.all(axis=1) & (runs.steady[firsts] == runs.steady[i]))
        if not same.size:
            firsts.append(int(i))
        group[i] = same[0] if same.size else len(firsts) - 1
    return _in_order_of_appearance(group)
