"""What a sensor is: what it measures of the state, how well, how often and how late.

Places are those of the canal: x along its line, y to starboard of it; headings and courses are to its direction.
"""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

from narrows.errors import InputError
from narrows.estimation.settings import FAULT_STD, FAULT_WALK
from narrows.estimation.states import Columns

Values = tuple[Any, ...]


@runtime_checkable
class Sensor(Protocol):
    """What measures: any object with these attributes is one.

    ``name`` is what its readings are called, ``fields`` what its numbers are called in a table of records, ``sigma``
    the standard deviations of their white errors, ``angles`` which of them are angles [rad], ``straight`` whether they
    are sums of states times constants; ``period`` [s] is the time between readings, ``late`` [s] how old a reading is
    when it comes. Where it has ``errors`` too, a sequence of ``GaussMarkov``, each becomes a state of the estimate.
    """

    name: str
    period: float
    late: float

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of its numbers."""

    @property
    def sigma(self) -> tuple[float, ...]:
        """Standard deviations of the white errors of its numbers."""

    @property
    def angles(self) -> tuple[bool, ...]:
        """Which are angles."""

    @property
    def straight(self) -> bool:
        """Whether its numbers are sums of states times constants."""

    def measured(self, at: Columns) -> Values:
        """Return its numbers, without errors, in states."""

    def numbers(self, reading: Sequence[float]) -> Values:
        """Return a reading, one number for each field, as the numbers that ``measured`` gives."""

    def reading(self, numbers: Values) -> Values:
        """Return the reading of numbers: ``numbers`` backwards."""

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        """Return the states that a reading gives, with their standard deviations, to start from."""


@dataclass(frozen=True)
class GaussMarkov:
    """An error of a sensor that is correlated in time: a first-order Gauss-Markov process, or a constant bias.

    Parameters
    ----------
    std : float or tuple of float [unit of the sensor's numbers]
        Standard deviation, of all numbers of the sensor or of each of them; 0 for none.
    time : float [s]
        Correlation time; ``math.inf`` for a constant bias.

    Raises
    ------
    InputError
        If a number is none.
    """

    std: float | tuple[float, ...]
    time: float = math.inf

    def __post_init__(self) -> None:
        check_std(*(self.std if isinstance(self.std, tuple) else (self.std,)))
        if not self.time > 0.0:
            raise InputError(f"time = {self.time} is no correlation time; give seconds over 0, or math.inf for a bias")


@dataclass(frozen=True)
class Measuring:
    """What the package's own sensors have in common: one noise for all of their numbers."""

    noise: float  # Standard deviation of the white error of each of its numbers [SI]
    _: KW_ONLY
    period: float = 1.0  # Time between readings [s]
    late: float = 0.0  # Age of a reading when it comes [s]
    name: str = ""  # Of its readings
    bias: float = 0.0  # Standard deviation of a constant error [SI]
    coloured: GaussMarkov | None = None  # Error that is correlated in time
    angles: ClassVar[tuple[bool, ...]] = (False,)

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
        """Its name, where it has one number."""
        return (self.name,)

    @property
    def sigma(self) -> tuple[float, ...]:
        """Standard deviations of the white errors of its numbers."""
        return (self.noise,) * len(self.angles)

    @property
    def errors(self) -> tuple[GaussMarkov, ...]:
        """Errors that are correlated in time."""
        return (*((GaussMarkov(self.bias),) if self.bias else ()), *((self.coloured,) if self.coloured else ()))

    @property
    def straight(self) -> bool:
        """Whether its numbers are sums of states times constants: they are."""
        return True

    def numbers(self, reading: Sequence[float]) -> Values:
        """Return a reading as it is."""
        return tuple(reading)

    def reading(self, numbers: Values) -> Values:
        """Return the numbers as they are."""
        return numbers


def check_std(*sizes: float) -> None:
    """Raise where a standard deviation is none."""
    for size in sizes:
        if not (math.isfinite(size) and size >= 0.0):
            raise InputError(f"a standard deviation of {size} is none; give 0 or more")


def error_states(sensor: Sensor, faulty: bool = False) -> dict[str, tuple[int, float, float]]:
    """Return the states of a sensor's errors: of which of its numbers, standard deviation and correlation time [s]."""
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
