"""Reduce the rows of each motion and force to a few with the same sums of products."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from narrows.identification.design_matrix import ONE
from narrows.identification.motions import DistinctMotions
from narrows.identification.normal_equations import NormalEquations

# Squared size of a direction over that of the columns: a smaller one is noise of the motion [1].
LEAST_DIRECTION_RATIO = 1e-1
# Share of the largest eigenvalue of scaled products, below which a direction holds only rounding [1].
RANK = 1e-9
# Assumed noise where the rows have none, as a share of a force's root mean square [1].
LEAST_NOISE = 1e-6


@dataclass(frozen=True)
class RunBlocks:
    """Rows of every motion and force, sorted by block; blocks of repeats hold what differs from their motion's mean."""

    columns: np.ndarray  # (rows, m) every column of the sums, forces and the constant among them
    reference: np.ndarray  # (rows, m) the same of the motion's mean, to which errors of gain are proportional
    early: np.ndarray  # (rows, m) the same with the first stretches of each run counted alone
    block: np.ndarray  # (rows,) the block of each row
    motion: np.ndarray  # (blocks,) the motion of each block
    runs: np.ndarray  # (blocks,) how many runs are averaged
    is_mean: np.ndarray  # (blocks,) the mean of a motion's runs; otherwise a difference between repeats
    noise: np.ndarray  # (forces,) variance of a row of one run by the noise within it
    forces: tuple[str, ...]
    level: np.ndarray  # (forces,) root mean square of each force

    @property
    def sizes(self) -> np.ndarray:
        """Number of rows of each block."""
        return np.bincount(self.block)

    @property
    def starts(self) -> np.ndarray:
        """First row of each block."""
        return np.searchsorted(self.block, np.arange(len(self.motion)))


def run_blocks(equations: NormalEquations, motions: DistinctMotions, forces: Sequence[str]) -> RunBlocks:
    """Reduce sums of products to blocks of rows; exact copies of a test count once."""
    sums = equations.by_test(equations.unweighted)
    position = {name: i for i, name in enumerate(equations.names)}
    basis = np.unique([i for name, i in equations.columns.items() if not _is_measured(name)])
    level = np.sqrt([max(equations.mean_square(force), 1e-300) for force in forces])
    noise = np.maximum(_noise(equations, sums, forces), (LEAST_NOISE * level) ** 2)
    one = equations.columns[ONE]
    total = sums.sum(axis=0)
    usual = np.sqrt(np.maximum(np.diag(total)[basis], 0.0) / total[one, one])
    blocks: list[tuple[np.ndarray, np.ndarray, np.ndarray, int, float, bool]] = []
    early = _early(equations)
    keys = [_key(gram) for gram in motions.sums]
    # In an order that does not depend on that of the tests, so that rounding does not either.
    for motion in sorted(range(len(motions)), key=keys.__getitem__):
        members = motions.members[motion]
        own = sums[_distinct([position[name] for name in members], sums)]
        mean = own.mean(axis=0)
        turn = _turn(mean, basis, usual * np.sqrt(mean[one, one]))
        rows = np.stack([turn @ gram[basis] for gram in own])
        mean = rows.mean(axis=0)
        begin = turn @ np.mean([early[position[name]] for name in members], axis=0)[basis]
        blocks.append((mean, mean, begin, motion, float(len(own)), True))
        blocks += [(rows_of, mean, 0 * begin, motion, 1.0, False) for rows_of in _contrasts(rows)]
    columns, reference, first, motion_of, runs, is_mean = zip(*blocks, strict=True)
    sizes, count = [len(part) for part in columns], len(blocks)
    return RunBlocks(
        np.vstack(columns), np.vstack(reference), np.vstack(first), np.repeat(np.arange(count), sizes),
        np.array(motion_of), np.array(runs), np.array(is_mean), noise, tuple(forces), level,
    )  # fmt: skip


def _is_measured(name: str) -> bool:
    """Whether a column is made of measured forces, which carry noise."""
    return name in "XYN" or name.startswith(("column |X|", "column |Y|", "column |N|", "mount of"))


def _early(equations: NormalEquations) -> np.ndarray:
    """Sums over each test whose stretches count 1, 1/e, 1/e2 and so on."""
    passed, order = Counter[str](), np.zeros(len(equations.tests))
    for i, name in enumerate(equations.tests):
        order[i] = passed[name]
        passed[name] += 1
    return equations.by_test(equations.unweighted * np.exp(-order)[:, None, None])


def _distinct(tests: list[int], sums: np.ndarray) -> list[int]:
    """Tests that are not copies of another: a copy has the same sums of products to ten digits."""
    keys = {_key(sums[i]): i for i in reversed(tests)}
    return [keys[key] for key in sorted(keys)]


def _key(gram: np.ndarray) -> tuple[float, ...]:
    return tuple(float(f"{x:.10e}") for x in np.diag(gram))


def _turn(gram: np.ndarray, basis: np.ndarray, usual: np.ndarray | None = None) -> np.ndarray:
    """T with T G T' = 1 over the directions that hold data: T A' are the rows of orthonormal columns.

    Where the usual size of the columns is given, directions that are faint compared with it are left out: gains and
    form errors do not cover them, so that noise of the motion would weigh there more than the force.
    """
    part = gram[np.ix_(basis, basis)]
    size = np.sqrt(np.maximum(np.diag(part), 0.0)) if usual is None else usual.copy()
    size[size <= 0] = np.inf
    values, vectors = np.linalg.eigh(part / np.outer(size, size))
    least = RANK * max(values[-1], 1e-300)
    kept = values > (least if usual is None else max(least, LEAST_DIRECTION_RATIO))
    return np.asarray((vectors[:, kept] / np.sqrt(values[kept])).T / size)


def _contrasts(rows: np.ndarray) -> list[np.ndarray]:
    """Differences between repeats as independent rows (Helmert's contrasts)."""
    result = []
    for j in range(1, len(rows)):
        weights = np.zeros(len(rows))
        weights[:j], weights[j] = 1.0, -j
        result.append(np.tensordot(weights / np.sqrt(j * (j + 1)), rows, 1))
    return result


def _noise(equations: NormalEquations, sums: np.ndarray, forces: Sequence[str]) -> np.ndarray:
    """Variance of a row's noise, summed over a run, from the errors of fits to a run on its stretches.

    Correlation within a stretch is included, since the error of a stretch is a sum over it.
    """
    names = [name for name in equations.columns if not _is_measured(name) and " " not in name]
    index = np.array(sorted({equations.columns[name] for name in names}))
    y, one = np.array([equations.columns[force] for force in forces]), equations.columns[ONE]
    pieces = equations.unweighted
    score, rest, freedom, rows = np.zeros(len(y)), np.zeros(len(y)), 0.0, 0.0
    for i in sorted(range(len(sums)), key=lambda i: _key(sums[i])):
        whole = sums[i]
        turn = _turn(whole, index)
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
