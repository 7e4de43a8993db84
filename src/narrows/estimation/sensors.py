"""Sensors: their measurements of the state, with noise, slow errors, period and delay.

Positions are those of the canal: x along its line, y to starboard of it; headings and courses are relative to its
direction.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean
from narrows.base.named_values import by_name
from narrows.base.results import Aliased
from narrows.estimation.settings import FAULT_STD, FAULT_WALK
from narrows.estimation.states import STATES, Columns, MarkovProcess
from narrows.ship.checks import check_sizes
from narrows.simulation.inputs import finite_numbers

# What ``narrows.estimation`` exports.
__all__ = ["CourseOverGround", "GaussMarkov", "Gnss", "Gyro", "Log", "RateOfTurn", "RudderIndicator", "Sensor"]

Values = tuple[Any, ...]
STRAIGHT = 1e-9  # Curvature [1/m] below which a line counts as straight
# Correlation time [s] of the slow position error of a receiver without corrections: the autocorrelation of recorded
# errors falls within about a minute: Wilson, GPS horizontal position accuracy. It is not white: Sensors 20 (2020) 6050.
GNSS_TIME = 60.0


@dataclass(frozen=True)
class GaussMarkov:
    """An error of a sensor correlated in time: a first-order Gauss-Markov process, or a constant bias."""

    #: Standard deviation, of all components of the sensor or of each of them, in their unit; 0 for none
    std: float | tuple[float, ...]
    time: float = math.inf  #: Correlation time; ``math.inf`` for a constant bias [s]

    def __post_init__(self) -> None:
        if not (self.time > 0.0 and np.isfinite(self.std).all() and np.greater_equal(self.std, 0.0).all()):
            raise InputError(f"{self} is no error; give finite standard deviations from 0, and a time over 0 s")


@dataclass(frozen=True)
class Sensor(Aliased):
    """Base of sensors, also of your own: by default one component, which is the state of the name ``state``.

    A sensor of other components has its own ``suffixes`` of their names, ``angles`` (True for angles [rad]),
    ``is_linear`` (True if they are linear in the states), ``measured`` and ``start``.
    """

    noise: float  # Standard deviation of the white error of each component [SI]
    _: KW_ONLY
    period: float = 1.0  # Time between readings [s]
    delay: float = 0.0  # Delay of a reading [s]
    name: str = ""  # Name of its readings
    bias: float = 0.0  # Standard deviation of a constant error [SI]
    coloured: GaussMarkov | None = None  # Error correlated in time
    angles: ClassVar[tuple[bool, ...]] = (False,)
    is_linear: ClassVar[bool] = True
    suffixes: ClassVar[tuple[str, ...]] = ("",)  # Ends of the names of the components
    state: ClassVar[str] = ""  # Name of the state that it measures

    def __post_init__(self) -> None:
        check_sizes(self, ("noise", "period"), ("noise", "period", "delay", "bias"))

    @cached_property
    def fields(self) -> tuple[str, ...]:
        return tuple(self.name + suffix for suffix in self.suffixes)

    @property
    def sigma(self) -> tuple[float, ...]:
        return (self.noise,) * len(self.angles)

    @property
    def errors(self) -> tuple[GaussMarkov, ...]:
        return (*((GaussMarkov(self.bias),) if self.bias else ()), *((self.coloured,) if self.coloured else ()))

    def numbers(self, reading: Sequence[float]) -> Values:
        """Return a reading, one number for each field, as the components of ``measured``."""
        return tuple(reading)

    def reading(self, numbers: Values) -> Values:
        """Return the reading of components: the inverse of ``numbers``."""
        return numbers

    def measured(self, at: Columns) -> Values:
        """Return its components without errors, from states."""
        return (getattr(at, self.state),)

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        """Return states for a start from a reading, with their standard deviations."""
        return {self.state: (reading[0], self.noise)}


@accept_aliases
@dataclass(frozen=True)
class Gyro(Sensor):
    """A gyrocompass: the heading to the canal's direction.

    ``noise`` [rad], the standard deviation of the white error, is by default that of a gyrocompass within IMO
    A.424(XI). Its slow error, of 0.2 degrees, is ``coloured`` (a ``GaussMarkov``) or ``bias`` [rad], the standard
    deviation of a constant error; each becomes a state of the estimate. ``period`` and ``delay`` [s] are the time
    between readings and the delay of a reading, ``name`` is the name of its readings.
    """

    noise: float = math.radians(0.15)
    _: KW_ONLY
    name: str = "gyro"
    state: ClassVar[str] = "psi"
    angles: ClassVar[tuple[bool, ...]] = (True,)


@accept_aliases
@dataclass(frozen=True)
class RateOfTurn(Sensor):
    """A rate gyro: the yaw rate, with white ``noise`` [rad/s]; other arguments as in ``Gyro``.

    The default is that of an indicator within IMO A.526(13), 0.5 degrees a minute and 5 % of the rate. The noise of a
    rate from differences of headings is several times as large.
    """

    noise: float = math.radians(0.01)
    _: KW_ONLY
    name: str = "rate_of_turn"
    state: ClassVar[str] = "r"


@accept_aliases
@dataclass(frozen=True)
class Log(Sensor):
    """A speed log: the surge velocity through the water, with white ``noise`` [m/s]; other arguments as in ``Gyro``."""

    noise: float = 0.05
    _: KW_ONLY
    name: str = "log"
    state: ClassVar[str] = "u"


@dataclass(frozen=True)
class RudderIndicator:
    """The indicated rudder angle, an input of the model."""

    noise: float = 0.0  #: Standard deviation of a reading; 0 for none [rad]
    #: That of a constant error, which becomes a state of the estimate; 0 for none [rad]
    bias: float = math.radians(1.0)
    name: ClassVar[str] = "rudder"

    def __post_init__(self) -> None:
        check_sizes(self)


@dataclass(frozen=True)
class Antenna(Sensor):
    """Base of receivers: an antenna, and two components, along and across."""

    _: KW_ONLY
    forward: float = 0.0  # Position of the antenna ahead of midship [m]
    starboard: float = 0.0  # Position of the antenna to starboard [m]
    angles: ClassVar[tuple[bool, ...]] = (False, False)
    source: ClassVar[str] = "satellites"

    def __post_init__(self) -> None:
        super().__post_init__()
        finite_numbers(forward=self.forward, starboard=self.starboard)


@accept_aliases
@dataclass(frozen=True)
class Gnss(Antenna):
    """A satellite receiver: the position of its antenna, ``forward`` and ``starboard`` of midship [m], in the canal.

    ``noise`` [m] is the standard deviation of the white error along and across. The slow error, ``coloured``, is by
    default as large, with a correlation time of a minute; ``None``: white errors alone. Other arguments: see ``Gyro``.
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
    def is_linear(self) -> bool:  # type: ignore[override]
        return not (self.forward or self.starboard)

    def measured(self, at: Columns) -> Values:
        if self.is_linear:
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
    """Course and speed over ground, of a satellite receiver from Doppler shifts; other arguments as in ``Gnss``.

    Readings are course and speed; the estimate uses velocities along and across, whose white ``noise`` [m/s] does not
    depend on the speed. Together with the model's drift they determine a gyro's bias.
    """

    noise: float = 0.05
    _: KW_ONLY
    name: str = "course"
    suffixes: ClassVar[tuple[str, ...]] = ("_over_ground", "_speed")
    is_linear: ClassVar[bool] = False

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
        return {}  # Current and drift make these velocities differ from the states


# Sensors of the estimate by the default name of their readings. The rudder indicator is an input of the model instead.
SENSORS: dict[str, type[Sensor]] = by_name(
    "sensors", [(kind.name, kind) for name in __all__ if issubclass(kind := globals()[name], Sensor) and kind.name]
)


def split_sensors(sensors: Sequence[Any]) -> tuple[dict[str, Sensor], RudderIndicator]:
    if isinstance(sensors, str) or not isinstance(sensors, Sequence):
        records = "run(table.rename(columns={'x': 'gnss_x', 'y': 'gnss_y', 'psi': 'gyro', 'u': 'log'}))"
        raise InputError(f"sensors are a list, as [Gnss(), Gyro(), Log(), RudderIndicator()]; give one, then {records}")
    found: dict[str, Any] = {}
    for sensor in sensors:
        has_state = not isinstance(sensor, Sensor) or sensor.state or type(sensor).measured is not Sensor.measured
        if not isinstance(sensor, Sensor | RudderIndicator) or not (sensor.name and has_state):
            what = sensor.__name__ if isinstance(sensor, type) else type(sensor).__name__
            known = ", ".join(f"{kind.__name__}()" for kind in SENSORS.values())
            raise InputError(
                f"{what} is no sensor; give objects such as {known}, or of your own dataclass of kind "
                "Sensor, with name: str and state"
            )
        if sensor.name in found:
            raise InputError(f"two sensors are called {sensor.name!r}; give one another name, as Gnss(name='gnss_aft')")
        found[sensor.name] = sensor
    indicator = next((one for one in sensors if isinstance(one, RudderIndicator)), RudderIndicator(bias=0.0))
    measuring = {name: one for name, one in found.items() if one is not indicator}
    if not measuring:
        raise InputError("an estimator needs sensors; give Gnss, Gyro and Log at least")
    states = {*STATES, *(name for sensor in measuring.values() for name in error_states(sensor))}
    for name, sensor in measuring.items():
        if type(sensor).measured is Sensor.measured and sensor.state not in states:
            raise InputError(
                f"sensor {name} reads an unknown state {sensor.state!r}{did_you_mean(sensor.state, states)}"
            )
    return measuring, indicator


def error_states(sensor: Sensor, faulty: bool = False) -> dict[str, tuple[int, float, float]]:
    """Return the error states of a sensor: component, standard deviation and correlation time [s]."""
    errors = []
    if faulty:
        # Correlation time of a process of this size that walks by FAULT_WALK sigmas from one reading to the next.
        time = 2.0 * (FAULT_STD / FAULT_WALK) ** 2 * sensor.period
        errors.append(("fault", GaussMarkov(tuple(FAULT_STD * sigma for sigma in sensor.sigma), time)))
    errors += [("wander" if math.isfinite(one.time) else "bias", one) for one in sensor.errors]
    found: dict[str, tuple[int, float, float]] = {}
    for kind, error in errors:
        for place, std in enumerate(np.broadcast_to(error.std, len(sensor.fields)).tolist()):
            name = f"{sensor.fields[place]}_{kind}"
            if std > 0.0:
                found[f"{name}_{len(found)}" if name in found else name] = place, std, error.time
    return found


def draw_reading(sensor: Sensor, at: Any, errors: Mapping[str, Any], random: np.random.Generator) -> Values:
    """Draw a reading at a state, with white errors and given values of the error states."""
    numbers = np.stack([np.asarray(number, float) for number in sensor.measured(at)], axis=-1)
    numbers += np.array(sensor.sigma) * random.standard_normal(numbers.shape)
    for state, (place, _, _) in error_states(sensor).items():
        numbers[..., place] += errors[state]
    return sensor.reading(tuple(np.moveaxis(numbers, -1, 0)))


class ErrorProcess:
    """The declared errors of one sensor, drawn from reading to reading."""

    def __init__(self, sensor: Sensor, random: np.random.Generator) -> None:
        self.sensor, self.random, self.states = sensor, random, error_states(sensor)
        std, times = np.array([(std, time) for _, std, time in self.states.values()]).reshape(-1, 2).T
        self.process = MarkovProcess(std * np.sqrt(2.0 / times), times)
        self.values = std * random.standard_normal(len(std))

    def reading(self, at: Any) -> Any:
        self.values = self.process.after(self.values, self.sensor.period, self.random)
        drawn = draw_reading(self.sensor, at, dict(zip(self.states, self.values, strict=True)), self.random)
        return tuple(map(float, drawn)) if len(drawn) > 1 else float(drawn[0])
