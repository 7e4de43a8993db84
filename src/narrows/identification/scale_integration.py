"""Integration over the scales of a mixed model: importance sampling from Laplace approximations.

About each mode the proposal is a split normal density: an axis has one width below the mode and another above. Points
are a fixed Sobol sequence, so that the answer is a smooth function of the data.

References
----------
Geweke (1989), Bayesian inference in econometric models using Monte Carlo integration: split normal densities.
Raftery, Bao (2010), Estimating and projecting trends in HIV/AIDS generalized epidemics using incremental mixture
importance sampling: a mode is added where one point outweighs the others.
Ionides (2008), Truncated importance sampling: the weights.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from narrows.identification.mixed_model import Conditional, MixedModel

LOWEST, HIGHEST = -4.0, 6.0  # Range of the coordinates of scales, which are standard normal a priori
POINTS, SEED = 128, 26
SMALL, LARGE = -0.5, 3.0  # Starting coordinates of the search for a mode, and for a rival mode
LEAST_CURVATURE = 0.5  # Least curvature of the log density at a mode; 1 if the data do not determine a scale
STEP = 0.1  # Step of the finite differences for the curvature
REACH = 2.0  # Distance at which widths are measured [standard deviations]
NARROW, WIDE = 0.5, 2.0  # Limits of the widths over those from the curvature
APART, LESS_LIKELY = 1.0, 8.0  # Least distance of two modes, and largest difference of their log densities
LEAST_SHARE = 0.2  # Least share of the points for each mode
HEAVY = 0.15  # Weight of a point from which another mode is searched for
MOST_MODES = 5


@dataclass(frozen=True)
class SplitNormal:
    """A density about a mode in the coordinates that are learned."""

    mode: np.ndarray  # (d,)
    root: np.ndarray  # (d, d) symmetric, of the inverse curvature
    widths: np.ndarray  # (2, d) below and above the mode
    top: float  # Log density of the posterior at the mode

    def points(self, count: int) -> np.ndarray:
        """Fixed points of low discrepancy, (count, d)."""
        from scipy import special, stats

        below, above = self.widths
        sobol = stats.qmc.Sobol(len(self.mode), seed=SEED).random(count)
        u, total = np.clip(sobol, 1e-9, 1 - 1e-9), below + above
        half = np.where(u * total < below, u * total / (2 * below), 1 - (1 - u) * total / (2 * above))
        return np.asarray(self.mode + np.where(half < 0.5, below, above) * special.ndtri(half) @ self.root)

    def log_density(self, at: np.ndarray) -> np.ndarray:
        """Up to a constant that all modes share."""
        x = np.linalg.solve(self.root, (at - self.mode).T).T
        return np.asarray(-0.5 * ((x / np.where(x < 0, *self.widths)) ** 2).sum(axis=1) - self.log_volume)

    @property
    def log_volume(self) -> float:
        return float(np.linalg.slogdet(self.root)[1] + np.log(self.widths.mean(axis=0)).sum())


def integrate(model: MixedModel, points: int = POINTS) -> "ScaleMixture":
    """Weigh points about every mode of the scales by the posterior over the proposal."""
    if not model.learned.size:
        nothing = np.zeros(len(model.prior))
        return ScaleMixture(model, nothing, nothing[None], np.ones(1), [model.at(nothing)])
    modes, densities = search(model), list[SplitNormal]()
    known: dict[bytes, Conditional] = {}  # A longer Sobol sequence begins with the points of the shorter one
    while True:
        densities += [_fitted(model, mode) for mode, _ in modes[len(densities) :]]
        mixture, weight = _weighed(model, densities, points, known)
        heaviest = int(weight.argmax())
        if weight[heaviest] < HEAVY or len(modes) == MOST_MODES:
            return mixture
        more = _distinct([*modes, _climb(model, mixture.points[heaviest])])
        if len(more) == len(modes):
            return mixture
        modes = more


def _weighed(
    model: MixedModel, densities: list[SplitNormal], points: int, known: dict[bytes, Conditional]
) -> tuple["ScaleMixture", np.ndarray]:
    """The mixture, whose weights are truncated, and the weights before that."""
    sizes = np.array([one.top + one.log_volume for one in densities])
    share = np.exp(sizes - sizes.max())
    share = np.maximum(share / share.sum(), LEAST_SHARE)
    # Powers of two, for which the points of a Sobol sequence are balanced.
    counts = 2 ** np.ceil(np.log2(points * share / share.sum())).astype(int)
    drawn = np.vstack([one.points(count) for one, count in zip(densities, counts, strict=True)])
    logs = [np.log(count) + one.log_density(drawn) for one, count in zip(densities, counts, strict=True)]
    whole = np.zeros((len(drawn), len(model.prior)))
    whole[:, model.learned] = np.clip(drawn, LOWEST, HIGHEST)
    known |= {z.tobytes(): model.at(z) for z in whole if z.tobytes() not in known}
    parts = [known[z.tobytes()] for z in whole]
    log_weight = np.array([one.log_density for one in parts]) - np.logaddexp.reduce(logs)
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    truncated = np.minimum(weight, np.sqrt(points) / len(weight))
    mode = np.zeros(len(model.prior))
    mode[model.learned] = densities[int(sizes.argmax())].mode
    return ScaleMixture(model, mode, whole, truncated / truncated.sum(), parts), weight


def search(model: MixedModel) -> list[tuple[np.ndarray, float]]:
    """Modes of the scales and their log densities, from small effects and from each rival explanation."""
    small = np.where(model.prior > 0, SMALL, 0.0)
    starts = [small, *(np.where(np.arange(len(small)) == scale, LARGE, small) for scale in model.rivals)]
    return _distinct(sorted((_climb(model, start) for start in starts), key=lambda one: -one[1]))


def _climb(model: MixedModel, start: np.ndarray) -> tuple[np.ndarray, float]:
    from scipy import optimize

    minimize: Any = optimize.minimize

    def descend(z: np.ndarray) -> tuple[float, np.ndarray]:
        at = model.at(z, gradient=True)
        return -at.log_density, -at.gradient

    bounds = [(LOWEST, HIGHEST) if prior > 0 else (0.0, 0.0) for prior in model.prior]
    options = {"maxiter": 100, "ftol": 1e-4}
    found = minimize(descend, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(found.x), -float(found.fun)


def _distinct(found: list[tuple[np.ndarray, float]]) -> list[tuple[np.ndarray, float]]:
    """Modes that are no neighbours of an earlier one, and not much less likely than the first."""
    modes: list[tuple[np.ndarray, float]] = []
    for at, value in found:
        near = any(np.abs(at - mode).max() < APART for mode, _ in modes)
        if not near and value > found[0][1] - LESS_LIKELY:
            modes.append((at, value))
    return modes


def _fitted(model: MixedModel, mode: np.ndarray) -> SplitNormal:
    """Split normal density: the curvature by differences of the gradient, widths by the log density to both sides."""
    learned, mode = model.learned, mode.copy()

    def slope(z: np.ndarray) -> np.ndarray:
        return np.asarray(model.at(z, gradient=True).gradient[learned])

    here, unit = slope(mode), np.eye(len(mode))[learned]
    curvature = np.array([(here - slope(mode + STEP * e)) / STEP for e in unit])
    values, vectors = np.linalg.eigh(0.5 * (curvature + curvature.T))
    values = np.maximum(values, LEAST_CURVATURE)
    # Steps of Newton, so that the mode does not depend on when the search stopped.
    for _ in range(2):
        mode[learned] = np.clip(mode[learned] + (vectors / values) @ vectors.T @ here, LOWEST, HIGHEST)
        here = slope(mode)
    # The symmetric root: it does not change with the signs and the order that a library gives eigenvectors.
    root, top = (vectors / np.sqrt(values)) @ vectors.T, model.at(mode).log_density
    logs = [[model.at(mode + sign * REACH * axis @ unit).log_density for axis in root] for sign in (-1.0, 1.0)]
    widths = REACH / np.sqrt(2 * np.maximum(top - np.array(logs), 0.0) + 1e-12)
    return SplitNormal(mode[learned], root, np.clip(widths, NARROW, WIDE), top)


@dataclass(frozen=True)
class ScaleMixture:
    """A mixture of Gaussians, one for each point of the scales."""

    model: MixedModel
    mode: np.ndarray
    points: np.ndarray  # (draws, scales) coordinates
    weights: np.ndarray
    parts: list[Conditional]

    @cached_property
    def _combined(self) -> np.ndarray:
        """Coefficients of the best-fitting terms by coefficients and effects, (p, p + q)."""
        p, taken = self.model.fixed, self.model.taken
        return np.hstack([np.eye(p), np.zeros((p, len(self.model.group))) if taken is None else taken])

    @cached_property
    def means(self) -> np.ndarray:
        """Coefficients of each draw, (draws, p)."""
        return np.asarray(np.stack([part.mean for part in self.parts]) @ self._combined.T)

    @cached_property
    def covariances(self) -> np.ndarray:
        """Covariance of each draw, (draws, p, p)."""
        return np.stack([self._combined @ part.covariance @ self._combined.T for part in self.parts])

    @cached_property
    def shifts(self) -> np.ndarray:
        """Change of each coefficient for a change of an effect by one, the effect being given: (p, q)."""
        # Regression of coefficients on effects: data that contradict an effect of that size do not reduce the change,
        # since other effects may have absorbed it.
        p = self.model.fixed
        slopes = [(self._combined @ part.covariance[:, p:]) / np.diag(part.covariance)[p:] for part in self.parts]
        return np.asarray(np.tensordot(self.weights, slopes, 1))
