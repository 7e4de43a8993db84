"""Predict each motion from the others, and measure the information that the others hold."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from narrows.identification.estimates import HALF, ForcePosterior
from narrows.identification.mixed_model import RIDGE, Conditional
from narrows.identification.motions import DistinctMotions
from narrows.identification.threads import one_thread

# Draws of the scales that predictions average over: those of most weight.
MOST_DRAWS = 8
# Least eigenvalue of a precision of unit diagonal: what one motion alone informs can cancel to less than nothing.
ROUNDING = 1e-10


@dataclass(frozen=True)
class LeftOutMotion:
    """Forces of one motion predicted by the others, in a few independent directions of its rows."""

    motion: int
    force: str
    level: float  # root mean square of the measured force
    error: float  # root mean square of measured less predicted
    half: float  # half width of the 95 % predictive interval, root mean square over the directions
    scores: np.ndarray  # (directions,) measured less predicted, in predictive standard errors


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
        unit = "N m" if self.force == "N" else "N"
        return (
            f"{self.force} of {self.motions} motions left out in turn: {self.held:.0%} lie within the 95 % predictive "
            f"interval, whose median half width is {self.half:.2g} {unit} ({self.relative:.0%} of the force)."
        )


def predictiveness(left_out: list[LeftOutMotion]) -> tuple[Predictiveness, ...]:
    """Summarise left-out motions by force."""
    result = []
    for force in dict.fromkeys(one.force for one in left_out):
        own = [one for one in left_out if one.force == force]
        scores = np.concatenate([one.scores for one in own])
        relative = np.median([one.half / max(one.level, 1e-300) for one in own])
        half = float(np.median([one.half for one in own]))
        result.append(Predictiveness(force, float((np.abs(scores) < HALF).mean()), half, float(relative), len(own)))
    return tuple(result)


@one_thread
def left_out_motions(part: ForcePosterior) -> list[LeftOutMotion]:
    """Predict each motion by the others, at the scales that all motions together show."""
    rows, blocks = part.rows, part.rows.blocks
    result = []
    for motion, chosen, predicted in _without_each(part):
        mean = np.sum([weight * mean for weight, mean, _, _ in predicted], axis=0)
        spread = np.sum([weight * (v + np.outer(m - mean, m - mean)) for weight, m, v, _ in predicted], axis=0)
        for f, force in enumerate(blocks.forces):
            own = (chosen // rows.each) == f
            error, variance = rows.y[chosen][own] - mean[own], np.diag(spread)[own]
            root = rows.length[chosen[own] % rows.each]
            level = float(np.sqrt(((rows.y[chosen][own] / root) ** 2).sum()))
            half = float(HALF * np.sqrt((variance / root**2).sum()))
            size = float(np.sqrt(((error / root) ** 2).sum()))
            result.append(LeftOutMotion(motion, force, level, size, half, error / np.sqrt(variance)))
    return result


@one_thread
def information_gone(part: ForcePosterior, motions: DistinctMotions) -> np.ndarray:
    """Share of what is known of each coefficient that is gone without each motion, (motions, p)."""
    gone = np.zeros((len(motions), len(part.slots)))
    p = len(part.slots)
    for motion, _, predicted in _without_each(part, draws=1):
        whole, without = predicted[0][3]
        gone[motion] = 1 - np.diag(whole)[:p] / np.maximum(np.diag(without)[:p], 1e-300)
    return np.clip(gone, 0.0, 1.0)


Predicted = tuple[float, np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]


def _without_each(part: ForcePosterior, draws: int = MOST_DRAWS) -> Iterator[tuple[int, np.ndarray, list[Predicted]]]:
    """Each motion, its rows of the mean, and at some scales: weight, prediction, its covariance, what is known."""
    rows, posterior = part.rows, part.posterior
    best = np.argsort(-posterior.weights, kind="stable")[:draws]
    weights = posterior.weights[best] / posterior.weights[best].sum()
    of_motion = rows.all(rows.blocks.motion[rows.blocks.block])
    is_mean = rows.all(rows.blocks.is_mean[rows.blocks.block])
    precisions = [np.linalg.inv(posterior.parts[i].covariance) for i in best]
    for motion in np.unique(rows.blocks.motion):
        own, mean = np.flatnonzero(of_motion == motion), np.flatnonzero((of_motion == motion) & is_mean)
        chosen = np.searchsorted(own, mean)
        predicted = [
            (float(w), *without_rows(part, posterior.parts[i], precision, posterior.points[i], own, chosen))
            for i, w, precision in zip(best, weights, precisions, strict=True)
        ]
        yield int(motion), mean, predicted


def without_rows(
    part: ForcePosterior, conditional: Conditional, precision: np.ndarray, z: np.ndarray, own: np.ndarray,
    chosen: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:  # fmt: skip
    """Prediction of a motion's rows without it, the covariance of that, and covariances with and without it."""
    model = part.posterior.model
    errors = model.covariance_of(z, own)
    x = model.x[own]
    weighted = np.linalg.solve(errors, x)
    less = precision - x.T @ weighted
    # A coefficient in no other motion keeps only its prior, which rounding may remove.
    np.fill_diagonal(less, np.maximum(np.diag(less), RIDGE))
    unit = 1 / np.sqrt(np.diag(less))
    values, vectors = np.linalg.eigh(less * np.outer(unit, unit))
    without = (vectors / np.maximum(values, ROUNDING)) @ vectors.T * np.outer(unit, unit)
    mean = without @ (precision @ conditional.mean - weighted.T @ model.y[own])
    seen = x[chosen]
    spread = seen @ without @ seen.T + errors[np.ix_(chosen, chosen)]
    return seen @ mean, spread, (conditional.covariance, without)
