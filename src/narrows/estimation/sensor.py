"""What a sensor is: what it measures of the state, how well, how often and how late.

Places are those of the canal: x along its line, y to starboard of it; headings and courses are to its direction.
"""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

from narrows.errors import InputError
from narrows.estimation.states import Columns

Values = tuple[Any, ...]


@runtime_checkable
class Sensor(Protocol):
    """What measures: any object with these attributes is one.

    ``name`` is what its readings are called, ``fields`` what its numbers are called in a table of records, ``sigma``
    their standard deviations, ``angles`` which of them are angles [rad], ``straight`` whether they are linear in the
    state; ``period`` [s] is how often it measures, ``late`` [s] how old a reading is when it comes.
    """

    name: str
    period: float
    late: float

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of its numbers."""

    @property
    def sigma(self) -> tuple[float, ...]:
        """Standard deviations of its numbers."""

    @property
    def angles(self) -> tuple[bool, ...]:
        """Which are angles."""

    @property
    def straight(self) -> bool:
        """Whether its numbers are sums of states times constants."""

    def measured(self, at: Columns) -> Values:
        """Return what it measures in states.

        Parameters
        ----------
        at : Columns
            The states.
        """

    def numbers(self, reading: Sequence[float]) -> Values:
        """Return a reading as the numbers that ``measured`` gives.

        Parameters
        ----------
        reading : sequence of float
            One for each field.
        """

    def reading(self, numbers: Values) -> Values:
        """Return the reading of numbers as ``measured`` gives them: ``numbers`` backwards.

        Parameters
        ----------
        numbers : tuple of float or array
            One for each field.
        """

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        """Return the states that a reading tells, with their standard deviations, to start from.

        Parameters
        ----------
        reading : sequence of float
            One for each field.
        """


@dataclass(frozen=True)
class Measuring:
    """What the package's own sensors have in common: one noise for all of their numbers."""

    noise: float  # Standard deviation of each of its numbers [SI]
    _: KW_ONLY
    period: float = 1.0  # Between readings [s]
    late: float = 0.0  # How old a reading is when it comes [s]
    name: str = ""  # Of its readings
    angles: ClassVar[tuple[bool, ...]] = (False,)

    def __post_init__(self) -> None:
        for name in ("period", "noise"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"a sensor's {name} is a finite number over 0, and this one is {value}; give it in SI")
        if not (math.isfinite(self.late) and self.late >= 0.0):
            raise InputError(f"a sensor's readings cannot come {self.late} s late; give 0 or more")

    @property
    def fields(self) -> tuple[str, ...]:
        """Its name, where it tells one number."""
        return (self.name,)

    @property
    def sigma(self) -> tuple[float, ...]:
        """Standard deviations of its numbers."""
        return (self.noise,) * len(self.angles)

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


def check_bias(size: float) -> None:
    """Raise where a standard deviation is none."""
    if not (math.isfinite(size) and size >= 0.0):
        raise InputError(f"a standard deviation of {size} is none; give 0 or more")
