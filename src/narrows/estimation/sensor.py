"""A sensor: its measurement of the state, with noise, period and delay.

Positions are those of the canal: x along its line, y to starboard of it; headings and courses are relative to its
direction.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np

from narrows.errors import InputError
from narrows.estimation.settings import FAULT_STD, FAULT_WALK
from narrows.estimation.states import Columns

Values = tuple[Any, ...]


@runtime_checkable
class Sensor(Protocol):
    """The interface of a sensor.

    ``name`` is the name of its readings, ``fields`` the names of its components in a table, ``sigma`` the standard
    deviations of their white errors, ``angles`` marks angles [rad], ``straight`` is True if the components are linear
    in the states. ``period`` [s] is the time between readings, ``late`` [s] the delay of a reading. Optional ``errors``
    is a sequence of ``GaussMarkov``; each becomes a state of the estimate.
    """

    name: str
    period: float
    late: float
    fields: tuple[str, ...]
    sigma: tuple[float, ...]
    angles: tuple[bool, ...]
    straight: bool

    def measured(self, at: Columns) -> Values:
        """Return its components without errors, from states."""

    def numbers(self, reading: Sequence[float]) -> Values:
        """Return a reading, one number for each field, as the components of ``measured``."""

    def reading(self, numbers: Values) -> Values:
        """Return the reading of components: the inverse of ``numbers``."""

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        """Return states for a start from a reading, with their standard deviations."""


@dataclass(frozen=True)
class GaussMarkov:
    """An error of a sensor correlated in time: a first-order Gauss-Markov process, or a constant bias.

    Parameters
    ----------
    std : float or tuple of float [unit of the sensor's numbers]
        Standard deviation, of all components of the sensor or of each of them; 0 for none.
    time : float [s]
        Correlation time; ``math.inf`` for a constant bias.

    Raises
    ------
    InputError
        If a number is invalid.
    """

    std: float | tuple[float, ...]
    time: float = math.inf

    def __post_init__(self) -> None:
        check_std(*(self.std if isinstance(self.std, tuple) else (self.std,)))
        if not self.time > 0.0:
            raise InputError(f"time = {self.time} is no correlation time; give seconds over 0, or math.inf for a bias")


@dataclass(frozen=True)
class Measuring:
    """Base of the package's own sensors: one noise level for all components; by default one, which is a state."""

    noise: float  # Standard deviation of the white error of each component [SI]
    _: KW_ONLY
    period: float = 1.0  # Time between readings [s]
    late: float = 0.0  # Delay of a reading [s]
    name: str = ""  # Name of its readings
    bias: float = 0.0  # Standard deviation of a constant error [SI]
    coloured: GaussMarkov | None = None  # Error correlated in time
    angles: ClassVar[tuple[bool, ...]] = (False,)
    suffixes: ClassVar[tuple[str, ...]] = ("",)  # Ends of the names of the components
    state: ClassVar[str]  # Name of the state that it measures

    def __post_init__(self) -> None:
        for name in ("period", "noise"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"a sensor's {name} is a finite number over 0, and this one is {value}; give it in SI")
        if not (math.isfinite(self.late) and self.late >= 0.0):
            raise InputError(f"a sensor's readings cannot come {self.late} s late; give 0 or more")
        check_std(self.bias)

    @property
    def fields(self) -> tuple[str, ...]:
        return tuple(self.name + suffix for suffix in self.suffixes)

    @property
    def sigma(self) -> tuple[float, ...]:
        return (self.noise,) * len(self.angles)

    @property
    def errors(self) -> tuple[GaussMarkov, ...]:
        return (*((GaussMarkov(self.bias),) if self.bias else ()), *((self.coloured,) if self.coloured else ()))

    @property
    def straight(self) -> bool:
        return True

    def numbers(self, reading: Sequence[float]) -> Values:
        return tuple(reading)

    def reading(self, numbers: Values) -> Values:
        return numbers

    def measured(self, at: Columns) -> Values:
        return (getattr(at, self.state),)

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        return {self.state: (reading[0], self.noise)}


def check_std(*sizes: float) -> None:
    """Raise if a standard deviation is invalid."""
    for size in sizes:
        if not (math.isfinite(size) and size >= 0.0):
            raise InputError(f"a standard deviation of {size} is none; give 0 or more")


def error_states(sensor: Sensor, faulty: bool = False) -> dict[str, tuple[int, float, float]]:
    """Return the error states of a sensor: component, standard deviation and correlation time [s]."""
    found: dict[str, tuple[int, float, float]] = {}
    if faulty:
        for place, (field, sigma) in enumerate(zip(sensor.fields, sensor.sigma, strict=True)):
            found[f"{field}_fault"] = (place, FAULT_STD * sigma, 2.0 * (FAULT_STD / FAULT_WALK) ** 2 * sensor.period)
    for error in getattr(sensor, "errors", ()):
        kind = "wander" if math.isfinite(error.time) else "bias"
        sizes = error.std if isinstance(error.std, tuple) else (error.std,) * len(sensor.fields)
        for place, (field, std) in enumerate(zip(sensor.fields, sizes, strict=True)):
            if std > 0.0:
                more = "" if f"{field}_{kind}" not in found else f"_{len(found)}"
                found[f"{field}_{kind}{more}"] = (place, float(std), error.time)
    return found


class MarkovProcess:
    """First-order Gauss-Markov processes; random walks if the time is infinite."""

    def __init__(self, walks: np.ndarray, times: np.ndarray, opposed: Sequence[tuple[int, int]] = ()) -> None:
        self.walks, self.times = walks, times  # (n,) Random walks per root second; correlation times [s]
        self.opposed = opposed  # Pairs of places: the walk of the first enters the second with the other sign
        self.places = np.flatnonzero(np.isfinite(times))
        self._rows = np.flatnonzero(walks > 0.0)
        self._over: dict[float, tuple[np.ndarray, np.ndarray]] = {}

    def over(self, duration: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the remaining share of the states at ``places`` after a time, and a root of the noise, (j, n)."""
        if duration not in self._over:
            if len(self._over) > 64:
                self._over.clear()
            share = duration / self.times
            grown = np.full(len(share), duration)
            grown[self.places] = -np.expm1(-2.0 * share[self.places]) * self.times[self.places] / 2.0
            noise = np.zeros((len(self._rows), len(self.walks)))
            noise[np.arange(len(self._rows)), self._rows] = (self.walks * np.sqrt(grown))[self._rows]
            for one, other in self.opposed:
                noise[self._rows == one, other] = -noise[self._rows == one, one]
            self._over[duration] = np.exp(-share[self.places]), noise
        return self._over[duration]

    def after(self, values: np.ndarray, duration: float, random: np.random.Generator) -> np.ndarray:
        """Draw the values after a time, (..., n)."""
        left, noise = self.over(duration)
        values[..., self.places] *= left
        return np.asarray(values + random.standard_normal((*values.shape[:-1], len(noise))) @ noise)


def drawn_reading(sensor: Sensor, at: Any, errors: Mapping[str, Any], random: np.random.Generator) -> Values:
    """Draw a reading from states, with white errors and the given states of the others."""
    numbers = np.stack([np.asarray(number, float) for number in sensor.measured(at)], axis=-1)
    numbers += np.array(sensor.sigma) * random.standard_normal(numbers.shape)
    for state, (place, _, _) in error_states(sensor).items():
        numbers[..., place] += errors[state]
    return sensor.reading(tuple(np.moveaxis(numbers, -1, 0)))


class ErrorProcess:
    """The declared errors of one sensor, drawn from reading to reading."""

    def __init__(self, sensor: Sensor, random: np.random.Generator) -> None:
        self.sensor, self.random, self.known = sensor, random, error_states(sensor)
        std, times = np.array([(std, time) for _, std, time in self.known.values()]).reshape(-1, 2).T
        self.process = MarkovProcess(std * np.sqrt(2.0 / times), times)
        self.values = std * random.standard_normal(len(std))

    def reading(self, at: Any) -> Any:
        self.values = self.process.after(self.values, self.sensor.period, self.random)
        drawn = drawn_reading(self.sensor, at, dict(zip(self.known, self.values, strict=True)), self.random)
        return tuple(map(float, drawn)) if len(drawn) > 1 else float(drawn[0])
