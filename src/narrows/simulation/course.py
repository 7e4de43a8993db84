"""Where a voyage goes: a straight canal, or a waterway seen at each place as the straight canal that it is there."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from narrows.compile import Limits
from narrows.quantities.names import Number
from narrows.simulation.integrate import Rate, State
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

Forces = tuple[float, float, float]
WIDEST = math.cos(Limits().heading)


@dataclass
class Course(ABC):
    """What a voyage asks of where it goes; x is along it, y to starboard of its line, the heading is to its line.

    Parameters
    ----------
    ship : SimulatedShip
        Who goes.
    """

    ship: SimulatedShip
    widest: ClassVar[float] = WIDEST
    """Cosine of the heading [1] at which she lies across."""

    @abstractmethod
    def rate(self, forces: Forces, turning: float) -> Rate:
        """Return the right-hand side under constant forces, the rudder turning steadily.

        Parameters
        ----------
        forces : three floats [N, N, N m]
            From elsewhere.
        turning : float [rad/s]
            Rate of the rudder.
        """

    @abstractmethod
    def bank_gap(self, state: State) -> float:
        """Room between hull and bank [m].

        Parameters
        ----------
        state : tuple of float
            Of the voyage.
        """

    @abstractmethod
    def lean(self, state: State) -> float:
        """Positive where the starboard bank is nearer [1].

        Parameters
        ----------
        state : tuple of float
            Of the voyage.
        """

    def gap(self, state: State) -> float:
        """Room between hull and bank, or to the end of the course [m].

        Parameters
        ----------
        state : tuple of float
            Of the voyage.
        """
        return self.bank_gap(state)


class Straight(Course):
    """The model's own canal, without end."""

    def rate(self, forces: Forces, turning: float) -> Rate:
        rhs, controls, constants = self.ship.program.rhs, self.ship.controls, self.ship.constants
        return lambda state: (*rhs(*state[:-1], *forces, *controls(state[-1]), *constants), turning)

    def bank_gap(self, state: State) -> float:
        return float(self.ship.program.gap(*state[1:4], *self.ship.constants))

    def lean(self, state: State) -> float:
        return float(self.ship.program.lean(*state[1:4], *self.ship.constants))


class OpenWater(Straight):
    """No banks, and no heading that is across."""

    widest: ClassVar[float] = -2.0

    def bank_gap(self, state: State) -> float:
        return math.inf

    def lean(self, state: State) -> float:
        return 0.0


@dataclass
class Along(Course):
    """A waterway: width, depth and the place of its middle change along it, its line turns, its water may flow.

    Parameters
    ----------
    ship : SimulatedShip
        Who goes.
    waterway : Waterway
        The waterway.
    """

    waterway: "Waterway"
    _known: dict[tuple[float, float], tuple[Number, ...]] = field(init=False, repr=False, default_factory=dict)

    def rate(self, forces: Forces, turning: float) -> Rate:
        rhs, current, controls = self.ship.program.rhs, self.waterway.current, self.ship.controls

        def derivatives(state: State) -> State:
            s, n, c, sine, u, v, r, rudder = state
            here = self.waterway.section(s)
            tail = (*forces, *controls(rudder), *self._constants(float(here.width), float(here.depth)))
            along, across, _, _, *accelerations = rhs(s, n - float(here.middle), c, sine, u, v, r, *tail)
            bend = float(here.curvature)
            pace = (along + current) / (1 - bend * n)
            turn = r - bend * pace
            return (pace, across, -turn * sine, turn * c, *accelerations, turning)

        return derivatives

    def bank_gap(self, state: State) -> float:
        return float(self.ship.program.gap(*self._seen(state)))

    def gap(self, state: State) -> float:
        return min(self.bank_gap(state), self.waterway.line.length - state[0])

    def lean(self, state: State) -> float:
        return float(self.ship.program.lean(*self._seen(state)))

    def _seen(self, state: State) -> tuple[Number, ...]:
        here = self.waterway.room(state[0], self.ship.model.configuration.ship.draft)
        return (state[1] - float(here.middle), *state[2:4], *self._constants(float(here.width), float(here.depth)))

    def _constants(self, width: float, depth: float) -> tuple[Number, ...]:
        """Those of the straight canal here; the last few are kept, for a step asks several times."""
        key = (width, depth)
        if key not in self._known:
            if len(self._known) > 64:
                self._known.clear()
            own = {} if math.isnan(depth) else {"depth": depth}
            self._known[key] = self.ship.program.constants({**self.ship.values(), "width": width, **own})
        return self._known[key]


def course_of(ship: SimulatedShip, waterway: "Waterway | None") -> Course:
    """Return where a ship goes (ours).

    Parameters
    ----------
    ship : SimulatedShip
        The ship.
    waterway : Waterway, optional
        The model's own straight canal unless given.

    Raises
    ------
    InputError
        Where she does not fit the waterway.
    """
    if waterway is None:
        return OpenWater(ship) if ship.open_water else Straight(ship)
    waterway.check_fits(ship.model.configuration.ship)
    return Along(ship, waterway)
