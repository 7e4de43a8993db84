"""A transit before it is sailed: an aim that wanders and goes aside, and the voyage of the most likely ship."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.control.steady_course import self_propulsion
from narrows.errors import InputError
from narrows.logbook.learned_coefficient import ON_TWINS
from narrows.logbook.sensor_grades import SensorGrade
from narrows.logbook.settings import AIM_LENGTHS, GUST_PIECES, LONGEST_STEP, TRANSIT_STEPS
from narrows.logbook.transits.transit_conditions import TransitConditions, TransitPilot, wandering
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.results import BaseResult
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    import pandas as pd

    from narrows.waterway.waterway import Waterway


@dataclass(frozen=True)
class Excursion:
    """Offset that a pilot takes on purpose, and its duration."""

    words: str  # What it is like
    offset: float = 0.0  # How far; 0 for none [m]
    sides: tuple[int, ...] = ()  # 1 to starboard, -1 to port, one after the other, spread over the transit
    stay: float = 0.0  # How long on each [s]
    turn: float = 0.0  # How long an aim takes to get there [s]

    def aims(self, times: np.ndarray, wander: np.ndarray) -> np.ndarray:
        """Return where a pilot wants to be [m]: who goes aside on purpose does not go farther."""
        aim = wander.copy()
        for number, side in enumerate(self.sides):
            middle = times[-1] * (number + 0.5) / len(self.sides)
            edge = (self.stay / 2 + self.turn - np.abs(times - middle)) / self.turn
            aim += side * self.offset * np.clip(edge, 0.0, 1.0)
        return np.clip(aim, -self.offset, self.offset) if self.sides else aim


@dataclass(frozen=True)
class PlannedTransit:
    model: Model  # The ship, of its most likely coefficients
    u: float  # Through the water [m/s]
    duration: float  # How long [s]
    conditions: TransitConditions  # Wind, gusts, wander
    waterway: "Waterway | None" = None  # Instead of the model's own canal

    def sailed(self, excursion: Excursion, seed: int) -> Voyage:
        draw, told = np.random.default_rng((seed, 7)), self.conditions
        piece = AIM_LENGTHS * self.model.configuration.ship.length / self.u
        times = np.append(np.arange(0.0, self.duration, piece), self.duration)
        wander = wandering(told.wander, told.wander_time, piece, len(times), draw)[:, 0]
        pilot = TransitPilot.of(self.model, self.u, times, excursion.aims(times, wander), self.waterway)
        started: dict[str, Any] = {"y": float(pilot.aims[0]), "u": self.u, **self._pushes(draw), **self._turns()}
        step = min(self.model.configuration.ship.length / self.u / TRANSIT_STEPS, LONGEST_STEP)
        voyage = simulate(
            self.model, duration=self.duration, dt=step, waterway=self.waterway,
            controller=pilot, **started,
        )  # fmt: skip
        if voyage.t[-1] < 0.99 * self.duration and self.waterway is None:
            raise InputError(f"{excursion.words}: in these gusts the ship does not come through")
        return voyage

    def _turns(self) -> dict[str, float]:
        return {"revolutions": self_propulsion(self.model, self.u)} if self.model.terms.propelled else {}

    def _pushes(self, draw: np.random.Generator) -> dict[str, list[tuple[float, float]]]:
        """Gusts about no wind: what is steady moves the rudder alone."""
        piece, memory = self.conditions.gust_time / GUST_PIECES, self.conditions.gust_time
        times = np.arange(0.0, self.duration, piece).tolist()
        gusts = wandering(1.0, memory, piece, len(times), draw, 2) @ self.conditions.gust_push(self.model).T
        return {
            name: list(zip(times, column, strict=True)) for name, column in zip("YN", gusts.T.tolist(), strict=True)
        }


@dataclass(frozen=True)
class ForeseenTransit:
    """Expected information of transits of one kind."""

    excursion: Excursion  # Excursion from the middle; the first kind has none
    std: Mapping[str, np.ndarray]  # (transits,) Standard error of each target after so many, in the coefficient's unit


@dataclass(frozen=True, repr=False)
class Foresight(BaseResult):
    """Expected standard errors of coefficients.

    Parameters
    ----------
    kinds : tuple of ForeseenTransit
        Routine first, then with excursions; only routine where none is safe.
    transits : tuple of int
        How many are sailed.
    targets : tuple of str
        The coefficients.
    prior_std : mapping of str to float
        Their standard errors now.
    model : Model
        The ship.
    grade : SensorGrade
        Its sensors.
    conditions : TransitConditions
        Wind, gusts, wander of the aim.
    u : float [m/s]
        Through the water.
    duration : float [s]
        Duration of a transit.
    safe_offset : float [m]
        How far off the middle the safe envelope lets it go on purpose.
    reasons : tuple of str
        Why nothing is foretold, why no excursion is among the kinds.
    """

    kinds: tuple[ForeseenTransit, ...]
    transits: tuple[int, ...]
    targets: tuple[str, ...]
    prior_std: Mapping[str, float]
    model: Model
    grade: SensorGrade
    conditions: TransitConditions
    u: float
    duration: float
    safe_offset: float
    reasons: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<Foresight of {', '.join(self.targets)} by sensors {self.grade.name}>"

    @property
    def best(self) -> ForeseenTransit | None:
        """The kind that leaves least of the targets after the fewest transits; None where nothing is foretold."""
        return min(self.kinds, key=self._left, default=None)

    def _left(self, kind: ForeseenTransit) -> float:
        return float(
            sum((kind.std[name][0] / self.prior_std[name]) ** 2 for name in self.targets if self.prior_std[name])
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Reasons for missing forecasts, and assumptions."""
        taken = (
            f"Taken for granted: {self.conditions.summary()}; sensors {self.grade.summary()}; the terms of the model, "
            "the banks where the chart has them but for a zero, wind and zeros of each transit its own, no other ship."
        )
        return (*self.reasons, taken, ON_TWINS)

    def summary(self) -> str:
        """Expected error of each target by routine transits, and the most informative excursion."""
        if not self.kinds:
            return "\n".join((*self.reasons, ON_TWINS))
        routine, best = self.kinds[0], self.best
        after = " and ".join(map(str, self.transits))
        gains = "; ".join(
            f"{name} from {self.prior_std[name]:.2g} to {', '.join(f'{std:.2g}' for std in routine.std[name])}"
            for name in self.targets
        )
        lines = [f"Standard errors after {after} routine transits of {self.duration / 60:.0f} minutes at "
                 f"{self.u / KNOT:.3g} knots, sensors {self.grade.name}: {gains}."]  # fmt: skip
        if best is not None and best is not routine:
            helped = ", ".join(
                f"{name} {best.std[name][0]:.2g} instead of {routine.std[name][0]:.2g}" for name in self.targets
            )
            lines.append(f"Most is gained by {best.excursion.words}: after {self.transits[0]}, {helped}.")
        return "\n".join((*lines, *self.reasons, ON_TWINS))

    def rows(self) -> list[dict[str, Any]]:
        """Give a row for each kind and number of transits, with the standard error of each target."""
        return [
            {"excursion": kind.excursion.words, "offset": kind.excursion.offset, "transits": count}
            | {f"std {name}": float(kind.std[name][i]) for name in self.targets}
            for kind in self.kinds for i, count in enumerate(self.transits)
        ]  # fmt: skip

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the rows as a table."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name."""
        return {
            "summary": self.summary(),
            "speed": self.u / KNOT,
            "duration": self.duration,
            "sensors": self.grade.name,
            "safe_offset": self.safe_offset,
            "targets": dict(self.prior_std),
            "kinds": self.rows(),
            "notes": list(self.notes),
        }
