"""The model that a record makes: coefficients, covariance, verdicts, their source, and what the record covered."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from narrows.errors import InputError
from narrows.logbook.learned_coefficient import LearnedCoefficient, verdicts_after
from narrows.model.data_range import DataRange, Range
from narrows.model.model import Model


def learned_model(
    prior: Model, coefficients: Mapping[str, LearnedCoefficient], covariance: np.ndarray, source: str,
    offsets: Range, speeds: Range, contradicted: bool = False,
) -> Model:  # fmt: skip
    """Return the model after a record."""
    # covariance (n, n); offsets [m]; speeds [m/s]
    return replace(
        prior,
        coefficients={name: coefficient.value for name, coefficient in coefficients.items()},
        covariance=(covariance + covariance.T) / 2,
        data_range=covered_range(prior, offsets, speeds),
        source=replace(prior.source, text="; ".join(filter(None, (prior.source.text, source)))),
        verdicts=verdicts_after(prior, coefficients, contradicted),
    )


def covered_range(prior: Model, offsets: Range, speeds: Range) -> DataRange:
    """Return what tests and record cover together."""
    # offsets [m]; speeds [m/s]
    # In a section that no test had, the record alone says how far off the middle and how fast the bank was met; slower
    # than that, its force is less. Where no bank is felt, speeds count alone.
    known, configuration = prior.data_range, prior.configuration
    section = {"width_to_beam": configuration.canal.width / configuration.ship.beam}
    if configuration.canal.depth is not None:
        section["depth_to_draft"] = configuration.canal.depth / configuration.ship.draft
    if not prior.feels_bank:
        low, high = known.speed or speeds
        return replace(known, speed=(min(speeds[0], low), max(speeds[1], high)))
    new = any(getattr(known, name) is None or known.outside(name, ratio) for name, ratio in section.items())
    slowest = min(speeds[0], (known.speed or speeds)[0])
    fastest = speeds[1] if new else max(speeds[1], (known.speed or speeds)[1])
    farthest = offsets[1] if new else max(offsets[1], (known.abs_y or offsets)[1])
    nearest = 0.0 if new else min(offsets[0], (known.abs_y or offsets)[0])
    here = {name: (ratio, ratio) for name, ratio in section.items()} if new else {}
    return replace(known, speed=(slowest, fastest), abs_y=(nearest, farthest), **here)


# A normal prior and blocks of linear readings make a normal posterior: at any rank of the prior, and within bounds.
UNLIKE = (
    "errors of these readings are beyond all measure, or differ by too many powers of ten; check each, and its unit"
)

# Of a standard deviation, by which a bound may be missed.
MISSED = 1e-12


@dataclass(frozen=True)
class NormalPrior:
    """What is known before: means, and a root of the covariance."""

    mean: np.ndarray  # (n,) Means
    root: np.ndarray  # (n, rank) ``root @ root.T`` is the covariance

    @classmethod
    def of(cls, mean: np.ndarray, covariance: np.ndarray) -> "NormalPrior":
        """Return the prior of a covariance, which may lack rank: coefficients that are one, or are known exactly."""
        # mean (n,); covariance (n, n)
        size = np.sqrt(np.diag(covariance))
        scale = np.where(size > 0, size, 1.0)
        share, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
        if not np.isfinite(share).all() or share[0] < -1e-6 * len(mean):
            raise InputError("the covariance of this model's coefficients is none; identify the model again")
        kept = share > 1e-13 * share[-1]
        return cls(mean, size[:, None] * axes[:, kept] * np.sqrt(share[kept]))

    @property
    def covariance(self) -> np.ndarray:
        """The covariance."""
        return np.asarray(self.root @ self.root.T)


@dataclass(frozen=True)
class Blocks:
    """Linear readings ``value = design @ unknowns + error`` in blocks whose errors are independent."""

    value: np.ndarray  # (blocks, q) Read
    design: np.ndarray  # (blocks, q, n) By the unknowns
    covariance: np.ndarray  # (blocks, q, q) Of the errors

    def whitened(self) -> tuple[np.ndarray, np.ndarray]:
        """Return values and design with independent errors of size one."""
        try:
            root = np.linalg.cholesky(self.covariance)
        except np.linalg.LinAlgError:
            raise InputError(UNLIKE) from None
        return np.linalg.solve(root, self.value[..., None])[..., 0], np.linalg.solve(root, self.design)


@dataclass(frozen=True)
class Posterior:
    """What is known after."""

    mean: np.ndarray  # (n,) Means, within bounds where there are any
    free_mean: np.ndarray  # (n,) Means without the bounds
    root: np.ndarray  # (n, rank) ``root @ root.T`` is the covariance, bounds left aside
    # Of the readings under the prior, bounds left aside: sum of squares over what was to be expected [1]
    chi_square: float
    beside: np.ndarray  # (blocks,) The same of each block beside all others and the prior [1]

    @property
    def covariance(self) -> np.ndarray:
        """The covariance."""
        return np.asarray(self.root @ self.root.T)


def updated(prior: NormalPrior, blocks: Blocks, bounds: np.ndarray | None = None) -> Posterior:
    """Return what is known after readings, exactly for linear ones (Bayes)."""
    # bounds (n, 2)
    value, design = blocks.whitened()
    innovation, seen = value - design @ prior.mean, design @ prior.root
    rows = seen.reshape(-1, seen.shape[-1])
    inner = np.linalg.cholesky(np.eye(rows.shape[1]) + rows.T @ rows)
    moved = np.linalg.solve(inner.T, np.linalg.solve(inner, rows.T @ innovation.ravel()))
    root = np.linalg.solve(inner, prior.root.T).T
    mean = prior.mean + prior.root @ moved
    rest = innovation - seen @ moved
    within = mean if bounds is None else brought_within(mean, root, bounds)
    return Posterior(within, mean, root, float(np.sum(innovation * rest)), _beside(rest, design @ root))


def _beside(rest: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Sum of squares of each block over what all others leave open of it, (blocks,)."""
    # The residual of a block beside the others is that of the fit over what of the block's own error no fit takes up.
    share = np.eye(rest.shape[1]) - known @ np.swapaxes(known, 1, 2)
    return np.asarray(np.einsum("bq,bq->b", rest, np.linalg.solve(share, rest[..., None])[..., 0]))


def brought_within(mean: np.ndarray, root: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Return the most likely values of a normal distribution within bounds."""
    # mean (n,); root (n, rank); bounds (n, 2)
    # Lawson and Hanson (1974), Solving least squares problems, chapter 23: least distance programming.
    from scipy.optimize import nnls

    size = np.linalg.norm(root, axis=1)
    sign = np.repeat([1.0, -1.0], len(mean))
    lacking, wide = np.concatenate([bounds[:, 0] - mean, mean - bounds[:, 1]]), np.tile(size, 2)
    asked = np.flatnonzero((wide > 0) & np.isfinite(lacking))
    if not (lacking[asked] > MISSED * wide[asked]).any():
        return mean
    rows = (sign / np.where(wide > 0, wide, 1.0))[asked, None] * np.tile(root, (2, 1))[asked]
    least = lacking[asked] / wide[asked]
    aim = np.append(np.zeros(root.shape[1]), 1.0)
    rest = np.concatenate([rows.T, least[None]]) @ nnls(np.concatenate([rows.T, least[None]]), aim)[0] - aim
    return np.asarray(mean + root @ (-rest[:-1] / rest[-1]))
