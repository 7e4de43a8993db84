"""Group tests: repeats of one motion, one speed, one period, one depth, one side of the canal."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.identification.normal_equations import NormalEquations

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
        group = self.level("speed")
        groups = [np.flatnonzero(group == number) for number in range(group.max() + 1)]
        return sorted(groups, key=lambda members: float(self.features["speed"][members[0]]))

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
    return _in_order_of_appearance(group)


def _in_order_of_appearance(group: np.ndarray) -> np.ndarray:
    _, first, inverse = np.unique(group, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[inverse.ravel()])


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
    return _in_order_of_appearance(group)
