"""A model: a ship in a canal, a table of terms, their coefficients, and how far they can be trusted."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from numbers import Real
from operator import add
from types import MappingProxyType

import numpy as np

from narrows.errors import InputError, did_you_mean, shown
from narrows.model.data_range import DataRange
from narrows.quantities.names import Number
from narrows.ship.motion import Motion
from narrows.ship.particulars import Configuration
from narrows.terms.bank_forms import without_bank
from narrows.terms.term import Term, TermTable

NO_SUCTION = "The model's coefficients of the bank are 0: the banks of a canal end a voyage, and do nothing before."


@dataclass(frozen=True)
class Source:
    """Where numbers come from.

    Parameters
    ----------
    text : str
        A citation, or how they were made.
    table : str
        File name of the table of tests.
    sha256 : str
        Hash of that file.
    """

    text: str = ""
    table: str = ""
    sha256: str = ""


def _is_finite(value: object) -> bool:
    try:
        return not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)
    except OverflowError:  # An integer of more digits than floats have.
        return False


@dataclass(frozen=True)
class Model:
    """A bank-effect model: what a fit gives and what simulation takes.

    Parameters
    ----------
    configuration : Configuration
        Ship, canal and water.
    terms : TermTable
        The terms.
    coefficients : mapping of str to float
        One value for each term, in the term's own SI unit.
    covariance : array (n, n), optional
        Of the coefficients, in the order of ``terms.names``.
    data_range : DataRange
        What the data covered.
    source : Source
        Where the numbers come from.

    Raises
    ------
    InputError
        Where a coefficient is missing, unknown or not finite.
    """

    configuration: Configuration
    terms: TermTable
    coefficients: Mapping[str, float]
    covariance: np.ndarray | None = None
    data_range: DataRange = field(default_factory=DataRange)
    source: Source = field(default_factory=Source)

    def __post_init__(self) -> None:
        names = self.terms.names
        for name, value in self.coefficients.items():
            if name not in names:
                hint = did_you_mean(name, names)
                raise InputError(f"unknown coefficient {name!r}{hint}")
            if not _is_finite(value):
                raise InputError(f"coefficient {name} = {shown(value)} is not a finite number; give its value")
        for name in names:
            if name not in self.coefficients:
                raise InputError(f"coefficient {name} is missing; add it, or choose a table without its term")

    def with_coefficients(self, **values: float) -> "Model":
        """Return the model with some coefficients changed.

        Parameters
        ----------
        **values : float
            New values by name.
        """
        return replace(self, coefficients={**self.coefficients, **values})

    def forces(
        self, motion: Motion, rudder: Number | None = None, revolutions: Number | None = None, **others: Number
    ) -> dict[str, Number]:
        """Evaluate surge force [N], sway force [N] and yaw moment [N m] on the towing rig.

        Parameters
        ----------
        motion : Motion
            Floats or columns.
        rudder : number [rad], optional
            Its angle, positive where it turns the bow to starboard, floats or columns; amidships unless given.
        revolutions : number [1/s], optional
            Of the propeller; those of the setting unless given.
        **others : number
            Positions of other actuators that the terms ask for, by name and in their units; at rest unless given.

        Raises
        ------
        InputError
            Where a term needs a particular that the setting does not give, or there is no such actuator.
        """
        asked = {"rudder": rudder, "revolutions": revolutions, **others}
        values = self._values(motion, {name: position for name, position in asked.items() if position is not None})
        return {force: self._sum(terms, values) for force, terms in self.terms.forces.items()}

    def bank_forces(self, motion: Motion) -> dict[str, Number]:
        """Evaluate the part of each force that the banks make [N, N, N m].

        Parameters
        ----------
        motion : Motion
            Floats or columns.
        """
        values = self._values(motion)
        return {
            force: self._sum([term for term in terms if term.from_bank], values)
            for force, terms in self.terms.forces.items()
        }

    @property
    def feels_bank(self) -> bool:
        """Whether the banks make a force: whether it has terms of the bank, and one of them counts for something."""
        return any(term.from_bank and self.coefficients[term.name] for term in self.terms.terms)

    @property
    def bank_note(self) -> str:
        """What to say first to whoever asks about a canal; nothing where the model feels the banks."""
        return "" if self.feels_bank else self.terms.bank_note or NO_SUCTION

    def in_open_water(self) -> "Model":
        """Return the model without the terms of the banks; itself where it has none."""
        if not self.terms.feels_bank:
            return self
        terms = without_bank(self.terms)
        place = [self.terms.names.index(name) for name in terms.names]
        return replace(
            self,
            terms=terms,
            coefficients={name: self.coefficients[name] for name in terms.names},
            covariance=None if self.covariance is None else self.covariance[np.ix_(place, place)],
        )

    def _values(self, motion: Motion, positions: Mapping[str, Number] = MappingProxyType({})) -> dict[str, Number]:
        values = {**self.configuration.values(), **motion.values()}
        movers = {own.name: own for own in self.terms.actuators}
        for name in positions:
            if name not in movers:
                hint = did_you_mean(name, movers) if movers else "; leave it out"
                raise InputError(f"the terms of this model have no actuator {name!r}{hint}")
        for name, own in movers.items():
            position = positions.get(name, values.get(name, own.rest))
            values |= {} if position is None else own.placed(position)
        for name in self.terms.inputs:
            if name not in values:
                raise InputError(f"the terms of this model need {name}; give it in the ship file")
        return values

    @property
    def surge_inertia(self) -> float:
        """What the terms resist a surge acceleration with [kg]."""
        values = self._values(Motion.at(u=1.0, udot=1.0), {own.name: 0.0 for own in self.terms.actuators})
        still = {**values, "udot": 0.0}
        slopes = ((term.name, term.column(values) - term.column(still)) for term in self.terms.surge)
        return -float(sum(self.coefficients[name] * slope for name, slope in slopes))

    def _sum(self, terms: tuple[Term, ...] | list[Term], values: Mapping[str, Number]) -> Number:
        # Not by sum(): from Python 3.12 it compensates floats but not columns, which then differ by a rounding.
        return reduce(add, (self.coefficients[term.name] * term.column(values) for term in terms), 0.0)
