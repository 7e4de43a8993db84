"""Standard errors that know that the rows of one test are not independent: the cluster jackknife."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.errors import InputError
from narrows.identification.regression.normal_equations import NormalEquations

MIN_TESTS = 10
"""With fewer tests than this, stretches of each test are the clusters."""
PIECES, FEWEST_PIECES = 30, 3
"""How many stretches to cut tests into, at least: together, and each."""


@dataclass(frozen=True)
class Clusters:
    """Rows that may depend on one another, put together.

    Parameters
    ----------
    sums : array (clusters, m, m)
        Sums over each cluster.
    labels : tuple of str
        What each is called.
    by_test : bool
        Whether a cluster is a test.
    """

    sums: np.ndarray
    labels: tuple[str, ...]
    by_test: bool

    @cached_property
    def without(self) -> np.ndarray:
        """Sums over all but each cluster, (clusters, m, m): added up and not taken away, so that nothing cancels."""
        sums = np.zeros_like(self.sums)
        sums[1:] += np.cumsum(self.sums[:-1], axis=0)
        sums[:-1] += np.cumsum(self.sums[:0:-1], axis=0)[::-1]
        return sums

    @property
    def sentence(self) -> str:
        """What was clustered, in words."""
        if self.by_test:
            return f"Standard errors are clustered by test ({len(self.labels)} tests)."
        tests = len({label.rpartition("/")[0] for label in self.labels})
        return (
            f"{tests} tests are too few to cluster by test: standard errors are clustered by "
            f"{len(self.labels)} consecutive stretches of them, and do not know errors that a whole test shares."
        )


def pieces_for(tests: int) -> int:
    """Return into how many stretches to cut each test (ours).

    Parameters
    ----------
    tests : int
        How many there are.
    """
    return max(FEWEST_PIECES, -(-PIECES // tests))


def clustered(equations: NormalEquations) -> Clusters:
    """Choose the clusters: tests where there are enough of them, stretches of tests otherwise.

    Parameters
    ----------
    equations : NormalEquations
        The sums.

    Raises
    ------
    InputError
        Where one row, or one stretch of rows, is all there is.
    """
    if len(equations.tests) < 2:
        raise InputError(f"one row of test {equations.tests[0]} is all there is; standard errors need two or more")
    enough = len(equations.names) >= MIN_TESTS or len(equations.names) == len(equations.tests)
    return by_tests(equations) if enough else by_stretches(equations)


def by_tests(equations: NormalEquations) -> Clusters:
    """Take each test as a cluster (ours).

    Parameters
    ----------
    equations : NormalEquations
        The sums.
    """
    return Clusters(equations.by_test(), equations.names, True)


def by_stretches(equations: NormalEquations) -> Clusters:
    """Take each consecutive stretch of a test as a cluster (ours).

    Parameters
    ----------
    equations : NormalEquations
        The sums.
    """
    labels = [f"{test}/{equations.tests[:i].count(test) + 1}" for i, test in enumerate(equations.tests)]
    return Clusters(equations.sums, tuple(labels), False)


def jackknife(best: np.ndarray, without: np.ndarray) -> np.ndarray:
    """Return the covariance of the coefficients, (n, n), from the fits that left one cluster out.

    (K - 1)/K times the sum of outer products of each fit's difference from the whole one: the CV3 estimator,
    which stays honest with few and unequal clusters.

    Parameters
    ----------
    best : array (n,)
        Coefficients of the whole.
    without : array (clusters, n)
        Coefficients without each cluster.

    References
    ----------
    MacKinnon, Nielsen, Webb (2023), Fast and reliable jackknife and bootstrap methods for cluster-robust inference.
    """
    moved = without - best
    count = len(without)
    return np.asarray((count - 1) / count * moved.T @ moved)
