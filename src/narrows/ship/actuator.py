"""An actuator: what moves at a command, and all that tables of tests, terms, files and scaling ask of it.

Its position is a quantity of its own, called as the actuator is. It enters the terms as it is, or where it is an angle
as its cosine and sine; ``<name>_limit`` and ``<name>_rate`` are its largest size and its fastest change.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Self

import numpy as np

from narrows.errors import InputError
from narrows.quantities.dimensions import Dimension, dimension_of
from narrows.quantities.names import FORCES, REGRESSOR_INPUTS, Number, Quantity
from narrows.ship.checks import check_fields

ENDS = ("limit", "rate")


@dataclass(frozen=True)
class Part:
    """A section of a ship file that belongs to an actuator; subclasses are frozen dataclasses of its numbers."""

    # What the section is called, and what the names of its numbers begin with.
    SECTION: ClassVar[str] = ""
    # What the actuator's position is called; a number of that name says where it is unless it is moved.
    POSITION: ClassVar[str] = ""
    # Unit and meaning of each number.
    NUMBERS: ClassVar[Mapping[str, Quantity]] = {}
    # Whether terms may ask for its numbers.
    ASKED: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_fields(self, {entry.name: self.known_as(entry.name) for entry in fields(self)}, self.SECTION)

    @classmethod
    def known_as(cls, number: str) -> str:
        """Return what terms call a number of the section."""
        return number if number == cls.POSITION else f"{cls.SECTION}_{number}"

    def values(self) -> dict[str, float]:
        """Every number by the name that terms and the equations of motion call it."""
        return {self.known_as(entry.name): getattr(self, entry.name) for entry in fields(self)}

    def scaled(self, factor: Callable[[Dimension], float]) -> Self:
        """Return the same at another size: each number by the dimension of its unit."""
        changed: dict[str, Any] = {
            name: getattr(self, name) * factor(dimension)
            for name, quantity in self.NUMBERS.items()
            if (dimension := dimension_of(quantity.unit)) != Dimension()
        }
        return replace(self, **changed)


@dataclass(frozen=True)
class Actuator:
    """What moves at a command."""

    name: str  # Of its position: the column of a table of tests, the argument of ``forces`` and ``simulate``
    unit: str  # Of its position, in SI
    meaning: str  # Of its position, in words
    angle: bool = False  # Whether it enters the terms by its cosine and sine, ``cos_<name>`` and ``sin_<name>``
    rest: float | None = None  # Its position where nothing is said of it; None where it must be said
    parts: tuple[type[Part], ...] = ()  # The sections of a ship file that give it, each a subclass of ``Part``

    def __post_init__(self) -> None:
        taken = {**REGRESSOR_INPUTS, **FORCES, "psi": None, "t": None}
        if not (self.name.isascii() and self.name.isidentifier()) or self.name in taken:
            raise InputError(f"an actuator cannot be called {self.name!r}; give it a plain word of its own")
        dimension_of(self.unit)
        for part in self.parts:
            if part.POSITION != self.name:
                raise InputError(f"actuator {self.name}: its section [{part.SECTION}] is of {part.POSITION!r}; mend it")

    @property
    def controls(self) -> dict[str, Quantity]:
        """How its position enters the terms: what they ask for, with its unit and meaning."""
        if not self.angle:
            return {self.name: Quantity(self.unit, self.meaning)}
        first, _, rest = self.meaning.partition(",")
        return {
            f"cos_{self.name}": Quantity("1", f"cosine of the {first}"),
            f"sin_{self.name}": Quantity("1", f"sine of the {self.meaning}" if rest else f"sine of the {first}"),
        }

    @property
    def particulars(self) -> dict[str, Quantity]:
        """What its sections of a ship file give to the terms."""
        return {
            part.known_as(number): quantity
            for part in self.parts
            if part.ASKED
            for number, quantity in part.NUMBERS.items()
            if number != self.name
        }

    @property
    def quantities(self) -> dict[str, Quantity]:
        """All that terms may ask of it."""
        return self.controls | self.particulars

    def placed(self, position: Number) -> dict[str, Number]:
        """Return a position as the terms ask for it."""
        if not self.angle:
            return {self.name: position}
        return {f"cos_{self.name}": np.cos(position), f"sin_{self.name}": np.sin(position)}

    def at_rest(self) -> dict[str, Number]:
        """Its position as the terms ask for it, where nothing is said of it; nothing where it must be said."""
        return {} if self.rest is None else self.placed(self.rest)


def places_of(actuators: Iterable[Actuator]) -> dict[str, str]:
    """Return the section and key that give each number of actuators in a file."""
    return {
        part.known_as(number): f"[{part.SECTION}] {number}"
        for actuator in actuators
        for part in actuator.parts
        for number in part.NUMBERS
    }


def free(names: Iterable[str]) -> dict[str, float]:
    """Return the limit and rate of actuators that have none."""
    return {f"{name}_{end}": math.inf for name in names for end in ENDS}
