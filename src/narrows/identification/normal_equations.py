"""Sums of products of every column with every other, test by test: the normal equations before a force is chosen.

All results of identification (fit, standard errors, left-out errors, rank, VIF, Shapley shares) follow
from these sums, so cost and memory do not grow with the rows after one pass over them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from narrows.identification.design_matrix import ONE
from narrows.terms.term import TermTable

# Units of equal weight in a fit.
Balance = Literal["tests", "rows"]


@dataclass(frozen=True)
class NormalEquations:
    """Sums of products over the rows of each piece of each test, each row by its weight."""

    # Which column of the sums is which coefficient's regressor, force, or the constant ``1``; coefficients with the
    # same regressor share one
    columns: Mapping[str, int]
    sums: np.ndarray  # (pieces, m, m) Products of columns, summed over rows
    tests: tuple[str, ...]  # The test of each piece
    # (pieces, 3) Rows, sum and sum of squares of each quantity that describes the motion of a test
    moved: Mapping[str, np.ndarray]
    length: float  # Length of the ship [m]
    # (pieces,) Weight of a row of each piece, one on average over all rows; one unless given [1]
    weights: np.ndarray | None = None

    def balanced(self) -> "NormalEquations":
        """Return the same with each test counting alike, however many rows it has."""
        one = self.columns[ONE]
        rows = self.by_test(self.sums[:, one, one])
        weights = (rows.mean() / rows)[self.test]
        return replace(self, sums=self.sums * weights[:, None, None], weights=weights)

    @property
    def balance(self) -> Balance:
        """Kind of balance."""
        return "rows" if self.weights is None else "tests"

    @property
    def unweighted(self) -> np.ndarray:
        """The sums of plain rows, (pieces, m, m)."""
        return self.sums if self.weights is None else self.sums / self.weights[:, None, None]

    @property
    def total(self) -> np.ndarray:
        """The sums over all rows, (m, m)."""
        return np.asarray(self.sums.sum(axis=0))

    @property
    def names(self) -> tuple[str, ...]:
        """The tests, once each."""
        return tuple(dict.fromkeys(self.tests))

    @cached_property
    def test(self) -> np.ndarray:
        """Index of the test of each piece, (pieces,)."""
        position = {name: i for i, name in enumerate(self.names)}
        return np.array([position[name] for name in self.tests])

    def by_test(self, values: np.ndarray) -> np.ndarray:
        """Add up values of pieces, (pieces, ...), over each test: (tests, ...)."""
        sums = np.zeros((len(self.names), *values.shape[1:]))
        np.add.at(sums, self.test, values)
        return sums

    def pick(self, sums: np.ndarray, rows: list[str], columns: list[str] | None = None) -> np.ndarray:
        """Return the sums of some columns."""
        # sums (..., m, m)
        i = [self.columns[name] for name in rows]
        j = [self.columns[name] for name in columns] if columns else i
        return sums[..., np.array(i)[:, None], np.array(j)[None, :]]

    def mean_square(self, name: str) -> float:
        """Mean square of a column over all rows, each alike."""
        total, one, column = self.unweighted.sum(axis=0), self.columns[ONE], self.columns[name]
        return float(total[column, column] / total[one, one])


def count(sums: np.ndarray, columns: Mapping[str, int]) -> int:
    """Return the number of rows behind some sums."""
    # sums (m, m)
    return round(float(sums[columns[ONE], columns[ONE]]))


class Score(NamedTuple):
    """Errors of one reproduced force."""

    r2: float  # Share of the variance explained [1]
    rmse: float  # Root mean squared error [N]


def score(
    equations: NormalEquations, sums: np.ndarray, terms: TermTable, coefficients: Mapping[str, float]
) -> dict[str, Score]:
    """Score coefficients on the rows behind some sums."""
    # sums (m, m)
    return score_groups(equations, sums[None], terms, np.array([[coefficients[name] for name in terms.names]]))


def score_groups(
    equations: NormalEquations, sums: np.ndarray, terms: TermTable, values: np.ndarray
) -> dict[str, Score]:
    """Score coefficients (groups, n), each on the rows of its own group, with sums (groups, m, m): force -> score."""
    one, total = equations.columns[ONE], sums.sum(axis=0)
    rows, scores = total[one, one], {}
    for force, part in terms.forces.items():
        if not part:
            continue
        names, y = [term.name for term in part], equations.columns[force]
        own = values[:, [terms.names.index(name) for name in names]]
        cross = equations.pick(sums, names, [force])[..., 0]
        fitted = np.einsum("gi,gij,gj->g", own, equations.pick(sums, names), own)
        error = np.maximum(sums[:, y, y] - 2 * (own * cross).sum(axis=1) + fitted, 0.0).sum()
        spread = total[y, y] - total[one, y] ** 2 / rows
        scores[force] = Score(float(1 - error / spread) if spread > 0 else float("nan"), float(np.sqrt(error / rows)))
    return scores
