"""Collinearity of the columns of a force: rank, condition number, variance inflation factors, correlation."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.identification.regression.normal_equations import ONE, NormalEquations
from narrows.identification.regression.solve import RANK_TOLERANCE
from narrows.terms.term import Term

# A column takes part in a direction of unit length where its share is larger than this.
INVOLVED = 1e-3


@dataclass(frozen=True)
class Diagnosis:
    """The columns of one force over some rows."""

    names: tuple[str, ...]  # The coefficients
    rank: int  # Number of directions with data
    condition: float  # Condition number of the matrix with columns scaled to one; infinite where the rank is short [1]
    # Variance inflation, 1/(1 - R2) of a column on the others, without intercept as the model has none; infinite
    # where the column is a combination of others, NaN where it is zero [1]
    vif: Mapping[str, float]
    correlation: np.ndarray  # (n, n) Correlation of the columns; NaN where one does not vary
    # (n, n) Cosine between the columns, which is what a model without intercept feels; NaN where one is zero
    alignment: np.ndarray
    empty: tuple[str, ...]  # Coefficients whose column is zero
    # (k, n) Directions without data, of unit length, among the columns that are not zero, each scaled to one
    missing: np.ndarray

    def partner(self, name: str) -> tuple[str, float]:
        """Return the coefficient whose column is most like this one's, and their alignment [1]."""
        index = self.names.index(name)
        row = np.nan_to_num(self.alignment[index])
        row[index] = 0.0
        most = int(np.abs(row).argmax())
        return self.names[most], float(row[most])

    def to_dict(self) -> dict[str, Any]:
        """Give rank, number of columns, condition and variance inflations."""
        return {
            "rank": self.rank,
            "columns": len(self.names),
            "condition": self.condition,
            "vif": dict(self.vif),
        }


def diagnose(equations: NormalEquations, sums: np.ndarray, terms: tuple[Term, ...]) -> Diagnosis:
    """Diagnose the columns of one force over the rows behind some sums."""
    # sums (m, m)
    names = tuple(term.name for term in terms)
    gram = equations.pick(sums, list(names))
    norm = np.sqrt(np.diag(gram))
    live = norm > 0
    lengths = np.where(live, norm, np.nan)
    alignment = gram / np.outer(lengths, lengths)
    values, vectors = np.linalg.eigh(alignment[np.ix_(live, live)])
    singular = np.sqrt(np.maximum(values, 0.0))
    kept = singular > RANK_TOLERANCE * singular.max(initial=1e-300)
    rank = int(kept.sum())
    full = rank == len(names)
    return Diagnosis(
        names,
        rank,
        float(singular[-1] / singular[0]) if full else float("inf"),
        dict(zip(names, _vif(values, vectors, kept, live).tolist(), strict=True)),
        _correlation(equations, sums, names),
        alignment,
        tuple(name for name, alive in zip(names, live, strict=True) if not alive),
        _spread(vectors[:, ~kept].T, live),
    )


def _vif(values: np.ndarray, vectors: np.ndarray, kept: np.ndarray, live: np.ndarray) -> np.ndarray:
    inflation = (vectors[:, kept] ** 2 / values[kept]).sum(axis=1)
    inflation[(np.abs(vectors[:, ~kept]) > INVOLVED).any(axis=1)] = np.inf
    result = np.full(len(live), np.nan)
    result[live] = np.maximum(inflation, 1.0)
    return result


def _spread(directions: np.ndarray, live: np.ndarray) -> np.ndarray:
    wide = np.zeros((len(directions), len(live)))
    wide[:, live] = directions
    return wide


def _correlation(equations: NormalEquations, sums: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
    rows = equations.pick(sums, [ONE])[0, 0]
    mean = equations.pick(sums, list(names), [ONE])[:, 0] / rows
    gram = equations.pick(sums, list(names)) / rows
    covariance = gram - np.outer(mean, mean)
    variance = np.diag(covariance)
    # A constant column leaves only rounding.
    spread = np.sqrt(np.where(variance > 1e-12 * np.diag(gram), variance, np.nan))
    return np.asarray(np.clip(covariance / np.outer(spread, spread), -1.0, 1.0))
