"""How many times one measured change another is, whichever of them is noisy; and how motions of a plane agree."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

# Windows that must tell of a factor.
FEWEST = 8
# Standard errors that a number must be away.
SURE = 4.0
# Windows that share what they cover.
OVERLAP = 2.0


class Factor(NamedTuple):
    """By which factor one change is another, whichever of them is noisy."""

    # Frisch (1934), Statistical confluence analysis by means of complete regression systems: the slopes of either
    # regression bound that of the relation.

    # Between which it lies: with all noise in the one, and with all of it in the other; widened by ``SURE`` standard
    # errors [1]
    low: float
    # Between which it lies: with all noise in the one, and with all of it in the other; widened by ``SURE`` standard
    # errors [1]
    high: float
    correlation: float  # Between the two [1]
    windows: float  # That tell independently

    @property
    def told(self) -> bool:
        """Whether it is told at all: of one sign, by enough windows."""
        return bool(self.windows >= FEWEST and self.low * self.high > 0)

    def holds(self, factor: float, slack: float) -> bool:
        """Return whether it may be a number, or another within a factor of that."""
        low, high = sorted((factor / slack, factor * slack))
        return bool(self.low <= high and self.high >= low)

    @property
    def middle(self) -> float:
        """Its geometric mean; 0 where its sign is not told."""
        return float(np.copysign(np.sqrt(self.low * self.high), self.low)) if self.low * self.high > 0 else 0.0


def factor_of(change: np.ndarray, expected: np.ndarray) -> Factor:
    """Return by which factor changes are those that are expected, but for a constant."""
    # change, expected (windows,)
    known = np.isfinite(change) & np.isfinite(expected)
    windows = float(known.sum() / OVERLAP)
    if windows < FEWEST:
        return Factor(-np.inf, np.inf, 0.0, windows)
    a, b = change[known] - np.mean(change[known]), expected[known] - np.mean(expected[known])
    aa, bb, ab = float(a @ a), float(b @ b), float(a @ b)
    if not aa * bb > 0 or ab == 0:
        return Factor(-np.inf, np.inf, 0.0, windows)
    correlation = ab / np.sqrt(aa * bb)
    error = SURE * np.sqrt(max(1 - correlation**2, 0.0) / (windows - 2) * aa / bb)
    # The error of the slope with all noise in the other grows as the correlation falls.
    gentle, steep = sorted((ab / bb, aa / ab), key=abs)
    gentle, steep = abs(gentle) - error, abs(steep) + error / correlation**2
    low, high = (gentle, steep) if ab > 0 else (-steep, -gentle)
    return Factor(low, high, correlation, windows)


class Turned(NamedTuple):
    """How far motions in a plane are others, turned and stretched."""

    stretch: float  # By which factor [1]
    turn: float  # By which angle [rad]
    error: float  # Standard error of the stretch, and of the turn [rad] [1]
    apart: float  # What is left of the motions, over their size [1]


def turned_of(way: np.ndarray, expected: np.ndarray) -> Turned | None:
    """Return how far ways are those that are expected, turned and stretched; None where too few are known."""
    # way, expected (windows,) [m]
    known = np.isfinite(way) & np.isfinite(expected)
    a, b = way[known], expected[known]
    windows, bb, aa = known.sum() / OVERLAP, float((np.abs(b) ** 2).sum()), float((np.abs(a) ** 2).sum())
    if windows < FEWEST or not bb * aa > 0:
        return None
    factor = np.vdot(b, a) / bb
    left = float((np.abs(a - factor * b) ** 2).sum())
    error = np.sqrt(left / (2 * (windows - 1)) / bb / OVERLAP)
    return Turned(float(abs(factor)), float(np.angle(factor)), float(error), float(np.sqrt(left / aa)))


class Estimates(NamedTuple):
    """Numbers by least squares."""

    values: np.ndarray  # (numbers,) With their standard errors
    errors: np.ndarray  # (numbers,) With their standard errors


def least_squares(column: np.ndarray, regressors: Sequence[np.ndarray], overlap: float = OVERLAP) -> Estimates | None:
    """Return the numbers that make a column of others; None where too few rows are known."""
    # column (rows,); regressors (rows,)
    design = np.stack(regressors, axis=1)
    known = np.isfinite(column) & np.isfinite(design).all(axis=1)
    rows = known.sum() / overlap - design.shape[1]
    if rows < FEWEST:
        return None
    scale = np.abs(design[known]).max(axis=0)
    scale[scale == 0] = 1.0
    scaled = design[known] / scale
    values = np.linalg.lstsq(scaled, column[known], rcond=None)[0]
    left = column[known] - scaled @ values
    spread = np.linalg.pinv(scaled.T @ scaled) * float(left @ left) / rows
    return Estimates(values / scale, np.sqrt(np.diag(spread)) / scale)


class Pooled(NamedTuple):
    """A mean of numbers, weighted by their standard errors."""

    value: float  # With its standard error
    error: float  # With its standard error
    numbers: int  # How many are in it


def pooled(effects: Sequence[tuple[float, float]]) -> Pooled | None:
    """Return the mean of numbers, weighted by their standard errors; None where there is none."""
    # effects (float, float)
    known = [(effect, error) for effect, error in effects if error > 0]
    if not known:
        return None
    weight = sum(error**-2 for _, error in known)
    return Pooled(sum(effect * error**-2 for effect, error in known) / weight, weight**-0.5, len(known))


def nearest(factor: float, known: Mapping[str, float], slack: float = 1.1) -> str | None:
    """Return what is known to make a factor; None where nothing comes near."""
    if not factor > 0:
        return None
    off = {cause: float(abs(np.log(factor / usual))) for cause, usual in known.items()}
    best = min(off, key=lambda cause: off[cause])
    return best if off[best] < np.log(slack) else None
