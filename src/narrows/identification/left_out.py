"""Leave each distinct motion out in turn, its repeats with it: predictions of its forces, and its influence."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.identification.estimates import HALF, CoefficientEstimates, ForcePosterior
from narrows.identification.least_squares import Solution
from narrows.identification.mixed_model import one_thread
from narrows.identification.motions import DistinctMotions
from narrows.quantities.names import FORCES

# Lower bound of 1 - leverage: rounding can make it negative where one motion alone determines a coefficient.
ROUNDING = 1e-9
# Share of the information on a coefficient above which one motion alone determines it.
ALONE = 0.999


@dataclass(frozen=True)
class Predictiveness:
    """Prediction error of a model on left-out motions, for one force."""

    force: str
    held: float  # share of directions inside their 95 % predictive interval
    half: float  # median half width [N, N m]
    relative: float  # median half width over the motion's own force
    motions: int

    @property
    def sentence(self) -> str:
        """One sentence of the result."""
        return (
            f"{self.force} of {self.motions} motions left out in turn: {self.held:.0%} lie within the 95 % predictive "
            f"interval, whose median half width is {self.half:.2g} {FORCES[self.force].unit} ({self.relative:.0%} of "
            "the force)."
        )


@one_thread
def predictiveness(part: ForcePosterior) -> list[Predictiveness]:
    """Predict each motion by the others, at the scales that all motions together show."""
    rows, weights = part.rows, part.posterior.weights
    # In the independent directions of a motion's rows: measured less predicted over its standard error; then half
    # widths of the predictive interval and the measured force, as root mean squares over the motion.
    forces = rows.blocks.forces
    scores: dict[str, list[np.ndarray]] = {force: [] for force in forces}
    sizes: dict[str, list[tuple[float, float]]] = {force: [] for force in forces}
    for _, own, mean_rows in _motions(part):
        without = [without_rows(part, i, own) for i in range(len(part.posterior.parts))]
        chosen = own[mean_rows]
        means = np.stack([mean for mean, _, _ in without])[:, mean_rows]
        spreads = np.stack([np.diag(covariance) for _, covariance, _ in without])[:, mean_rows]
        mean = weights @ means
        variances = weights @ (spreads + (means - mean) ** 2)
        measured, length = rows.y[chosen], rows.length[chosen % rows.each]
        for f, force in enumerate(forces):
            at = chosen // rows.each == f
            scores[force].append((measured - mean)[at] / np.sqrt(variances[at]))
            half = HALF * np.sqrt((variances[at] / length[at] ** 2).sum())
            sizes[force].append((float(half), float(np.sqrt(((measured[at] / length[at]) ** 2).sum()))))
    result = []
    for force in forces:
        halves, levels = np.transpose(sizes[force])
        held = float((np.abs(np.concatenate(scores[force])) < HALF).mean())
        relative = float(np.median(halves / np.maximum(levels, 1e-300)))
        result.append(Predictiveness(force, held, float(np.median(halves)), relative, len(halves)))
    return result


@dataclass(frozen=True)
class Influence:
    """Influence of each distinct motion on each coefficient: the jackknife."""

    tests: tuple[str, ...]  # The motions, each called by its first test and the number of its repeats
    names: tuple[str, ...]  # The coefficients
    # (tests, n) Share of the information on a coefficient that is gone without the test: 1 less the ratio of the
    # variance with all tests to the variance without this one [1]
    information: np.ndarray
    # (tests, n) Change of the constrained estimate by the test, in the coefficient's unit; NaN where the other tests
    # hardly excite the coefficient
    moved: np.ndarray

    def most_informing(self, name: str) -> tuple[str, float]:
        """Return the test that holds most of the information on a coefficient, and its share [1]."""
        return self._most(self.information, name)

    def most_moving(self, name: str) -> tuple[str, float]:
        """Return the test that moves a coefficient most, and how far; NaN: it is not determined without it."""
        return self._most(self.moved, name)

    def of(self, name: str) -> dict[str, str | float]:
        """Give the test with most information on a coefficient and the one that moves it most."""
        (informing, share), (moving, by) = self.most_informing(name), self.most_moving(name)
        return {"most_informing": informing, "share": share, "most_moving": moving, "moved_by": by}

    def _most(self, values: np.ndarray, name: str) -> tuple[str, float]:
        if name not in self.names:
            raise InputError(f"unknown coefficient {name!r}{did_you_mean(name, self.names)}")
        column = values[:, self.names.index(name)]
        most = int(np.abs(column).argmax())
        return self.tests[most], float(column[most])


@one_thread
def influence(motions: DistinctMotions, found: CoefficientEstimates, solution: Solution) -> Influence:
    """Leave out each distinct motion in turn."""
    problem = found.problem
    gone = np.zeros((len(motions), len(problem.scale)))
    for part in found.forces:
        best, p = int(part.posterior.weights.argmax()), len(part.free_parameters)
        variances = np.diag(part.posterior.parts[best].covariance)[:p]
        for motion, own, _ in _motions(part):
            added = without_rows(part, best, own)[2][:p]
            gone[motion, part.free_parameters] = added / np.maximum(variances + added, 1e-300)
    shares = gone[:, [problem.slot[name] for name in problem.terms.names]]
    moved = np.where(shares < ALONE, problem.coefficients(solution.z) - problem.fits(motions.without), np.nan)
    return Influence(motions.labels, problem.terms.names, shares, moved)


def _motions(part: ForcePosterior) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Each motion, its rows, and which of these are of its mean."""
    rows = part.rows
    of_motion = rows.all(rows.blocks.motion[rows.blocks.block])
    is_mean = rows.all(rows.blocks.is_mean[rows.blocks.block])
    for motion in np.unique(rows.blocks.motion):
        own = np.flatnonzero(of_motion == motion)
        yield int(motion), own, np.flatnonzero(is_mean[own])


def without_rows(part: ForcePosterior, draw: int, own: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Predict some rows from all others at given scales: mean, covariance with errors, and what the rows add.

    The last is the variance of coefficients and effects beyond that with the rows, (p + q,).
    """
    # Update of a precision: with errors V and leverage H the residual is V (V - H)^-1 e.
    posterior, model = part.posterior, part.posterior.model
    conditional, x = posterior.parts[draw], model.x[own]
    lower = np.linalg.cholesky(model.covariance_of(posterior.points[draw], own))
    scaled = np.linalg.solve(lower, x)
    known = conditional.covariance @ scaled.T
    values, vectors = np.linalg.eigh(scaled @ known)
    left = np.maximum(1 - values, ROUNDING)  # Without information from other rows only the prior remains
    error = vectors.T @ np.linalg.solve(lower, model.y[own] - x @ conditional.mean)
    back = lower @ vectors
    added = ((known @ vectors) ** 2 / left).sum(axis=1)
    return model.y[own] - back @ (error / left), (back / left) @ back.T, added
