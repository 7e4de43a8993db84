"""R2 and RMSE of X, Y and N from sums of products, and the errors on tests that were left out."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from narrows.identification.batch import solve_many
from narrows.identification.moments import ONE, Moments
from narrows.identification.problem import Problem
from narrows.terms.term import Term, TermTable


class Score(NamedTuple):
    """How well one force is reproduced.

    Parameters
    ----------
    r2 : float [1]
        Share of the variance explained.
    rmse : float [N] or [N m]
        Root mean squared error.
    """

    r2: float
    rmse: float


def squared_error(moments: Moments, sums: np.ndarray, terms: tuple[Term, ...], values: np.ndarray, force: str) -> float:
    """Return the sum of squared errors [N2 or N2 m2] of one force over the rows behind some sums (ours).

    Parameters
    ----------
    moments : Moments
        For its columns.
    sums : array (m, m)
        The rows.
    terms : tuple of Term
        The force's terms.
    values : array (terms,)
        Their coefficients.
    force : str
        ``X``, ``Y`` or ``N``.
    """
    names = [term.name for term in terms]
    gram, cross = moments.pick(sums, names), moments.pick(sums, names, [force])[:, 0]
    own = moments.pick(sums, [force])[0, 0]
    return max(float(own - 2 * values @ cross + values @ gram @ values), 0.0)


def score(moments: Moments, sums: np.ndarray, terms: TermTable, coefficients: Mapping[str, float]) -> dict[str, Score]:
    """Score coefficients on the rows behind some sums.

    Parameters
    ----------
    moments : Moments
        For its columns.
    sums : array (m, m)
        The rows.
    terms : TermTable
        The terms.
    coefficients : mapping of str to float
        Their values.
    """
    errors = {
        force: squared_error(moments, sums, own, np.array([coefficients[t.name] for t in own]), force)
        for force, own in terms.forces.items()
        if own
    }
    return _scores(moments, sums, errors)


def _scores(moments: Moments, sums: np.ndarray, errors: Mapping[str, float]) -> dict[str, Score]:
    one = moments.columns[ONE]
    rows = sums[one, one]
    scores = {}
    for force, error in errors.items():
        own = moments.columns[force]
        spread = sums[own, own] - sums[one, own] ** 2 / rows
        scores[force] = Score(float(1 - error / spread) if spread > 0 else float("nan"), float(np.sqrt(error / rows)))
    return scores


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


def left_out_score(moments: Moments, terms: TermTable, clusters: np.ndarray, without: np.ndarray) -> dict[str, Score]:
    """Score each cluster with the coefficients that were fitted without it.

    Parameters
    ----------
    moments : Moments
        For its columns.
    terms : TermTable
        The terms.
    clusters : array (clusters, m, m)
        Sums over each cluster.
    without : array (clusters, n)
        Coefficients fitted without it.
    """
    place = {name: i for i, name in enumerate(terms.names)}
    errors = {
        force: sum(
            squared_error(moments, sums, own, values[[place[term.name] for term in own]], force)
            for sums, values in zip(clusters, without, strict=True)
        )
        for force, own in terms.forces.items()
        if own
    }
    return _scores(moments, clusters.sum(axis=0), errors)


def left_out_by_speed(problem: Problem, moments: Moments) -> dict[str, Score]:
    """Score each speed with the coefficients that were fitted to the others: force -> score (ours).

    Parameters
    ----------
    problem : Problem
        The joint problem.
    moments : Moments
        The sums.
    """
    groups = np.stack([moments.sums[group].sum(axis=0) for group in moments.speed_groups])
    if len(groups) < 2:
        return {}
    without = left_out_coefficients(problem, groups.sum(axis=0) - groups)
    return left_out_score(moments, problem.terms, groups, without)
