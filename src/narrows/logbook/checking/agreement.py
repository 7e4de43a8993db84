"""How many times one measured change another is, whichever of them is noisy; and how motions of a plane agree."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

FEWEST = 8
"""Windows that must tell of a factor."""
SURE = 4.0
"""Standard errors that a number must be away."""
OVERLAP = 2.0
"""Windows that share what they cover."""


class Factor(NamedTuple):
    """By which factor one change is another, whichever of them is noisy.

    Parameters
    ----------
    low, high : float [1]
        Between which it lies: with all noise in the one, and with all of it in the other; widened by ``SURE`` standard
        errors.
    correlation : float [1]
        Between the two.
    windows : float
        That tell independently.

    References
    ----------
    Frisch (1934), Statistical confluence analysis by means of complete regression systems: the slopes of either
    regression bound that of the relation.
    """

    low: float
    high: float
    correlation: float
    windows: float

    @property
    def told(self) -> bool:
        """Whether it is told at all: of one sign, by enough windows."""
        return bool(self.windows >= FEWEST and self.low * self.high > 0)

    def holds(self, factor: float, slack: float) -> bool:
        """Return whether it may be a number, or another within a factor of that (ours).

        Parameters
        ----------
        factor : float [1]
            The number.
        slack : float [1]
            At least 1.
        """
        low, high = sorted((factor / slack, factor * slack))
        return bool(self.low <= high and self.high >= low)

    @property
    def middle(self) -> float:
        """Its geometric mean; 0 where its sign is not told."""
        return float(np.copysign(np.sqrt(self.low * self.high), self.low)) if self.low * self.high > 0 else 0.0


def factor_of(change: np.ndarray, expected: np.ndarray) -> Factor:
    """Return by which factor changes are those that are expected, but for a constant (ours).

    Parameters
    ----------
    change, expected : array (windows,)
        Over windows that overlap by half; NaN where one is not known.
    """
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
    """How far motions in a plane are others, turned and stretched.

    Parameters
    ----------
    stretch : float [1]
        By which factor.
    turn : float [rad]
        By which angle.
    error : float [1]
        Standard error of the stretch, and of the turn [rad].
    apart : float [1]
        What is left of the motions, over their size.
    """

    stretch: float
    turn: float
    error: float
    apart: float


def turned_of(way: np.ndarray, expected: np.ndarray) -> Turned | None:
    """Return how far ways are those that are expected, turned and stretched; None where too few are known (ours).

    Parameters
    ----------
    way, expected : array (windows,) of complex [m]
        Over windows that overlap by half; NaN where one is not known.
    """
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
    """Numbers by least squares.

    Parameters
    ----------
    values, errors : array (numbers,)
        With their standard errors.
    """

    values: np.ndarray
    errors: np.ndarray


def least_squares(column: np.ndarray, regressors: Sequence[np.ndarray], overlap: float = OVERLAP) -> Estimates | None:
    """Return the numbers that make a column of others; None where too few rows are known (ours).

    Parameters
    ----------
    column : array (rows,)
        NaN where it is not known.
    regressors : sequence of arrays (rows,)
        Likewise.
    overlap : float [1]
        Rows that share what they cover.
    """
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
    """A mean of numbers, weighted by their standard errors.

    Parameters
    ----------
    value, error : float
        With its standard error.
    numbers : int
        How many are in it.
    """

    value: float
    error: float
    numbers: int


def pooled(effects: Sequence[tuple[float, float]]) -> Pooled | None:
    """Return the mean of numbers, weighted by their standard errors; None where there is none (ours).

    Parameters
    ----------
    effects : sequence of (float, float)
        Numbers, with their standard errors.
    """
    known = [(effect, error) for effect, error in effects if error > 0]
    if not known:
        return None
    weight = sum(error**-2 for _, error in known)
    return Pooled(sum(effect * error**-2 for effect, error in known) / weight, weight**-0.5, len(known))


def nearest(factor: float, known: Mapping[str, float], slack: float = 1.1) -> str | None:
    """Return what is known to make a factor; None where nothing comes near (ours).

    Parameters
    ----------
    factor : float [1]
        Seen.
    known : mapping of str to float
        Factors by their causes.
    slack : float [1]
        How far off one may be.
    """
    if not factor > 0:
        return None
    off = {cause: float(abs(np.log(factor / usual))) for cause, usual in known.items()}
    best = min(off, key=lambda cause: off[cause])
    return best if off[best] < np.log(slack) else None
