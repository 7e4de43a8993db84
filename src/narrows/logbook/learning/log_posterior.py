"""What is known of all coefficients after a log: normal, by the information of the records and the prior."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from narrows.logbook.shooting.log_problem import CoefficientPrior
from narrows.logbook.shooting.search_state import Found
from narrows.model.model import Model

# Of a variance before, by which a log is to move a combination at least where it tells something.
TOLD = 1e-3
# Standard deviation of the share of how wide windows are left that moves the coefficients as it should: pilots see
# more than a poor sensor does, and what they steer tells it. It errs alike in every record.
OF_WIDTH = 0.5
# Share of a variance.
MOSTLY = 0.5


@dataclass(frozen=True)
class LogPosterior:
    """Coefficients after a log."""

    values: np.ndarray  # (n,) All of them, in the order of the table
    covariance: np.ndarray  # (n, n) Of them
    # (p, p) Covariance of those that were solved for, in units of their standard deviations before [1]
    scaled: np.ndarray
    disagreement: float  # Square of how far the log moved them, over what was to be expected of it [1]
    freedom: int  # How many combinations of them the log tells
    widened: float  # Factor of standard errors for what the model gets wrong [1]
    alike: np.ndarray  # (p,) Share of each variance that errs alike in every record [1]

    @property
    def probability(self) -> float:
        """Of at least such a disagreement where log and prior speak of one ship."""
        from scipy.stats import chi2

        return float(chi2.sf(self.disagreement, max(self.freedom, 1)))


def log_posterior(
    model: Model, before: np.ndarray, prior: CoefficientPrior, found: Found, gust_doubt: np.ndarray
) -> LogPosterior:
    """Return what is known after a log (Bayes; of coefficients that were held, that they may be wrong)."""
    # before (n, n); gust_doubt (p, k)
    # Birge (1932), The calculation of errors by the method of least squares, Phys. Rev. 40, for the factor by which
    # errors are wider where a sum of squares is larger than expected.
    disagreement, freedom = _disagreement(prior, found.information, found.scaled)
    widened = float(np.sqrt(max(1.0, disagreement / max(freedom, 1))))
    scaled = scaled_covariance(prior, found.information / widened**2) + gust_doubt @ gust_doubt.T
    doubt = OF_WIDTH * (scaled * prior.moves) @ (found.slope * prior.moves)
    left = np.sqrt(np.maximum(np.diag(np.linalg.inv(prior.precision)) - np.diag(scaled), 0.0))
    doubt = np.clip(doubt, -left, left)  # Who has a log knows no less than who has none.
    scaled = scaled + np.outer(doubt, doubt)
    alike = doubt**2 / np.diag(scaled)
    shift, known = prior.scale * found.scaled, scaled * np.outer(prior.scale, prior.scale)
    weights = _weights(model, before, prior)
    places = [model.terms.names.index(name) for name in prior.names]
    covariance = before + weights @ (known - before[np.ix_(places, places)]) @ weights.T
    values = np.array([model.coefficients[name] for name in model.terms.names]) + weights @ shift
    return LogPosterior(values, (covariance + covariance.T) / 2, scaled, disagreement, freedom, widened, alike)


def said_alike(names: Iterable[str], shares: Iterable[float]) -> tuple[str, ...]:
    """Return what is said where more records of the kind would teach little more."""
    stuck = [name for name, share in zip(names, shares, strict=True) if share > MOSTLY]
    if not stuck:
        return ()
    return (
        f"Most of what is left unknown of {', '.join(stuck)} errs alike in every record by these sensors: more of them "
        "will sharpen it little, better sensors would.",
    )


def scaled_covariance(prior: CoefficientPrior, information: np.ndarray) -> np.ndarray:
    """Return the covariance in units of the standard deviations before, (p, p)."""
    # information (p, p)
    moves, held = prior.moves, ~prior.moves
    whole = information + prior.precision
    free = np.linalg.inv(whole[np.ix_(moves, moves)])
    correlation = np.linalg.inv(prior.precision)
    pulled = -free @ whole[np.ix_(moves, held)] @ correlation[np.ix_(held, held)]
    covariance = correlation.copy()
    covariance[np.ix_(moves, held)], covariance[np.ix_(held, moves)] = pulled, pulled.T
    covariance[np.ix_(moves, moves)] = free - pulled @ whole[np.ix_(held, moves)] @ free
    return (covariance + covariance.T) / 2


def _weights(model: Model, before: np.ndarray, prior: CoefficientPrior) -> np.ndarray:
    """How every coefficient goes with those that were solved for: ties, and what the prior says of the others."""
    names = model.terms.names
    places = [names.index(name) for name in prior.names]
    across = before[:, places] / prior.scale @ prior.precision / prior.scale
    for place, group in enumerate(prior.groups):
        for name in group:
            across[names.index(name)] = np.eye(len(places))[place]
    return np.asarray(across)


def _disagreement(prior: CoefficientPrior, information: np.ndarray, moved: np.ndarray) -> tuple[float, int]:
    """Squares of how far the log moved combinations, over how far it was to move them, those that are held in doubt."""
    moves = prior.moves
    told = information[moves]
    gain = np.linalg.inv((information + prior.precision)[np.ix_(moves, moves)])
    expected = gain @ (told[:, moves] + told @ np.linalg.inv(prior.precision) @ told.T) @ gain
    sizes, axes = np.linalg.eigh(expected)
    counted = sizes > TOLD
    return float(np.sum((axes.T @ moved[moves])[counted] ** 2 / sizes[counted])), int(counted.sum())
