"""Posterior of all coefficients after a log: its mean, and standard errors by the scatter of records."""

from dataclasses import dataclass, replace

import numpy as np

from narrows.logbook.filtering.log_problem import CoefficientPrior, LogProblem, Unknowns
from narrows.logbook.filtering.search import SearchResult
from narrows.model.model import Model
from narrows.terms.term import TermKind

LEAST_REDUCTION = 1e-3  # [1] of the prior variance: below it a log does not count as informative on a combination
EXPECTED_SCATTER = 10  # records that the expected scatter of scores counts for, against that of the records
POINTS, SEED = 4096, 26  # of importance sampling
WIDER = 1.1  # proposal over the Gaussian at the mode, for its tails


@dataclass(frozen=True)
class LogPosterior:
    """Coefficients after a log."""

    values: np.ndarray  # (n,) All of them, in the order of the table
    covariance: np.ndarray  # (n, n)
    scaled: np.ndarray  # (p, p) Covariance of the estimated ones, in units of their prior standard deviations [1]
    disagreement: float  # Square of how far the log moved them, over what was expected of it [1]
    freedom: int  # How many combinations of them the log determines

    @property
    def probability(self) -> float:
        """Probability of at least such a disagreement where log and prior are of one ship."""
        from scipy.stats import chi2

        return float(chi2.sf(self.disagreement, max(self.freedom, 1)))


def log_posterior(
    model: Model, before: np.ndarray, problem: Unknowns, unknowns: np.ndarray, information: np.ndarray,
    scores: np.ndarray | None = None, moments: tuple[np.ndarray, np.ndarray] | None = None,
) -> LogPosterior:  # fmt: skip
    """Return the posterior by the covariance before (n, n), the information (P, P), and scores of records (N, P).

    It has the unknowns (P,) as its mean and the covariance of prior and information unless moments (P,), (P, P) are
    given.
    """
    prior, count = problem.prior, problem.count
    mean, covariance = moments or (unknowns, posterior_covariance(problem, information))
    if scores is not None and len(scores) > 1:
        covariance = sandwich(covariance, information, scores)
    weights = regression_on_estimated(model, before, prior)
    places = [model.terms.names.index(name) for name in prior.names]
    known = covariance[:count, :count] * np.outer(prior.scale, prior.scale)
    after = before + weights @ (known - before[np.ix_(places, places)]) @ weights.T
    moved = weights @ (prior.scale * mean[:count])
    if not prior.free.all():
        # Schmidt's (1966) Kalman update: held coefficients keep mean and covariance, and their errors count in those of
        # the free ones, which are as in the joint fit; Bierman (1977), Factorization Methods, chapter 8.
        held = np.flatnonzero([name not in prior.free_names for name in model.terms.names])
        moved[held] = 0.0
        after[np.ix_(held, held)] = before[np.ix_(held, held)]
    values = moved + [model.coefficients[name] for name in model.terms.names]
    disagreement = _disagreement(problem, information, unknowns[:count])
    return LogPosterior(values, (after + after.T) / 2, covariance[:count, :count], *disagreement)


def averaged(one: LogPosterior, other: LogPosterior) -> LogPosterior:
    """Return the posterior of two models that are equally likely: their difference is part of the covariance."""
    # Hoeting, Madigan, Raftery and Volinsky (1999), Bayesian model averaging: a tutorial, Statistical Science 14.
    # Log and prior contradict each other only if they do in both.
    apart = (one.values - other.values) / 2
    covariance = (one.covariance + other.covariance) / 2 + np.outer(apart, apart)
    agreeing = max(one, other, key=lambda each: each.probability)
    return replace(agreeing, values=one.values - apart, covariance=covariance)


def expected_std(model: Model, before: np.ndarray, problem: Unknowns, information: np.ndarray) -> dict[str, float]:
    """Return the standard error of every coefficient that this information (P, P) leaves."""
    after = log_posterior(model, before, problem, np.zeros(len(information)), information)
    return dict(zip(model.terms.names, np.sqrt(np.diag(after.covariance)).tolist(), strict=True))


def sandwich(covariance: np.ndarray, information: np.ndarray, scores: np.ndarray) -> np.ndarray:
    """Return the covariance of all unknowns, wider where the scores of records scatter more than expected, (P, P)."""
    # White (1982), Econometrica 50, for the sandwich; Kauermann and Carroll (2001), J. Am. Stat. Assoc. 96, on its
    # small samples: below some ten records the expected scatter has the larger weight.
    count = len(scores)
    centred = scores - scores.mean(axis=0)
    scatter = centred.T @ centred * count / (count - 1)
    root = np.linalg.cholesky(covariance + 1e-12 * np.eye(len(covariance)))
    excess = root.T @ (scatter - information) @ root
    sizes, axes = np.linalg.eigh(count / (count + EXPECTED_SCATTER) * (excess + excess.T) / 2)
    wider = (axes * np.maximum(sizes, 0.0)) @ axes.T
    return np.asarray(covariance + root @ wider @ root.T)


def posterior_covariance(problem: Unknowns, information: np.ndarray) -> np.ndarray:
    """Return the covariance of all unknowns by information (P, P) and prior."""
    covariance = np.linalg.inv(information + problem.precision)
    return np.asarray((covariance + covariance.T) / 2)


def regression_on_estimated(model: Model, before: np.ndarray, prior: CoefficientPrior) -> np.ndarray:
    """Return the regression of every coefficient on the estimated ones: ties, and correlations of the prior."""
    names = model.terms.names
    places = [names.index(name) for name in prior.names]
    across = before[:, places] / prior.scale @ prior.precision / prior.scale
    for place, group in enumerate(prior.groups):
        for name in group:
            across[names.index(name)] = np.eye(len(places))[place]
    return np.asarray(across)


def _disagreement(problem: Unknowns, whole: np.ndarray, moved: np.ndarray) -> tuple[float, int]:
    """Squares of how far the log moved combinations, over how far it was to move them."""
    count = problem.count
    nuisance = np.linalg.solve((whole + problem.precision)[count:, count:], whole[count:, :count])
    information = whole[:count, :count] - whole[:count, count:] @ nuisance
    precision = problem.prior.precision
    sizes, axes = np.linalg.eigh(np.linalg.inv(precision) - np.linalg.inv(information + precision))
    counted = sizes > LEAST_REDUCTION
    return float(np.sum((axes.T @ moved)[counted] ** 2 / sizes[counted])), int(counted.sum())


def posterior_mean(found: SearchResult) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean (P,) and the covariance (P, P) of all unknowns; at the mode where inertia is known."""
    # By importance sampling about the mode: Geweke (1989), Bayesian inference in econometric models using Monte Carlo
    # integration; Owen, Zhou (2000), Safe and effective importance sampling: fixed points of low discrepancy. Motion
    # determines forces over inertia. In these the likelihood is nearly quadratic, in forces and inertias it is not:
    # under a wide prior the mode lies below the mean in all of them.
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
