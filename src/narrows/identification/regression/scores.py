"""R2 and RMSE of X, Y and N from sums of products."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from narrows.identification.regression.normal_equations import ONE, NormalEquations
from narrows.terms.term import Term, TermTable


class Score(NamedTuple):
    """Errors of one reproduced force."""

    r2: float  # Share of the variance explained [1]
    rmse: float  # Root mean squared error [N]


def squared_error(
    equations: NormalEquations, sums: np.ndarray, terms: tuple[Term, ...], values: np.ndarray, force: str
) -> float:
    """Return the sum of squared errors [N2 or N2 m2] of one force over the rows behind some sums."""
    # sums (m, m); values (terms,)
    names = [term.name for term in terms]
    gram, cross = equations.pick(sums, names), equations.pick(sums, names, [force])[:, 0]
    square = equations.pick(sums, [force])[0, 0]
    return max(float(square - 2 * values @ cross + values @ gram @ values), 0.0)


def score(
    equations: NormalEquations, sums: np.ndarray, terms: TermTable, coefficients: Mapping[str, float]
) -> dict[str, Score]:
    """Score coefficients on the rows behind some sums."""
    # sums (m, m)
    errors = {
        force: squared_error(equations, sums, part, np.array([coefficients[t.name] for t in part]), force)
        for force, part in terms.forces.items()
        if part
    }
    return scores_of(equations, sums, errors)


def scores_of(equations: NormalEquations, sums: np.ndarray, errors: Mapping[str, float]) -> dict[str, Score]:
    """Put sums of squared errors over the rows behind some sums: force -> score."""
    # sums (m, m); errors [N2 or N2 m2]
    one = equations.columns[ONE]
    rows = sums[one, one]
    scores = {}
    for force, error in errors.items():
        column = equations.columns[force]
        spread = sums[column, column] - sums[one, column] ** 2 / rows
        scores[force] = Score(float(1 - error / spread) if spread > 0 else float("nan"), float(np.sqrt(error / rows)))
    return scores
