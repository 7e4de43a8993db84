"""Mean and covariance of the posterior after a log, by importance sampling about its mode.

Motion determines forces over inertia. In these the likelihood is nearly quadratic, in forces and inertias it is not:
under a wide prior the mode lies below the mean in all of them.

References
----------
Geweke (1989), Bayesian inference in econometric models using Monte Carlo integration.
Owen, Zhou (2000), Safe and effective importance sampling: fixed points of low discrepancy.
"""

import numpy as np

from narrows.logbook.filtering.log_problem import LogProblem
from narrows.logbook.filtering.search import SearchResult
from narrows.logbook.learning.log_posterior import posterior_covariance
from narrows.terms.term import TermKind

POINTS, SEED = 4096, 26
WIDER = 1.1  # proposal over the Gaussian at the mode, for its tails


def posterior_mean(found: SearchResult) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean (P,) and the covariance (P, P) of all unknowns; at the mode where inertia is known."""
    from scipy import special, stats

    problem, mode, information = found.problem, found.unknowns, found.information
    covariance = posterior_covariance(problem, information)
    if not problem.inertia[:, 1:].any():
        return mode, covariance
    sobol = stats.qmc.Sobol(len(mode), seed=SEED).random(POINTS)
    normal = WIDER * special.ndtri(np.clip(sobol, 1e-9, 1 - 1e-9))
    drawn = mode + normal @ np.linalg.cholesky(covariance).T
    lighter = _inertia(problem, mode) / _inertia(problem, drawn)
    off = np.linalg.solve(_slopes(problem, mode), (_over_inertia(problem, drawn, mode, lighter) - mode).T).T
    prior = np.einsum("ij,jk,ik->i", drawn, problem.precision, drawn)
    likelihood = 2.0 * off @ found.score - np.einsum("ij,jk,ik->i", off, information, off)
    logarithm = (likelihood - prior + (normal**2).sum(axis=1) / WIDER**2) / 2.0
    logarithm[(lighter <= 0.0).any(axis=1)] = -np.inf
    weights = np.exp(logarithm - logarithm.max())
    weights /= weights.sum()
    mean = weights @ drawn
    deviation = drawn - mean
    mean[: problem.count] = np.clip(mean[: problem.count], *problem.prior.limits)
    return mean, deviation.T @ (weights[:, None] * deviation)


def _inertia(problem: LogProblem, unknowns: np.ndarray) -> np.ndarray:
    """Inertia in surge, sway and yaw, (..., 3)."""
    values = problem.prior.mean + problem.prior.scale * unknowns[..., : problem.count]
    return np.asarray(problem.inertia[:, 0] + values @ problem.inertia[:, 1:].T)


def _over_inertia(problem: LogProblem, unknowns: np.ndarray, mode: np.ndarray, lighter: np.ndarray) -> np.ndarray:
    """Unknowns with forces over inertia and one over inertia in place of both, which agree with them at the mode."""
    # Accelerations are linear in these.
    found, (places, axes), prior = unknowns.copy(), _axes(problem), problem.prior
    centre = (prior.mean / prior.scale)[places]
    found[..., places] = (centre + unknowns[..., places]) * lighter[..., axes] - centre
    axes, places = np.nonzero(problem.inertia[:, 1:])
    found[..., places] = mode[places] + (unknowns - mode)[..., places] * lighter[..., axes]
    return found


def _slopes(problem: LogProblem, mode: np.ndarray) -> np.ndarray:
    """Derivatives of ``_over_inertia`` at the mode, (P, P)."""
    prior, count, (places, axes) = problem.prior, problem.count, _axes(problem)
    slopes = np.eye(len(mode))
    by = problem.inertia[:, 1:] * prior.scale / _inertia(problem, mode)[:, None]
    slopes[places, :count] -= ((prior.mean / prior.scale)[places] + mode[places])[:, None] * by[axes]
    return slopes


def _axes(problem: LogProblem) -> tuple[np.ndarray, np.ndarray]:
    """Places of the coefficients of forces that one axis of motion alone takes, and these axes."""
    axes = {
        term.name: axis
        for axis, terms in enumerate(problem.motion.model.terms.forces.values())
        for term in terms
        if term.kind != TermKind.INERTIA
    }
    names = problem.prior.names
    places = [k for k, name in enumerate(names) if name in axes and not problem.inertia[:, 1 + k].any()]
    return np.array(places, int), np.array([axes[names[k]] for k in places], int)
