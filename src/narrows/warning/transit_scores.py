"""Scores of recorded transits: how much time was left to act when each predictor warned, and how often in vain."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError
from narrows.results import BaseSummary
from narrows.warning.alerts.alert import Thresholds
from narrows.warning.monitoring.bridge_status import BridgeStatus
from narrows.warning.settings import (
    BEFORE_CONTACT,
    HYSTERESIS,
    LOWER_DELAY,
    NEEDED_TIME,
    QUIET_CLEARANCE,
    RAISE_DELAY,
    SCORED_CONTACT,
)

if TYPE_CHECKING:
    import pandas as pd

# Thresholds of predictors without a model: clearance [m], time to contact on a curved track [s], by warning_scores.py.
CLEARANCE, CURVED = 20.0, 40.0
LEVELS = ("caution", "warning", "alarm")
PREDICTORS = (f"distance to the bank, {CLEARANCE:g} m", f"curved by the rate of turn, {CURVED:g} s", *LEVELS)
# Times [s] that are one; water and times that are none.
SAME, LEAST = 1e-9, 1e-3


@dataclass(frozen=True)
class PredictorScore:
    predictor: str  # With its threshold, or a level of the monitor
    in_time: int  # Contacts before which it was raised with 10 s left to act
    left: float  # Median time left to act when it was raised before a contact; NaN without one [s]
    false: float  # Alerts that no contact followed, in 100 hours


@dataclass(frozen=True, repr=False)
class TransitScores(BaseSummary):
    contacts: int  # Transits with a contact
    clear: int  # Transits without one
    hours: float  # That were watched with a forecast [h]
    limit: float  # Clearance that counts as contact [m]
    rows: tuple[PredictorScore, ...]  # A predictor each
    left: dict[str, tuple[float, ...]]  # By transit with a contact: time left to act when each predictor was raised [s]
    unknown: tuple[str, ...]  # Transits without a forecast

    @property
    def notes(self) -> tuple[str, ...]:
        rule = (
            f"A contact is a clearance below {self.limit:g} m by the estimate; in time is an alert with "
            f"{NEEDED_TIME:g} s left to act by the monitor's own forecast; false is one that no contact follows in "
            f"{BEFORE_CONTACT:g} s."
        )
        few = ("A few transits determine these numbers poorly: see the intervals in docs/benchmarks.md.",)
        return (rule, *few, *(f"There was no forecast for {name}: it is left out." for name in self.unknown))

    def summary(self) -> str:
        met = f"{self.contacts} {'transit' if self.contacts == 1 else 'transits'} with a contact"
        lines = [f"{met}, {self.clear} without, {self.hours:.1f} h."]
        for row in self.rows:
            left = f", {row.left:.0f} s left to act (median)" if math.isfinite(row.left) else ""
            in_time = f"in time in {row.in_time} of {self.contacts}"
            lines.append(f"{row.predictor}: {in_time}{left}; {row.false:.0f} false alerts in 100 h.")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        counts = {"contacts": self.contacts, "clear": self.clear, "hours": self.hours, "limit": self.limit}
        left = {name: dict(zip(PREDICTORS, row, strict=True)) for name, row in self.left.items()}
        rows = [vars(row) for row in self.rows]
        return {"summary": self.summary(), **counts, "predictors": rows, "left": left, "notes": [*self.notes]}

    def to_dataframe(self) -> "pd.DataFrame":
        import pandas as pd

        return pd.DataFrame([vars(row) for row in self.rows]).set_index("predictor")


@dataclass(frozen=True, eq=False)
class ScoredTransit:
    name: str  # Name of the recording
    t: np.ndarray  # (seconds,) Since the watch began [s]
    urgencies: np.ndarray  # (seconds, predictors) Over their thresholds; NaN without a forecast [1]
    clearance: np.ndarray  # (seconds,) Estimated, to the nearer bank; NaN where unknown [m]
    last_chance: np.ndarray  # (seconds,) Last chance of the 95 % ship; negative where it has passed [s]

    def contact(self, limit: float) -> float:
        """Return when the clearance first was below a limit [s]; infinite where it never was."""
        below = self.clearance < limit
        return float(self.t[below.argmax()]) if below.any() else math.inf


def score_transits(transits: Sequence[ScoredTransit], limit: float = SCORED_CONTACT) -> TransitScores:
    if not 0.0 <= limit < QUIET_CLEARANCE:
        raise InputError(
            f"a clearance of {limit:g} m does not separate contacts from quiet sailing; give 0 to {QUIET_CLEARANCE:g} m"
        )
    known = [one for one in transits if np.isfinite(one.urgencies).any()]
    unknown = tuple(one.name for one in transits if not np.isfinite(one.urgencies).any())
    left: dict[str, tuple[float, ...]] = {}
    false, seconds = np.zeros(len(PREDICTORS)), 0.0
    for one in known:
        met = one.contact(limit)
        seconds += min(met, float(one.t[-1])) - float(one.t[0])
        spells = [alert_spells(one.t, column) for column in one.urgencies.T]
        false += [sum(not 0.0 <= met - start <= BEFORE_CONTACT and start < met for start, _ in own) for own in spells]
        if math.isfinite(met):
            left[one.name] = tuple(_left_at(one, met, own) for own in spells)
    table = np.array([*left.values()]).reshape(-1, len(PREDICTORS))
    hours = seconds / 3600.0
    rows = tuple(
        PredictorScore(
            name, int((table[:, k] >= NEEDED_TIME).sum()), float(np.median(table[:, k])) if len(table) else math.nan,
            float(100.0 * false[k] / hours) if hours else math.nan,
        )
        for k, name in enumerate(PREDICTORS)
    )  # fmt: skip
    return TransitScores(len(left), len(known) - len(left), hours, limit, rows, left, unknown)


def _left_at(one: ScoredTransit, met: float, spells: list[tuple[float, float]]) -> float:
    """Time left to act when the alert before a contact was raised [s]; 0 where it was gone, or there was none."""
    raised = [max(start, met - BEFORE_CONTACT) for start, end in spells if start < met and end >= met - BEFORE_CONTACT]
    if not raised:
        return 0.0
    left = float(one.last_chance[min(int(np.searchsorted(one.t, raised[0] - SAME)), len(one.t) - 1)])
    return max(left, 0.0) if math.isfinite(left) else BEFORE_CONTACT


class TransitScorer:
    """Collects what each predictor had to say in each second of a recording."""

    def __init__(self, name: str, thresholds: Thresholds) -> None:
        self.name, self.thresholds = name, thresholds
        self._rows: list[tuple[float, ...]] = []

    def add(self, status: BridgeStatus) -> None:
        room = status.clearance if status.estimate.ready else math.nan
        forecast = status.forecast
        if forecast is None:
            self._rows.append((status.t, room, math.nan, *(math.nan,) * len(PREDICTORS)))
            return
        left = max(forecast.level_time, LEAST)
        levels = (getattr(self.thresholds, level) / left for level in LEVELS)
        others = CLEARANCE / max(room, LEAST), CURVED / max(forecast.curved, LEAST)
        self._rows.append((status.t, room, forecast.last_chance, *others, *levels))

    def transit(self) -> ScoredTransit:
        table = np.array(self._rows, float).reshape(-1, 3 + len(PREDICTORS))
        return ScoredTransit(self.name, table[:, 0] - table[:1, 0], table[:, 3:], table[:, 1], table[:, 2])


def alert_spells(t: np.ndarray, urgency: np.ndarray) -> list[tuple[float, float]]:
    """Return from when to when an alert stands, by the rule of the monitor's levels; to infinity at the end [s]."""
    spells: list[tuple[float, float]] = []
    above = below = math.inf
    stands = False
    for now, value in zip(t.tolist(), urgency.tolist(), strict=True):
        above = min(above, now) if value >= 1.0 else above if math.isnan(value) else math.inf
        below = min(below, now) if value < HYSTERESIS else below if math.isnan(value) else math.inf
        if not stands and now - above >= RAISE_DELAY - SAME:
            stands = True
            spells.append((now, math.inf))
            below = math.inf
        elif stands and now - below >= LOWER_DELAY - SAME:
            stands, spells[-1] = False, (spells[-1][0], now)
    return spells
