"""The ship's own sensors: compass, rate of turn, log, and the indicator of the rudder."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from narrows.estimation.sensor import Measuring, Values, check_bias
from narrows.estimation.states import Columns


class Single(Measuring):
    """What sensors of one number have in common: the number is called as the sensor is, and tells one state."""

    state: ClassVar[str]
    noise: float
    angles: ClassVar[tuple[bool, ...]] = (False,)

    @property
    def fields(self) -> tuple[str, ...]:  # type: ignore[override]
        """Its name."""
        return (self.name,)

    @property
    def sigma(self) -> tuple[float, ...]:
        """Of its number."""
        return (self.noise,)

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        """Return the state that it tells.

        Parameters
        ----------
        reading : sequence of float
            Its number.
        """
        return {self.state: (reading[0], self.noise)}


@dataclass(frozen=True)
class Gyro(Single):
    """A gyrocompass: the heading to the canal's direction.

    Parameters
    ----------
    noise : float [rad]
        Standard deviation.
    bias : float [rad]
        Standard deviation of a constant error, which becomes a state of the estimate; 0 for none.
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

    noise: float = math.radians(0.2)
    bias: float = 0.0
    period: float = 1.0
    late: float = 0.0
    name: str = "gyro"
    state: ClassVar[str] = "psi"
    angles: ClassVar[tuple[bool, ...]] = (True,)

    def __post_init__(self) -> None:
        self.check(noise=self.noise)
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
    period: float = 1.0
    late: float = 0.0
    name: str = "rate_of_turn"
    state: ClassVar[str] = "r"

    def __post_init__(self) -> None:
        self.check(noise=self.noise)

    def measured(self, at: Columns) -> Values:
        """Return the yaw rate.

        Parameters
        ----------
        at : Columns
            The states.
        """
        return (at.r,)


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
    period: float = 1.0
    late: float = 0.0
    name: str = "log"
    state: ClassVar[str] = "u"

    def __post_init__(self) -> None:
        self.check(noise=self.noise)

    def measured(self, at: Columns) -> Values:
        """Return the surge velocity.

        Parameters
        ----------
        at : Columns
            The states.
        """
        return (at.u,)


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
