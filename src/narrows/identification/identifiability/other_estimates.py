"""Other estimates of a coefficient, which should agree with the fit's."""

from dataclasses import dataclass
from enum import Enum

import numpy as np


class Kind(Enum):
    """What another fit is made of."""

    STRATA = "strata"
    WEIGHTS = "weights"
    WITHOUT = "without"
    ONLY = "only"
    TYPE = "type"
    SHAPE = "shape"
    GAIN = "gain"


@dataclass(frozen=True)
class OtherEstimate:
    """Another estimate of one coefficient."""

    kind: Kind  # What it is made of
    label: str  # In words
    value: float  # NaN where nothing is left of the coefficient
    stratum: tuple[str, float] | None  # Which one alone tells it: ``speed`` [m/s] or ``depth`` [m], and its mean

    @property
    def lost(self) -> bool:
        """Whether nothing is left of the coefficient."""
        return not np.isfinite(self.value)


@dataclass(frozen=True)
class Alternative(OtherEstimate):
    """The same in scaled parameters, with its errors."""

    std: float  # Its standard error by the error model
    gap: float  # Standard error of its difference from the fit, by the scatter that the data show


@dataclass(frozen=True)
class ComparedEstimate(OtherEstimate):
    """The same in the coefficient's unit, beside the fit's."""

    reach: float  # Half of its 95 % interval
    share: float  # Of the information that the fit has: variance of the fit over that of the alternative [1]
    contradicts: bool  # Whether it is farther from the fit than the scatter of the data allows, and by what matters

    @property
    def holds_zero(self) -> bool:
        """Whether its interval holds 0."""
        return abs(self.value) <= self.reach
