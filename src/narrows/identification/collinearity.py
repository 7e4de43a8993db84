"""Collinearity of the columns of each force: rank, condition number, variance inflation factors, correlation."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from narrows.identification.least_squares import RANK_TOLERANCE
from narrows.identification.motions import DistinctMotions
from narrows.identification.normal_equations import ONE, NormalEquations
from narrows.terms.term import Term, TermTable

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
    empty: tuple[str, ...]  # Coefficients whose column is zero
    # (k, n) Directions without data, of unit length, among the columns that are not zero, each scaled to one
    missing: np.ndarray

    def to_dict(self) -> dict[str, Any]:
        """Give rank, number of columns, condition and variance inflations."""
        return {"rank": self.rank, "columns": len(self.names), "condition": self.condition, "vif": dict(self.vif)}


def diagnose(equations: NormalEquations, sums: np.ndarray, terms: tuple[Term, ...]) -> Diagnosis:
    """Diagnose the columns of one force over the rows behind some sums (m, m)."""
    names = [term.name for term in terms]
    gram, mean = equations.pick(sums, names), equations.pick(sums, names, [ONE])[:, 0]
    norm = np.sqrt(np.diag(gram))
    live = norm > 0
    lengths = np.where(live, norm, np.nan)
    alignment = gram / np.outer(lengths, lengths)
    values, vectors = np.linalg.eigh(alignment[np.ix_(live, live)])
    singular = np.sqrt(np.maximum(values, 0.0))
    kept = singular > RANK_TOLERANCE * singular.max(initial=1e-300)
    missing = np.zeros((int((~kept).sum()), len(names)))
    missing[:, live] = vectors[:, ~kept].T
    vif = np.full(len(names), np.nan)
    vif[live] = np.maximum((vectors[:, kept] ** 2 / values[kept]).sum(axis=1), 1.0)
    vif[(np.abs(missing) > INVOLVED).any(axis=0)] = np.inf
    covariance = gram - np.outer(mean, mean) / equations.pick(sums, [ONE])[0, 0]
    variance = np.diag(covariance)
    # A constant column leaves only rounding.
    spread = np.sqrt(np.where(variance > 1e-12 * np.diag(gram), variance, np.nan))
    return Diagnosis(
        tuple(names),
        rank=int(kept.sum()),
        condition=float(singular[-1] / singular[0]) if kept.sum() == len(names) else float("inf"),
        vif=dict(zip(names, vif.tolist(), strict=True)),
        correlation=np.clip(covariance / np.outer(spread, spread), -1.0, 1.0),
        empty=tuple(name for name, alive in zip(names, live, strict=True) if not alive),
        missing=missing,
    )


@dataclass(frozen=True)
class Diagnostics:
    """The columns of every force, whatever the forces are; each diagnosis is made when it is first asked for."""

    equations: NormalEquations  # The sums
    terms: TermTable  # The terms
    motions: DistinctMotions  # The distinct motions, and their speeds

    @cached_property
    def overall(self) -> dict[str, Diagnosis]:
        """Over all rows: force -> diagnosis."""
        return self.over(self.equations.total)

    @cached_property
    def by_speed(self) -> dict[float, dict[str, Diagnosis]]:
        """Over the tests of each speed together: mean speed [m/s] -> force -> diagnosis."""
        motions = self.motions
        return {
            float(np.mean(motions.features["speed"][members])): self.over(motions.sums[members].sum(axis=0))
            for members in motions.by_speed
        }

    def over(self, sums: np.ndarray) -> dict[str, Diagnosis]:
        """Diagnose each force that has terms over the rows behind some sums (m, m)."""
        return {force: diagnose(self.equations, sums, part) for force, part in self.terms.forces.items() if part}

    def determined(self, name: str) -> bool:
        """Return whether rows determine a coefficient, through its own force or through one that it is tied to."""
        tied = {name, *(other for tie in self.terms.ties if name in tie for other in tie)}
        return any(np.isfinite(d.vif[other]) for d in self.overall.values() for other in tied if other in d.names)
