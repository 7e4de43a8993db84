"""What the data say of each coefficient by itself: the fit with its bounds let go, but those that the data reject."""

from dataclasses import dataclass, replace

import numpy as np

from narrows.identification.regression.batch import RIDGE, solve_many
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.identification.regression.problem import Problem
from narrows.identification.uncertainty.clusters import Clusters, by_stretches, clustered, jackknife
from narrows.identification.uncertainty.interval import t_quantile

FEW_TESTS = 4.0
"""Effective number of tests below which their scatter says next to nothing of a coefficient's error."""
MOST_GROWN = 9.0
"""Where the variance grows tenfold without one cluster, the coefficient rests on it; the jackknife is left as it is."""


@dataclass(frozen=True)
class UnboundedFit:
    """Estimates, standard errors and their covariance, a number for each coefficient.

    A coefficient's bound says nothing of its error, so intervals start from the fit that does not know the bounds.
    Where the data put a coefficient beyond its bound for certain, the others are seen with it held there.

    Parameters
    ----------
    values : array (n,)
        Best values without the bounds that the data allow.
    std : array (n,)
        Cluster-robust standard errors; of a held coefficient as it was when it was let go.
    covariance : array (n, n)
        Cluster-robust; zero for the coefficients that are held.
    held : array (n,) of bool
        Which are held at a bound that the data reject.
    counts : array (n,)
        Effective number of clusters behind each standard error.
    few : array (n,) of bool
        Which rest on so few tests that stretches of them stand in for tests.
    """

    values: np.ndarray
    std: np.ndarray
    covariance: np.ndarray
    held: np.ndarray
    counts: np.ndarray
    few: np.ndarray


def unbounded_fit(problem: Problem, equations: NormalEquations) -> UnboundedFit:
    """Cluster by test; by stretches where there are few tests, or where few of them tell of a coefficient (ours).

    Parameters
    ----------
    problem : Problem
        The joint problem.
    equations : NormalEquations
        The sums.
    """
    clusters = clustered(equations)
    whole = clustered_fit(problem, clusters)
    few = whole.counts < FEW_TESTS
    if not clusters.by_test or not few.any():
        return whole
    stretches = by_stretches(equations)
    fine = clustered_fit(problem, stretches)
    # One set of bounds held for both, so that value, error and covariance are of one fit.
    held = np.where(few, fine.held, whole.held)
    whole, fine = clustered_fit(problem, clusters, held), clustered_fit(problem, stretches, held)
    std = np.where(few, fine.std, whole.std)
    stretch = np.where(whole.std > 0, std / np.where(whole.std > 0, whole.std, 1.0), 1.0)
    return replace(
        whole,
        std=std,
        covariance=whole.covariance * np.outer(stretch, stretch),
        counts=np.where(few, fine.counts, whole.counts),
        few=few,
    )


def clustered_fit(problem: Problem, clusters: Clusters, held: np.ndarray | None = None) -> UnboundedFit:
    """Let the bounds go, hold again one by one those that the data reject, and jackknife what is left (ours).

    Parameters
    ----------
    problem : Problem
        The joint problem.
    clusters : Clusters
        What is taken as independent.
    held : array (n,) of bool, optional
        Which coefficients to hold at their bounds, instead of asking the data.
    """
    h, g = problem.normal(np.concatenate([clusters.sums.sum(axis=0)[None], clusters.without]))
    counts, excess = leverage(h, problem.normal(clusters.sums)[0])
    slots = [problem.slot[name] for name in problem.terms.names]
    chosen = None if held is None else np.isin(np.arange(len(problem.scale)), np.array(slots)[held])
    lower, upper = np.full(len(problem.scale), -np.inf), np.full(len(problem.scale), np.inf)
    values, std = np.zeros(len(lower)), np.zeros(len(lower))
    now = np.zeros(len(lower), bool)
    while True:
        z = solve_many(h, g, lower, upper)
        covariance = jackknife(z[0], z[1:]) / np.sqrt(np.outer(excess, excess))
        error = np.sqrt(np.diag(covariance))
        values[~now], std[~now] = z[0][~now], error[~now]
        more = _rejected(problem, z[0], error * t_quantile(counts), now, h[0]) if chosen is None else chosen & ~now
        if not more.any():
            break
        now |= more
        lower[more] = upper[more] = np.clip(z[0], problem.lower, problem.upper)[more]
    scale = problem.scale[slots]
    return UnboundedFit(
        problem.coefficients(values),
        std[slots] / scale,
        covariance[np.ix_(slots, slots)] / np.outer(scale, scale),
        now[slots],
        counts[slots],
        np.zeros(len(slots), bool),
    )


def _rejected(problem: Problem, z: np.ndarray, far: np.ndarray, held: np.ndarray, h: np.ndarray) -> np.ndarray:
    """The parameter that the data put farthest beyond its bound for certain, if any."""
    excess = np.maximum(problem.lower - z, z - problem.upper) - far
    excess[held | (np.diag(h) == 0)] = -np.inf
    worst = np.arange(len(z)) == excess.argmax()
    return np.asarray(worst & (excess > 0))


def leverage(h: np.ndarray, parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what unequal clusters do to the jackknife: their effective number, and its excess, each (p,).

    A standard error from thirty tests of which two hold nearly all that is known of a coefficient is as uncertain as
    one from two; and the jackknife variance is too large by what each test's absence inflates it, which is known
    exactly for independent errors of one size.

    Parameters
    ----------
    h : array (1 + clusters, p, p)
        Of all rows, and of all but each cluster; scaled.
    parts : array (clusters, p, p)
        Of each cluster.

    References
    ----------
    Carter, Schnepel, Steigerwald (2017), Asymptotic behavior of a t-test robust to cluster heterogeneity.
    Bell, McCaffrey (2002), Bias reduction in standard errors for linear regression with multi-stage samples.
    """
    inverse = np.linalg.inv(h + RIDGE * np.eye(h.shape[-1]))
    shares = np.einsum("ij,kjl,li->ki", inverse[0], parts, inverse[0])
    squares = (shares**2).sum(axis=0)
    counts = np.where(squares > 0, shares.sum(axis=0) ** 2 / np.where(squares > 0, squares, 1.0), len(parts))
    grown = np.diagonal(inverse[1:], axis1=1, axis2=2) / np.diag(inverse[0]) - 1
    excess = (1 - 1 / len(parts)) * grown.sum(axis=0)
    return counts, np.where((grown < MOST_GROWN).all(axis=0) & (excess > 0), excess, 1.0)
