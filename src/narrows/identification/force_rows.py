"""The rows of the forces that are fitted together, with the columns of their random effects."""

from collections.abc import Mapping

import numpy as np

from narrows.identification.design_matrix import ONE
from narrows.identification.least_squares import Problem
from narrows.identification.motions import DistinctMotions
from narrows.identification.run_blocks import RunBlocks
from narrows.terms.term import Term

# Column of the velocity whose rate an inertial term takes.
VELOCITIES = {"vdot": "column v", "rdot": "column r"}
# Share of a force's level: least size of a term whose slope is let vary.
LEAST_TERM_SHARE = 0.1
# Ridge of the first fit, a share of the information that one motion gives of a term as large as the force.
RIDGE = 4e-6
# Value of a coefficient beyond which no force of a towing tank puts it [SI]: its column is empty but for rounding.
MOST_UNIT = 1e16


class ForceRows:
    """Rows of some forces, one force after the other, and the first fit to them."""

    def __init__(self, blocks: RunBlocks, motions: DistinctMotions, problem: Problem, names: Mapping[str, int]) -> None:
        self.blocks, self.problem, self.names = blocks, problem, names
        self.each, self.count = len(blocks.block), len(blocks.forces)
        self.terms = [(f, term) for f, force in enumerate(blocks.forces) for term in problem.terms.forces[force]]
        self.free_parameters = sorted({problem.slot[term.name] for _, term in self.terms})
        rows = np.sqrt(np.add.reduceat(blocks.reference[:, names[ONE]] ** 2, blocks.starts))
        self.length = np.repeat(rows, blocks.sizes)  # root of the number of rows that a block stands for
        self._describe(motions)
        self.y = np.concatenate([blocks.columns[:, names[force]] for force in blocks.forces])
        self.x = np.zeros((self.each * self.count, len(self.free_parameters)))
        for f, term in self.terms:
            self.x[:, self.place(term)] += self.of(f, self.raw(term.name))
        self.theta = self._first_fit()

    def _describe(self, motions: DistinctMotions) -> None:
        """Motion of each row: speed, octaves of the period, depth, side, and whether nothing oscillates."""
        motion = self.blocks.motion[self.blocks.block]
        speed, period, depth = (np.asarray(motions.features[name])[motion] for name in ("speed", "period", "depth"))
        self.speed, harmonic = speed, period > 0
        self.steady = motions.steady[motion].astype(float)
        self.mixed = bool(0 < self.steady.sum() < len(self.steady))
        period = np.where(harmonic, period, 1.0)
        self.frequency = np.where(harmonic, 2 * np.pi / period, 0.0)
        # Coefficients are those at the middle of the speeds and depths, and at the mean of the octaves.
        octaves = np.log2(period)
        first = np.zeros(self.each, bool)
        first[self.blocks.starts[self.blocks.is_mean]] = True
        centre = octaves[first & harmonic].mean() if (first & harmonic).any() else 0.0
        self.octaves = np.where(harmonic, octaves - centre, 0.0)
        self.speeds, self.depths = _about_middle(np.log(speed)), _about_middle(np.log(np.maximum(depth, 1e-9)))
        offset = self.blocks.reference[:, self.names["column y"]] * self.blocks.reference[:, self.names[ONE]]
        self.side = np.sign(offset)
        self.reach = float(max(motions.reach.max(), 1e-9))

    def place(self, term: Term) -> int:
        """Return the column of ``x`` that a term adds to."""
        return self.free_parameters.index(self.problem.slot[term.name])

    def of(self, force: int, column: np.ndarray) -> np.ndarray:
        """A column in the rows of one force, zero elsewhere."""
        whole = np.zeros(self.each * self.count)
        whole[force * self.each : (force + 1) * self.each] = column
        return whole

    def all(self, column: np.ndarray) -> np.ndarray:
        """A column in the rows of every force."""
        return np.tile(column, self.count)

    def raw(self, name: str) -> np.ndarray:
        """A column of the sums."""
        return np.asarray(self.blocks.columns[:, self.names[name]])

    def rms(self, column: np.ndarray) -> float:
        """Root mean square over the motions, each alike."""
        starts = self.blocks.starts
        mean = np.add.reduceat(column**2, starts) / self.length[starts] ** 2
        return float(np.sqrt(mean[self.blocks.is_mean].mean()))

    def size(self, force: int, term: Term) -> float:
        """Force per unit of a term's column that a change of the term by one is taken for."""
        rms, level = max(self.rms(self.raw(term.name)), 1e-300), self.blocks.level[force]
        return float(np.clip(abs(self.theta[self.place(term)]) * rms, LEAST_TERM_SHARE * level, level) / rms)

    def units(self) -> np.ndarray:
        """Value of each coefficient at which its term is as large as the force."""
        unit = np.full(len(self.free_parameters), np.inf)
        for f, term in self.terms:
            own = self.blocks.level[f] / max(self.rms(self.raw(term.name)), 1e-300)
            unit[self.place(term)] = min(unit[self.place(term)], own)
        return np.where(unit < MOST_UNIT, unit, 1.0)  # Any unit serves for an empty column

    def shift(self, prefix: str) -> np.ndarray:
        """Force of the first fit along a derivative of its regressors, in the rows of every force."""
        total = np.zeros(self.each * self.count)
        for f, term in self.terms:
            if f"{prefix} of {term.name}" in self.names:
                total += self.of(f, self.theta[self.place(term)] * self.raw(f"{prefix} of {term.name}"))
        return total

    def fitted(self, columns: np.ndarray, bank: bool = False) -> np.ndarray:
        """Force of the first fit, or of its bank, by other rows of the sums: (forces, rows)."""
        total = np.zeros((self.count, self.each))
        for f, term in self.terms:
            if term.from_bank or not bank:
                total[f] += self.theta[self.place(term)] * columns[:, self.names[term.name]]
        return total

    def rate(self) -> np.ndarray:
        """Rate of the force of the first fit; in harmonic motion that of an acceleration is -w2 times the velocity."""
        total = self.shift("time")
        for f, term in self.terms:
            velocity = VELOCITIES.get(" ".join(term.inputs))
            if velocity:
                inertia = -term.regressor(1.0) * self.theta[self.place(term)]  # In the unit of the acceleration
                total += self.of(f, inertia * self.frequency**2 * self.raw(velocity))
        return total

    def weights(self) -> np.ndarray:
        """Weight of each row by which each motion counts alike, over the force's level; 0 of repeats."""
        level, mean = np.repeat(self.blocks.level, self.each), self.all(self.blocks.is_mean[self.blocks.block])
        return np.asarray(mean / (level * self.all(self.length)))

    def _first_fit(self) -> np.ndarray:
        """Ridge regression in which each motion counts alike."""
        weight = self.weights()
        x, y = self.x * weight[:, None], self.y * weight
        count = self.blocks.is_mean.sum()
        size = np.sqrt((x**2).sum(axis=0) / count)
        # What rounding leaves of an empty column would have a coefficient of any size.
        size = np.where(size * MOST_UNIT > 1, size, np.inf)
        z = x / size
        return np.asarray(np.linalg.solve(z.T @ z + RIDGE * count * np.eye(len(size)), z.T @ y) / size)


def _about_middle(values: np.ndarray) -> np.ndarray:
    return np.asarray(values - 0.5 * (values.min() + values.max()))
