"""A model as its compiled equations and the numbers that go in: the one place that both voyages and fleets ask."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

from narrows.compile import Program, compiled
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.quantities.names import Number
from narrows.ship.actuators import PROPELLER, RUDDER
from narrows.simulation.inputs import check_options
from narrows.terms.term import TermTable

OPEN = "none"
"""The contact of a ship in open water."""
Outline = Sequence[Sequence[float]]
"""Points of the waterline: (forward of midship, to starboard) [m]."""


@dataclass(frozen=True)
class SimulatedShip:
    """A model with the choices that simulation leaves open.

    Parameters
    ----------
    model : Model
        The ship in her canal.
    surge : str
        ``held``: the speed stays; ``free``: it is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free``.
    coriolis : bool
        Add the rigid body's Coriolis force; the fitted damping at one speed holds it already.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
        ``none`` in open water.
    rudder : float [rad]
        Its angle, positive where it turns the bow to starboard.

    Raises
    ------
    InputError
        Where a choice is unknown, the terms need a propeller that is not there, the speed is free and no inertia in
        surge is known, or a bank is left out that the terms feel.
    """

    model: Model
    surge: str = "held"
    surge_inertia: float | None = None
    coriolis: bool = False
    contact: str | Outline = "corners"
    rudder: float = 0.0

    def __post_init__(self) -> None:
        check_options(self.surge, self.surge_inertia, self.coriolis, self.contact)
        if self.open_water and self.model.terms.feels_bank:
            raise InputError("contact 'none' is open water, and these terms feel the banks; choose 'corners'")
        if PROPELLER in self.model.terms.actuators and self.model.configuration.propeller is None:
            raise InputError("this model's terms need a propeller; give [propeller] in its file")
        if self.surge == "free" and not self.values()["surge_inertia"] + self.model.surge_inertia > 0:
            raise InputError(
                "this model has no mass in surge (its tests held the speed), so a free speed needs an inertia: "
                "give surge_inertia in kg, mass and added mass together, or hold the speed"
            )

    @property
    def open_water(self) -> bool:
        """Whether there are no banks."""
        return isinstance(self.contact, str) and self.contact == OPEN

    @property
    def program(self) -> Program:
        """The compiled equations, shared by all ships with the same terms."""
        if self.open_water:
            return _program(self.model.terms, self.surge, self.coriolis, "corners")
        shape = self.contact if isinstance(self.contact, str) else tuple(tuple(point) for point in self.contact)
        return _program(self.model.terms, self.surge, self.coriolis, shape)

    def values(self) -> dict[str, Number]:
        """Every particular and coefficient by name."""
        # The equations add this to the table's own mass in surge; the user gives the whole.
        added = 0.0 if self.surge_inertia is None else self.surge_inertia - self.model.surge_inertia
        rest = {name: at for own in self.model.terms.actuators for name, at in own.at_rest().items()}
        ship = {**rest, **self.model.configuration.values(), **self.model.coefficients}
        return {**ship, **helm(self.rudder), "heave": 0.0, "surge_inertia": added}

    def controls(self, rudder: float) -> tuple[float, float, float]:
        """Return rudder and propeller as the equations ask for them, cosine, sine and revolutions.

        Parameters
        ----------
        rudder : float [rad]
            Positive where it turns the bow to starboard.
        """
        return math.cos(rudder), math.sin(rudder), self._revolutions

    @cached_property
    def _revolutions(self) -> float:
        return float(self.model.configuration.values().get("revolutions", 0.0))

    @cached_property
    def constants(self) -> tuple[Number, ...]:
        """What stays the same through a voyage."""
        return self.program.constants(self.values())

    def __getstate__(self) -> Mapping[str, Any]:
        # Workers compile for themselves, or find it in the cache.
        return {name: value for name, value in self.__dict__.items() if name != "constants"}


def helm(rudder: Number) -> dict[str, Number]:
    """Return a rudder angle as the equations ask for it (ours).

    Parameters
    ----------
    rudder : number [rad]
        Positive where it turns the bow to starboard.
    """
    return RUDDER.placed(rudder)


@lru_cache(maxsize=32)
def _program(terms: TermTable, surge: Any, coriolis: bool, contact: Any) -> Program:
    return compiled(terms, surge, coriolis, contact)
