"""A transit before it is sailed: an aim that wanders and goes aside, and the voyage of the most likely ship."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.control.self_propulsion import self_propulsion
from narrows.errors import InputError
from narrows.logbook.transits.transit_conditions import TransitConditions, wandering
from narrows.logbook.transits.transit_pilot import TransitPilot
from narrows.model.model import Model
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# Of the time of a ship length, that one piece of an aim is long.
AIMED = 0.2
# Of a schedule of gusts, in the time that a gust stays.
PIECES = 5
# Of the voyage, in the time of a ship length; and how long one is at most [s].
STEPS, LONGEST_STEP = 100, 2.0


@dataclass(frozen=True)
class Excursion:
    """How far from the middle a pilot goes on purpose, and how long.

    Parameters
    ----------
    words : str
        What it is like.
    offset : float [m]
        How far; 0 for none.
    sides : tuple of int
        1 to starboard, -1 to port, one after the other, spread over the transit.
    stay : float [s]
        How long on each.
    turn : float [s]
        How long an aim takes to get there.
    """

    words: str
    offset: float = 0.0
    sides: tuple[int, ...] = ()
    stay: float = 0.0
    turn: float = 0.0

    def aims(self, times: np.ndarray, wander: np.ndarray) -> np.ndarray:
        """Return where a pilot wants to be [m]: who goes aside on purpose does not go farther.

        Parameters
        ----------
        times : array (n,) [s]
            Of a transit.
        wander : array (n,) [m]
            Of an aim about the middle.
        """
        aim = wander.copy()
        for number, side in enumerate(self.sides):
            middle = times[-1] * (number + 0.5) / len(self.sides)
            edge = (self.stay / 2 + self.turn - np.abs(times - middle)) / self.turn
            aim += side * self.offset * np.clip(edge, 0.0, 1.0)
        return np.clip(aim, -self.offset, self.offset) if self.sides else aim


@dataclass(frozen=True)
class PlannedTransit:
    """A transit to look at."""

    model: Model  # The ship, of its most likely coefficients
    u: float  # Through the water [m/s]
    duration: float  # How long [s]
    conditions: TransitConditions  # Wind, gusts, wander
    waterway: "Waterway | None" = None  # Instead of the model's own canal

    def sailed(self, excursion: Excursion, seed: int) -> Voyage:
        """Return the voyage of a pilot who knows the ship."""
        draw, told = np.random.default_rng((seed, 7)), self.conditions
        piece = AIMED * self.model.configuration.ship.length / self.u
        times = np.append(np.arange(0.0, self.duration, piece), self.duration)
        wander = wandering(told.wander, told.wander_time, piece, len(times), draw)[:, 0]
        pilot = TransitPilot.of(self.model, self.u, times, excursion.aims(times, wander), self.waterway)
        started: dict[str, Any] = {"y": float(pilot.aims[0]), "u": self.u, **self._pushes(draw), **self._turns()}
        step = min(self.model.configuration.ship.length / self.u / STEPS, LONGEST_STEP)
        voyage = simulate(
            self.model, duration=self.duration, dt=step, waterway=self.waterway,
            controller=pilot, **started,
        )  # fmt: skip
        if voyage.t[-1] < 0.99 * self.duration and self.waterway is None:
            raise InputError(f"{excursion.words}: in these gusts the ship does not come through")
        return voyage

    def _turns(self) -> dict[str, float]:
        """Of the propeller, where the terms ask for them."""
        return {"revolutions": self_propulsion(self.model, self.u)} if self.model.terms.propelled else {}

    def _pushes(self, draw: np.random.Generator) -> dict[str, list[tuple[float, float]]]:
        """Gusts about no wind: what is steady moves the rudder alone."""
        piece, memory = self.conditions.gust_time / PIECES, self.conditions.gust_time
        times = np.arange(0.0, self.duration, piece).tolist()
        gusts = wandering(1.0, memory, piece, len(times), draw, 2) @ self.conditions.gust_push(self.model).T
        return {
            name: list(zip(times, column, strict=True)) for name, column in zip("YN", gusts.T.tolist(), strict=True)
        }
