"""The ship's own sensors: compass, rate of turn, log, and the indicator of the rudder."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np

from narrows.aliases import accept_aliases
from narrows.errors import InputError
from narrows.estimation.sensor import GaussMarkov, Measuring, Sensor, Values, check_std
from narrows.estimation.states import Columns

# Sensors that ``narrows.estimation`` exports.
__all__ = ["CourseOverGround", "Gnss", "Gyro", "Log", "RateOfTurn", "RudderIndicator"]


@accept_aliases
@dataclass(frozen=True)
class Gyro(Measuring):
    """A gyrocompass: the heading to the canal's direction.

    Parameters
    ----------
    noise : float [rad]
        Standard deviation of the white error; by default that of a gyrocompass within IMO A.424(XI), as in the
        ``"vdr"`` grade of a log's sensors. Its slow error, of 0.2 degrees, is ``coloured`` or ``bias``.
    period : float [s]
        Time between readings.
    late : float [s]
        Delay of a reading.
    name : str
        Name of its readings.
    bias : float [rad]
        Standard deviation of a constant error, which becomes a state of the estimate; 0 for none.
    coloured : GaussMarkov, optional
        Error correlated in time, which becomes a state too.

    Raises
    ------
    InputError
        If a number is invalid.
    """

    noise: float = math.radians(0.15)
    _: KW_ONLY
    name: str = "gyro"
    state: ClassVar[str] = "psi"
    angles: ClassVar[tuple[bool, ...]] = (True,)


@accept_aliases
@dataclass(frozen=True)
class RateOfTurn(Measuring):
    """A rate gyro: the yaw rate.

    Parameters
    ----------
    noise : float [rad/s]
        Standard deviation of the white error; by default of an indicator within IMO A.526(13), 0.5 degrees a minute
        and 5 % of the rate. A rate by differences of headings has several times as much.
    period, late, name, bias, coloured : optional
        As for ``Gyro``.
    """

    noise: float = math.radians(0.01)
    _: KW_ONLY
    name: str = "rate_of_turn"
    state: ClassVar[str] = "r"


@accept_aliases
@dataclass(frozen=True)
class Log(Measuring):
    """A speed log: the surge velocity through the water.

    Parameters
    ----------
    noise : float [m/s]
        Standard deviation of the white error.
    period, late, name, bias, coloured : optional
        As for ``Gyro``.
    """

    noise: float = 0.05
    _: KW_ONLY
    name: str = "log"
    state: ClassVar[str] = "u"


@dataclass(frozen=True)
class RudderIndicator:
    """The indicated rudder angle, an input of the model.

    Parameters
    ----------
    noise : float [rad]
        Standard deviation of a reading.
    bias : float [rad]
        Standard deviation of a constant error, which becomes a state of the estimate; 0 for none.
    name : str
        Name of its readings.
    """

    noise: float = 0.0
    bias: float = math.radians(1.0)
    name: str = "rudder"

    def __post_init__(self) -> None:
        check_std(self.bias, self.noise)


# Curvature [1/m] below which a line counts as straight.
STRAIGHT = 1e-9
# Correlation time [s] of the slow error of fixes of a receiver without corrections: the autocorrelation of recorded
# errors falls within about a minute. Wilson, GPS horizontal position accuracy; that the error is not white: Sensors 20
# (2020) 6050.
GNSS_TIME = 60.0


@dataclass(frozen=True)
class Antenna(Measuring):
    """Base of receivers: an antenna, and two components, along and across."""

    _: KW_ONLY
    forward: float = 0.0  # Position of the antenna ahead of midship [m]
    starboard: float = 0.0  # Position of the antenna to starboard [m]
    angles: ClassVar[tuple[bool, ...]] = (False, False)
    source: ClassVar[str] = "satellites"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (math.isfinite(self.forward) and math.isfinite(self.starboard)):
            raise InputError("an antenna needs a place; give forward and starboard in metres from midship")


@accept_aliases
@dataclass(frozen=True)
class Gnss(Antenna):
    """A satellite receiver: the position of its antenna in the canal.

    Parameters
    ----------
    noise : float [m]
        Standard deviation of the white error along and across.
    period, late, name, bias : optional
        As for ``Gyro``.
    coloured : GaussMarkov, optional
        Error correlated in time, which becomes a state too; by default as large as the noise, over a minute, as is
        usual for receivers. ``None``: white errors alone.
    forward, starboard : float [m]
        Position of the antenna relative to midship.
    """

    noise: float = 1.5
    _: KW_ONLY
    name: str = "gnss"
    suffixes: ClassVar[tuple[str, ...]] = ("_x", "_y")
    coloured: GaussMarkov | Literal["usual"] | None = "usual"  # type: ignore[assignment]

    @property
    def errors(self) -> tuple[GaussMarkov, ...]:
        usual = replace(self, coloured=GaussMarkov(self.noise, GNSS_TIME)) if self.coloured == "usual" else self
        return super(Gnss, usual).errors

    @property
    def straight(self) -> bool:
        return not (self.forward or self.starboard)

    def measured(self, at: Columns) -> Values:
        if self.straight:
            return at.x, at.y
        cosine, sine = np.cos(at.psi), np.sin(at.psi)
        ahead = self.forward * cosine - self.starboard * sine
        side = at.y + self.forward * sine + self.starboard * cosine
        bend = at.curvature
        if abs(bend) < STRAIGHT:
            return at.x + ahead, side
        inward, along = 1.0 - bend * side, bend * ahead  # A circle approximates the line
        across = (2.0 * side - bend * (side * side + ahead * ahead)) / (1.0 + np.hypot(inward, along))
        return at.x + np.arctan2(along, inward) / bend, across

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        return {"x": (reading[0], self.noise), "y": (reading[1], self.noise)}


@accept_aliases
@dataclass(frozen=True)
class CourseOverGround(Antenna):
    """Course and speed over ground, of a satellite receiver from Doppler shifts.

    Readings are course and speed; the estimate uses velocities along and across, whose noise does not depend on the
    speed. Together with the model's drift they determine a gyro's bias.

    Parameters
    ----------
    noise : float [m/s]
        Standard deviation of the white error of the velocity along and across.
    period, late, name, bias, coloured, forward, starboard : optional
        As for ``Gyro`` and ``Gnss``.
    """

    noise: float = 0.05
    _: KW_ONLY
    name: str = "course"
    suffixes: ClassVar[tuple[str, ...]] = ("_over_ground", "_speed")

    @property
    def straight(self) -> bool:
        return False

    def numbers(self, reading: Sequence[float]) -> Values:
        course, speed = reading
        return speed * math.cos(course), speed * math.sin(course)

    def reading(self, numbers: Values) -> Values:
        return np.arctan2(numbers[1], numbers[0]), np.hypot(*numbers)

    def measured(self, at: Columns) -> Values:
        cosine, sine = np.cos(at.psi), np.sin(at.psi)
        ahead, side = at.u - at.r * self.starboard, at.v + at.r * self.forward
        return ahead * cosine - side * sine + at.current, ahead * sine + side * cosine + at.current_across

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        return {}  # Current and drift separate these velocities from the state


def is_white(sensor: object) -> bool:
    """Return whether a sensor is a receiver that declares no slow error."""
    return isinstance(sensor, Antenna) and sensor.coloured is None


def slowed(sensor: Any) -> Any:
    """Return a sensor with a slow error as large as its noise."""
    return replace(sensor, coloured=GaussMarkov(sensor.noise, GNSS_TIME))


# Sensors that measure states, by the usual name of their readings; the rudder's indicator is an input of the model.
SENSORS: dict[str, type[Measuring]] = {
    sensor.name: sensor for name in __all__ if issubclass(sensor := globals()[name], Measuring)
}


def split_sensors(sensors: Sequence[Any]) -> tuple[dict[str, Sensor], RudderIndicator]:
    if isinstance(sensors, str) or not isinstance(sensors, Sequence):
        raise InputError("sensors are a list, as [Gnss(), Gyro(), Log(), RudderIndicator()]; give one")
    indicators = [sensor for sensor in sensors if isinstance(sensor, RudderIndicator)]
    measuring = [sensor for sensor in sensors if not isinstance(sensor, RudderIndicator)]
    if len(indicators) > 1:
        raise InputError("a ship has one rudder here, and these are several RudderIndicators; leave one")
    for sensor in measuring:
        if isinstance(sensor, type) or not isinstance(sensor, Sensor):
            what = sensor.__name__ if isinstance(sensor, type) else type(sensor).__name__
            known = ", ".join(f"{own.__name__}()" for own in SENSORS.values())
            raise InputError(f"{what} is no sensor; give objects such as {known}, or of your own that keep to Sensor")
    names = [sensor.name for sensor in measuring]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two sensors are called {name!r}; give one another name, as Gnss(name='gnss_aft')")
    if not names:
        raise InputError("an estimator needs sensors; give Gnss, Gyro and Log at least")
    return dict(zip(names, measuring, strict=True)), indicators[0] if indicators else RudderIndicator(bias=0.0)
