"""A transit before it is sailed: an aim that wanders and goes aside, the voyage of the most likely ship, its system."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.control.self_propulsion import self_propulsion
from narrows.errors import InputError
from narrows.logbook.steady_legs.steady_balance import felt_on
from narrows.logbook.transits.transit_conditions import TransitConditions, wandering
from narrows.logbook.transits.transit_filter import TransitSystem
from narrows.logbook.transits.transit_pilot import TransitPilot
from narrows.model.model import Model
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

AIMED = 0.2
"""Of the time of a ship length, that one piece of an aim is long."""
PIECES = 5
"""Of a schedule of gusts, in the time that a gust stays."""
STEPS, FINER = 20, 5
"""Of the system, in the time of a ship length, and of the voyage in one of them."""


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
    """A transit to look at.

    Parameters
    ----------
    model : Model
        The ship, of its most likely coefficients.
    u : float [m/s]
        Through the water.
    duration : float [s]
        How long.
    conditions : TransitConditions
        Wind, gusts, wander.
    waterway : Waterway, optional
        Instead of the model's own canal.
    """

    model: Model
    u: float
    duration: float
    conditions: TransitConditions
    waterway: "Waterway | None" = None

    def sailed(self, excursion: Excursion, seed: int) -> Voyage:
        """Return the voyage of a pilot who knows the ship.

        Parameters
        ----------
        excursion : Excursion
            From the middle.
        seed : int
            Of gusts and wander.

        Raises
        ------
        InputError
            Where it does not come through.
        """
        draw, told = np.random.default_rng((seed, 7)), self.conditions
        piece = AIMED * self.model.configuration.ship.length / self.u
        times = np.append(np.arange(0.0, self.duration, piece), self.duration)
        wander = wandering(told.wander, told.wander_time, piece, len(times), draw)[:, 0]
        pilot = TransitPilot.of(self.model, self.u, times, excursion.aims(times, wander), self.waterway)
        started: dict[str, Any] = {"y": float(pilot.aims[0]), "u": self.u, **self._pushes(draw), **self._turns()}
        voyage = simulate(
            self.model, duration=self.duration, dt=min(self._step / FINER, 2.0), waterway=self.waterway,
            controller=pilot, **started,
        )  # fmt: skip
        if voyage.t[-1] < 0.99 * self.duration and self.waterway is None:
            raise InputError(f"{excursion.words}: in these gusts the ship does not come through")
        return voyage

    def system(self, voyage: Voyage) -> TransitSystem:
        """Return the exact linear system along a voyage.

        Parameters
        ----------
        voyage : Voyage
            Of ``sailed``.
        """
        times = np.arange(0.0, voyage.t[-1], self._step)
        at = {name: np.interp(times, voyage.t, getattr(voyage, name)) for name in ("y", "psi", "u", "v", "r", "rudder")}
        at |= {name: np.full(len(times), number) for name, number in self._turns().items()}
        water = felt_on(self.model, np.full(len(times), self.u), {})
        if self.waterway is not None:
            here = self.waterway.section(np.interp(times, voyage.t, voyage.x))
            at["y"] = at["y"] - here.middle
            water["width"] = here.width
            water |= {} if np.isnan(here.depth).any() else {"depth": here.depth}
        return TransitSystem.along(self.model, water, at, self._step)

    @property
    def _step(self) -> float:
        return self.model.configuration.ship.length / self.u / STEPS

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
