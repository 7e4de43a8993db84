"""Sums of products of every column with every other, test by test: the normal equations before a force is chosen.

Everything that identification says (fit, standard errors, left-out errors, rank, VIF, Shapley shares) follows
from these sums, so its cost after the pass over the rows, and its memory, do not grow with the rows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

ONE = "1"
"""Name of the column of ones."""
Balance = Literal["tests", "rows"]
"""What counts alike in a fit."""


@dataclass(frozen=True)
class NormalEquations:
    """Sums of products over the rows of each piece of each test, each row by its weight.

    Parameters
    ----------
    columns : mapping of str to int
        Which column of the sums is which coefficient's regressor, force, or the constant ``1``; coefficients
        with the same regressor share one.
    sums : array (pieces, m, m)
        Products of columns, summed over rows.
    tests : tuple of str
        The test of each piece.
    moved : mapping of str to array (pieces, 3)
        Rows, sum and sum of squares of each quantity that says what was done in a test.
    length : float [m]
        Of the ship.
    weights : array (pieces,) [1], optional
        What a row of each piece counts, one on average over all rows; one unless given.
    """

    columns: Mapping[str, int]
    sums: np.ndarray
    tests: tuple[str, ...]
    moved: Mapping[str, np.ndarray]
    length: float
    weights: np.ndarray | None = None

    def balanced(self) -> "NormalEquations":
        """Return the same with each test counting alike, however many rows it has (ours)."""
        one = self.columns[ONE]
        rows = {name: float(self.of_test(name)[one, one]) for name in self.names}
        mean = sum(rows.values()) / len(rows)
        weights = np.array([mean / rows[test] for test in self.tests])
        return replace(self, sums=self.sums * weights[:, None, None], weights=weights)

    def noise_weight(self, tests: Sequence[str]) -> float:
        """Return the variance of a weighted row's noise over that of a plain one, over the rows of some tests.

        Parameters
        ----------
        tests : sequence of str
            Whose rows.
        """
        if self.weights is None:
            return 1.0
        weighted = self.sums[:, self.columns[ONE], self.columns[ONE]] * np.isin(self.tests, tests)
        return float(self.weights @ weighted / weighted.sum())

    @property
    def balance(self) -> Balance:
        """What counts alike."""
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
        """Return the sums over one test, (m, m).

        Parameters
        ----------
        name : str
            The test.
        """
        return np.asarray(self.sums[[test == name for test in self.tests]].sum(axis=0))

    def by_test(self) -> np.ndarray:
        """Return the sums over each test, (tests, m, m)."""
        return np.stack([self.of_test(name) for name in self.names])

    def pick(self, sums: np.ndarray, rows: list[str], columns: list[str] | None = None) -> np.ndarray:
        """Return the sums of some columns.

        Parameters
        ----------
        sums : array (..., m, m)
            Of this object.
        rows, columns : list of str
            Coefficients, forces or ``1``; the columns are the rows where left out.
        """
        i = [self.columns[name] for name in rows]
        j = [self.columns[name] for name in columns] if columns else i
        return sums[..., np.array(i)[:, None], np.array(j)[None, :]]


def count(sums: np.ndarray, columns: Mapping[str, int]) -> int:
    """Return the number of rows behind some sums (ours).

    Parameters
    ----------
    sums : array (m, m)
        Of a NormalEquations.
    columns : mapping of str to int
        Its columns.
    """
    return round(float(sums[columns[ONE], columns[ONE]]))
