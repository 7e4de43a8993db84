"""Predict each motion from the others, and measure the information that the others hold."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from narrows.identification.estimates import HALF, ForcePosterior
from narrows.identification.motions import DistinctMotions
from narrows.identification.threads import one_thread

# Least share of errors that leverage leaves: of what one motion alone informs it can cancel to less than nothing.
ROUNDING = 1e-9


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
    weights, result = part.posterior.weights, []
    for motion, own, mean_rows in _motions(part):
        without = [without_rows(part, i, own) for i in range(len(part.posterior.parts))]
        chosen = own[mean_rows]
        means = np.stack([one.mean for one in without])[:, mean_rows]
        spreads = np.stack([np.diag(one.covariance) for one in without])[:, mean_rows]
        mean = weights @ means
        variances = weights @ (spreads + (means - mean) ** 2)
        for f, force in enumerate(blocks.forces):
            of_force = (chosen // rows.each) == f
            error, variance = (rows.y[chosen] - mean)[of_force], variances[of_force]
            root = rows.length[chosen[of_force] % rows.each]
            level = float(np.sqrt(((rows.y[chosen][of_force] / root) ** 2).sum()))
            half = float(HALF * np.sqrt((variance / root**2).sum()))
            size = float(np.sqrt(((error / root) ** 2).sum()))
            result.append(LeftOutMotion(motion, force, level, size, half, error / np.sqrt(variance)))
    return result


@one_thread
def information_gone(part: ForcePosterior, motions: DistinctMotions) -> np.ndarray:
    """Share of what is known of each coefficient that is gone without each motion, (motions, p)."""
    gone = np.zeros((len(motions), len(part.slots)))
    best = int(part.posterior.weights.argmax())
    variances = np.diag(part.posterior.parts[best].covariance)[: len(part.slots)]
    for motion, own, _ in _motions(part):
        added = without_rows(part, best, own).added[: len(part.slots)]
        gone[motion] = added / np.maximum(variances + added, 1e-300)
    return gone


def _motions(part: ForcePosterior) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Each motion, its rows, and which of these are of its mean."""
    rows = part.rows
    of_motion = rows.all(rows.blocks.motion[rows.blocks.block])
    is_mean = rows.all(rows.blocks.is_mean[rows.blocks.block])
    for motion in np.unique(rows.blocks.motion):
        own = np.flatnonzero(of_motion == motion)
        yield int(motion), own, np.flatnonzero(is_mean[own])


@dataclass(frozen=True)
class WithoutRows:
    """Prediction of some rows from all others, at given scales."""

    mean: np.ndarray  # (rows,)
    covariance: np.ndarray  # (rows, rows), errors of the rows included
    added: np.ndarray  # (p + q,) variance of coefficients and effects beyond that with the rows


def without_rows(part: ForcePosterior, draw: int, own: np.ndarray) -> WithoutRows:
    """Leave rows out by the update of a precision: with errors V and leverage H the residual is V (V - H)^-1 e."""
    posterior, model = part.posterior, part.posterior.model
    conditional, x = posterior.parts[draw], model.x[own]
    lower = np.linalg.cholesky(model.covariance_of(posterior.points[draw], own))
    scaled = np.linalg.solve(lower, x)
    known = conditional.covariance @ scaled.T
    values, vectors = np.linalg.eigh(scaled @ known)
    left = np.maximum(1 - values, ROUNDING)  # where no other row informs a coefficient its prior is all that is left
    error = vectors.T @ np.linalg.solve(lower, model.y[own] - x @ conditional.mean)
    back = lower @ vectors
    added = ((known @ vectors) ** 2 / left).sum(axis=1)
    return WithoutRows(model.y[own] - back @ (error / left), (back / left) @ back.T, added)
