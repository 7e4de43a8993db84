"""Errors on what was left out of the fit: each cluster of tests in turn, and each speed."""

import numpy as np

from narrows.identification.regression.batch import solve_many
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.identification.regression.problem import Problem
from narrows.identification.regression.scores import Score, scores_of, squared_error
from narrows.terms.term import TermTable


def left_out_coefficients(problem: Problem, without: np.ndarray) -> np.ndarray:
    """Fit without each cluster of rows in turn, (clusters, n).

    Parameters
    ----------
    problem : Problem
        The joint problem.
    without : array (clusters, m, m)
        Sums over all but each cluster.
    """
    return problem.coefficients(solve_many(*problem.normal(without), problem.lower, problem.upper))


def left_out_score(
    equations: NormalEquations, terms: TermTable, clusters: np.ndarray, without: np.ndarray
) -> dict[str, Score]:
    """Score each cluster with the coefficients that were fitted without it.

    Parameters
    ----------
    equations : NormalEquations
        For its columns.
    terms : TermTable
        The terms.
    clusters : array (clusters, m, m)
        Sums over each cluster.
    without : array (clusters, n)
        Coefficients fitted without it.
    """
    index = {name: i for i, name in enumerate(terms.names)}
    errors = {
        force: sum(
            squared_error(equations, sums, part, values[[index[term.name] for term in part]], force)
            for sums, values in zip(clusters, without, strict=True)
        )
        for force, part in terms.forces.items()
        if part
    }
    return scores_of(equations, clusters.sum(axis=0), errors)


def left_out_by_speed(problem: Problem, equations: NormalEquations) -> dict[str, Score]:
    """Score each speed with the coefficients that were fitted to the others: force -> score (ours).

    Parameters
    ----------
    problem : Problem
        The joint problem.
    equations : NormalEquations
        The sums.
    """
    groups = np.stack([equations.sums[group].sum(axis=0) for group in equations.speed_groups])
    if len(groups) < 2:
        return {}
    without = left_out_coefficients(problem, groups.sum(axis=0) - groups)
    return left_out_score(equations, problem.terms, groups, without)
