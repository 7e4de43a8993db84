"""The forecast: contact if nobody acts, the last chance to act, the best manoeuvre now and its remaining risk."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from narrows.base.results import BaseSummary
from narrows.warning.settings import ATTENDED_SHARE, CLEAR_SHARE, HORIZON, TAKEOVERS, WRONG_ORDER_TIME

# Numbers of a forecast in ``to_dict``.
NUMBERS = (
    "t", "last_chance", "failing", "nobody", "unattended", "as_is", "wrong_order", "rudder",
    "rudder_needed", "rudder_limit", "rudder_margin",
)  # fmt: skip
NEARLY_HARD = 0.9  # Share of the rudder's limit [1] from which an order reads "hard"


@dataclass(frozen=True)
class LikelyRun:
    """The forecast from the mean of state and coefficients."""

    contact: float  # Time until contact with the rudder unchanged; infinite without contact [s]
    side: str  # Side of that bank; empty without contact
    last_chance: float  # Latest time of an escape that stays clear; negative if there is none [s]

    @property
    def gone(self) -> bool:
        return self.last_chance < 0.0


@dataclass(frozen=True)
class Escape:
    """The manoeuvre that keeps the most samples clear."""

    then: str  # Order after the first one
    order: float  # First order of the rudder [rad]
    limit: float  # Limit of the gear [rad]
    clearance: float  # Least clearance of the most likely ship [m]

    def words(self) -> str:
        side = "starboard" if self.order > 0 else "port"
        angle = abs(self.order)
        first = (
            f"Hard to {side}" if angle > NEARLY_HARD * self.limit else f"{math.degrees(angle):.0f} degrees to {side}"
        )
        return f"{first}, {self.then}"


class Tracks(NamedTuple):
    """Forecast tracks of a ship: each pose along the waterway and off its line [m], and the heading to it [rad]."""

    times: np.ndarray  # (times,) Times from now on [s]
    fan: np.ndarray  # (samples, some of the times, 3) Tracks with the rudder unchanged; they stop at contact
    as_is: np.ndarray  # (times, 3) Track of the most likely ship with the rudder unchanged
    escape: np.ndarray  # (times, 3) Track of the same ship with the escape


@dataclass(frozen=True, repr=False)
class BankForecast(BaseSummary):
    t: float  # Time of the forecast [s]
    likely: LikelyRun  # Most likely run
    last_chance: float  # Last chance of the 95 % ship: infinite beyond the horizon, negative where it has passed [s]
    failing: float  # Share of samples that meet a bank in spite of the best escape now [1]
    nobody: float  # Chance that a bank is met because nobody acts in time [1]
    unattended: float  # Chance that nobody is at the helm [1]
    as_is: float  # Chance of contact within the horizon with the rudder unchanged [1]
    wrong_order: float  # Last chance of the likely ship after an order hard over to the worse side now [s]
    escape: Escape  # Best manoeuvre now
    rudder: float  # Present rudder angle [rad]
    rudder_needed: float  # Rudder of the steady course here by the estimated bank [rad]; infinite if there is none
    rudder_limit: float  # Limit of the gear [rad]
    tracks: Tracks | None = None  # Tracks for the page

    @property
    def gone(self) -> bool:
        """Whether the last chance of the 95 % ship has passed."""
        return self.last_chance < 0.0

    @property
    def level_time(self) -> float:
        """Time that determines the alert level [s]: longer if somebody probably acts in time."""
        return float(level_time(self.last_chance, self.nobody))

    @property
    def clear(self) -> bool:
        """Whether there is no last chance, hardly a sample meets a bank, and a wrong order would leave time."""
        calm = self.last_chance == math.inf and self.as_is <= CLEAR_SHARE
        return calm and self.wrong_order >= WRONG_ORDER_TIME

    @property
    def side(self) -> str:
        """Side of the danger; empty where there is none."""
        return self.likely.side

    @property
    def rudder_margin(self) -> float:
        """Rudder left of the limit on the steady course [rad]; negative if it needs more."""
        return self.rudder_limit - abs(self.rudder_needed)

    @property
    def notes(self) -> tuple[str, ...]:
        return ("Contact with the rudder as it is happens only if nobody acts: it is no chance of grounding.",)

    def summary(self) -> str:
        return self.words()

    def time_left(self) -> str:
        if self.gone:
            return "gone"
        return (
            f"in {self.last_chance:.0f} s" if math.isfinite(self.last_chance) else f"later than {TAKEOVERS[-1]:.0f} s"
        )

    def words(self) -> str:
        """Text of the alert, in few words, the number first."""
        run = self.likely
        if not math.isfinite(self.last_chance):
            if self.wrong_order < WRONG_ORDER_TIME:
                return f"{max(self.wrong_order, 0.0):.0f} s to act after a wrong order hard over"
            return f"No contact within {HORIZON:.0f} s, rudder as it is"
        side = f" to {self.side}" if self.side else ""
        if self.gone:
            left = f"{run.contact:.0f} s to contact" if math.isfinite(run.contact) else "No time left"
            return f"{left}: bank{side}. {self.escape.words()}"
        return f"{self.last_chance:.0f} s to act: bank{side}. {self.escape.words()}"

    def to_dict(self) -> dict[str, Any]:
        numbers = {name: getattr(self, name) for name in NUMBERS}
        escape = {**vars(self.escape), "words": self.escape.words()}
        likely = {**vars(self.likely), "gone": self.likely.gone}
        return {"summary": self.summary(), **numbers, "likely": likely, "escape": escape, "notes": [*self.notes]}


def level_time(last_chance: np.ndarray | float, nobody: np.ndarray | float) -> np.ndarray:
    """Return the time until the last chance, up to ten times as long where somebody acts in time [s]."""
    return np.asarray(np.maximum(last_chance, 0.0) / (ATTENDED_SHARE + (1.0 - ATTENDED_SHARE) * nobody))
