"""Cross-validation: errors on each distinct motion and each speed that is left out, with its repeats."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.identification.regression.problem import Problem
from narrows.identification.regression.scores import Score, scores_of, squared_error
from narrows.identification.regression.solve import solve_many
from narrows.terms.term import TermTable


class Validation(NamedTuple):
    """Prediction errors of a fit on left-out rows."""

    scores: Mapping[str, Score]  # R2 and RMSE of each force on rows left out
    split: str  # ``test``, by distinct motion, or ``random``


def left_out_coefficients(problem: Problem, without: np.ndarray) -> np.ndarray:
    """Fit without each group of rows in turn, (groups, n)."""
    # without (groups, m, m)
    return problem.coefficients(solve_many(*problem.normal(without), problem.lower, problem.upper))


def left_out_score(
    equations: NormalEquations, terms: TermTable, groups: np.ndarray, without: np.ndarray
) -> dict[str, Score]:
    """Score each group of rows with the coefficients that were fitted without it; NaN where there is one group."""
    # groups (groups, m, m); without (groups, n)
    if len(groups) < 2:
        return {force: Score(float("nan"), float("nan")) for force, part in terms.forces.items() if part}
    index = {name: i for i, name in enumerate(terms.names)}
    errors = {
        force: sum(
            squared_error(equations, sums, part, values[[index[term.name] for term in part]], force)
            for sums, values in zip(groups, without, strict=True)
        )
        for force, part in terms.forces.items()
        if part
    }
    return scores_of(equations, groups.sum(axis=0), errors)


def left_out_by_speed(problem: Problem, equations: NormalEquations, motions: DistinctMotions) -> dict[str, Score]:
    """Score each speed with the coefficients that were fitted to the others: force -> score."""
    groups = np.stack([motions.sums[members].sum(axis=0) for members in motions.by_speed])
    if len(groups) < 2:
        return {}
    without = left_out_coefficients(problem, groups.sum(axis=0) - groups)
    return left_out_score(equations, problem.terms, groups, without)
