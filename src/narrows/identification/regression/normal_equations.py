"""Sums of products of every column with every other, test by test: the normal equations before a force is chosen.

Everything that identification says (fit, standard errors, left-out errors, rank, VIF, Shapley shares) follows
from these sums, so its cost after the pass over the rows, and its memory, do not grow with the rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

# Name of the column of ones.
ONE = "1"
# Weights of strata in a fit.
Balance = Literal["tests", "rows"]


@dataclass(frozen=True)
class NormalEquations:
    """Sums of products over the rows of each piece of each test, each row by its weight."""

    # Which column of the sums is which coefficient's regressor, force, or the constant ``1``; coefficients with the
    # same regressor share one
    columns: Mapping[str, int]
    sums: np.ndarray  # (pieces, m, m) Products of columns, summed over rows
    tests: tuple[str, ...]  # The test of each piece
    # (pieces, 3) Rows, sum and sum of squares of each quantity that says what was done in a test
    moved: Mapping[str, np.ndarray]
    length: float  # Length of the ship [m]
    # (pieces,) What a row of each piece counts, one on average over all rows; one unless given [1]
    weights: np.ndarray | None = None

    def balanced(self) -> "NormalEquations":
        """Return the same with each test counting alike, however many rows it has."""
        one = self.columns[ONE]
        rows = {name: float(self.of_test(name)[one, one]) for name in self.names}
        mean = sum(rows.values()) / len(rows)
        weights = np.array([mean / rows[test] for test in self.tests])
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

    def of_test(self, name: str) -> np.ndarray:
        """Return the sums over one test, (m, m)."""
        return np.asarray(self.sums[[test == name for test in self.tests]].sum(axis=0))

    def by_test(self) -> np.ndarray:
        """Return the sums over each test, (tests, m, m)."""
        return np.stack([self.of_test(name) for name in self.names])

    def pick(self, sums: np.ndarray, rows: list[str], columns: list[str] | None = None) -> np.ndarray:
        """Return the sums of some columns."""
        # sums (..., m, m)
        i = [self.columns[name] for name in rows]
        j = [self.columns[name] for name in columns] if columns else i
        return sums[..., np.array(i)[:, None], np.array(j)[None, :]]


def count(sums: np.ndarray, columns: Mapping[str, int]) -> int:
    """Return the number of rows behind some sums."""
    # sums (m, m)
    return round(float(sums[columns[ONE], columns[ONE]]))
