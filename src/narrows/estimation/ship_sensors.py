"""The ship's own sensors: compass, rate of turn, log, and the indicator of the rudder."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from narrows.estimation.sensor import Measuring, Values, check_bias
from narrows.estimation.states import Columns


class Single(Measuring):
    """What sensors of one number have in common: it tells one state."""

    state: ClassVar[str]

    def measured(self, at: Columns) -> Values:
        """Return the state that it tells."""
        return (getattr(at, self.state),)

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        """Return the state that it tells."""
        return {self.state: (reading[0], self.noise)}


@dataclass(frozen=True)
class Gyro(Single):
    """A gyrocompass: the heading to the canal's direction.

    Parameters
    ----------
    noise : float [rad]
        Standard deviation.
    period : float [s]
        Between readings.
    late : float [s]
        How old a reading is when it comes.
    name : str
        Of its readings.
    bias : float [rad]
        Standard deviation of a constant error, which becomes a state of the estimate; 0 for none.

    Raises
    ------
    InputError
        Where a number is none.
    """

    noise: float = math.radians(0.2)
    _: KW_ONLY
    name: str = "gyro"
    bias: float = 0.0
    state: ClassVar[str] = "psi"
    angles: ClassVar[tuple[bool, ...]] = (True,)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_bias(self.bias)

    def measured(self, at: Columns) -> Values:
        """Return what it indicates.

        Parameters
        ----------
        at : Columns
            The states.
        """
        return (at.psi + at.heading_bias if self.bias else at.psi,)


@dataclass(frozen=True)
class RateOfTurn(Single):
    """A rate gyro: the yaw rate.

    Parameters
    ----------
    noise : float [rad/s]
        Standard deviation.
    period : float [s]
        Between readings.
    late : float [s]
        How old a reading is when it comes.
    name : str
        Of its readings.

    Raises
    ------
    InputError
        Where a number is none.
    """

    noise: float = math.radians(0.03)
    _: KW_ONLY
    name: str = "rate_of_turn"
    state: ClassVar[str] = "r"


@dataclass(frozen=True)
class Log(Single):
    """A speed log: the surge velocity through the water.

    Parameters
    ----------
    noise : float [m/s]
        Standard deviation.
    period : float [s]
        Between readings.
    late : float [s]
        How old a reading is when it comes.
    name : str
        Of its readings.

    Raises
    ------
    InputError
        Where a number is none.
    """

    noise: float = 0.05
    _: KW_ONLY
    name: str = "log"
    state: ClassVar[str] = "u"


@dataclass(frozen=True)
class RudderIndicator:
    """What the estimator knows of the rudder: its indicated angle drives the model.

    Parameters
    ----------
    noise : float [rad]
        Standard deviation of a reading.
    bias : float [rad]
        Standard deviation of a constant error, which becomes a state of the estimate; 0 for none.
    name : str
        Of its readings.

    Raises
    ------
    InputError
        Where a number is none.
    """

    noise: float = 0.0
    bias: float = math.radians(1.0)
    name: str = "rudder"

    def __post_init__(self) -> None:
        check_bias(self.bias)
        check_bias(self.noise)
