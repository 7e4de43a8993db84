"""The constrained fit over and over: whole tests drawn anew, or each test's error given a random sign and size."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from narrows.errors import InputError
from narrows.identification.batch import solve_many
from narrows.identification.interval import LEVEL

if TYPE_CHECKING:
    from narrows.identification.problem import Problem
    from narrows.identification.uncertainty import Clusters

BOOTSTRAPS = ("scores", "tests")
CHUNK = 2048


@dataclass(frozen=True)
class Bootstrap:
    """Coefficients of many resamples, each fitted under the constraints.

    Parameters
    ----------
    names : tuple of str
        The coefficients.
    draws : array (resamples, n)
        Their values, each in its own unit.
    kind : str
        ``scores`` or ``tests``.
    """

    names: tuple[str, ...]
    draws: np.ndarray
    kind: str

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the draws, (n, n)."""
        return np.atleast_2d(np.cov(self.draws.T))

    def intervals(self, level: float = LEVEL) -> Mapping[str, tuple[float, float]]:
        """Return the shortest interval that holds a share of the draws, for each coefficient in its unit.

        The shortest one starts at a bound where many draws sit there, which is what lets it cover a coefficient at
        its bound as often as it says.

        Parameters
        ----------
        level : float [1]
            The share.
        """
        ordered = np.sort(self.draws, axis=0)
        kept = min(int(np.ceil(level * len(ordered))), len(ordered))
        widths = ordered[kept - 1 :] - ordered[: len(ordered) - kept + 1]
        first = widths.argmin(axis=0)
        columns = np.arange(len(self.names))
        ends = zip(ordered[first, columns].tolist(), ordered[first + kept - 1, columns].tolist(), strict=True)
        return dict(zip(self.names, ends, strict=True))


def resampled(problem: "Problem", clusters: "Clusters", resamples: int, kind: str, seed: int) -> Bootstrap:
    """Fit resamples of the tests under the constraints.

    ``tests`` draws as many tests as there are, with replacement, and adds up their sums. ``scores`` leaves the tests
    as they are and perturbs their forces: the pull of each test on the fit, as leaving it out shows it, is multiplied
    by a random number that the whole test shares; all of them are divided by one draw of chi over the root of its
    degrees, so that few tests widen the spread as they do in Student's t.

    Parameters
    ----------
    problem : Problem
        The joint problem.
    clusters : Clusters
        The tests.
    resamples : int
        How many.
    kind : str
        ``scores`` or ``tests``.
    seed : int
        Of the draws.

    Raises
    ------
    InputError
        Where the kind is neither, or there are fewer than 2 resamples.

    References
    ----------
    MacKinnon, Nielsen, Webb (2023), Fast and reliable jackknife and bootstrap methods for cluster-robust inference.
    """
    if kind not in BOOTSTRAPS:
        raise InputError(f"bootstrap kind {kind!r} is unknown; choose {' or '.join(BOOTSTRAPS)}")
    if resamples < 2:
        raise InputError(f"{resamples} resamples give no spread; ask for 1000 or more")
    draw = np.random.default_rng(seed)
    make = _by_tests if kind == "tests" else _by_scores
    z = make(problem, clusters, resamples, draw)
    return Bootstrap(problem.terms.names, problem.coefficients(z), kind)


def _by_tests(problem: "Problem", clusters: "Clusters", resamples: int, draw: np.random.Generator) -> np.ndarray:
    count = len(clusters.sums)
    times = draw.multinomial(count, np.full(count, 1 / count), size=resamples).astype(float)
    parts = []
    for start in range(0, resamples, CHUNK):
        sums = np.tensordot(times[start : start + CHUNK], clusters.sums, axes=1)
        parts.append(solve_many(*problem.normal(sums), problem.lower, problem.upper))
    return np.concatenate(parts)


def _by_scores(problem: "Problem", clusters: "Clusters", resamples: int, draw: np.random.Generator) -> np.ndarray:
    count, free = len(clusters.sums), np.full(len(problem.scale), np.inf)
    h, g = problem.normal(clusters.sums.sum(axis=0))
    # the pull of a test: what moves the fit without bounds from its place without the test to its place with it
    without_z = solve_many(*problem.normal(clusters.without), -free, free)
    pulls = (solve_many(h, g[None], -free, free) - without_z) @ h
    multipliers = draw.standard_normal((resamples, count)) * np.sqrt((count - 1) / count)
    multipliers /= np.sqrt(draw.chisquare(count - 1, (resamples, 1)) / (count - 1))
    return solve_many(h, g + multipliers @ pulls, problem.lower, problem.upper)
