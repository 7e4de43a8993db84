"""Correlations of the estimates: pairs of coefficients that the tests do not separate."""

from dataclasses import dataclass

import numpy as np

from narrows.identification.regression.problem import Problem
from narrows.identification.regression.solve import RIDGE

# Correlation of two estimates beyond which they are named as a pair.
STRONG = 0.9


@dataclass(frozen=True)
class CorrelatedPair:
    """Two coefficients that the tests hardly separate."""

    first: str  # Coefficients
    second: str  # Coefficients
    correlation: float  # Correlation of their estimates, by the columns alone [1]
    # Change of ``second`` for a change of ``first`` by one, the fit staying as good as it can, in the unit of
    # ``second`` over that of ``first``
    slope: float

    @property
    def sentence(self) -> str:
        """One sentence of the pair."""
        return (
            f"{self.first} and {self.second} trade against each other (correlation {self.correlation:+.3f}): "
            f"{self.first} up by 1 moves {self.second} by {self.slope:+.3g}"
        )


def correlated_pairs(problem: Problem, total: np.ndarray) -> tuple[CorrelatedPair, ...]:
    """Find the pairs, the closest first."""
    # total (m, m)
    inverse = np.linalg.inv(_ridged(problem.normal(total)[0]))
    size = np.sqrt(np.diag(inverse))
    correlation = inverse / np.outer(size, size)
    names = {slot: name for name, slot in reversed(list(problem.slot.items()))}
    known = [slot for slot in names if size[slot] < 1 / np.sqrt(np.sqrt(RIDGE))]
    pairs = [
        CorrelatedPair(
            names[i],
            names[j],
            float(correlation[i, j]),
            float(inverse[i, j] / inverse[i, i] * problem.scale[i] / problem.scale[j]),
        )
        for i in known
        for j in known
        if i < j and abs(correlation[i, j]) > STRONG
    ]
    return tuple(sorted(pairs, key=lambda pair: -abs(pair.correlation)))


def _ridged(h: np.ndarray) -> np.ndarray:
    empty = np.diag(h) == 0
    return np.asarray(h + np.diag(np.where(empty, 1.0, RIDGE)))
