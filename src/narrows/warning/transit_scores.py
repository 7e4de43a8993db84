"""Scores of recorded transits: how much time was left to act when each predictor warned, and how often in vain."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError
from narrows.results import BaseSummary
from narrows.warning import settings
from narrows.warning.alerts.alert import Thresholds
from narrows.warning.forecasting.forecast import level_time
from narrows.warning.monitoring.watched_transit import WatchedTransit

if TYPE_CHECKING:
    import pandas as pd

# Threshold of the predictor without a model [m], by warning_scores.py.
CLEARANCE = 20.0
LEVELS = ("caution", "warning", "alarm")
PREDICTORS = (f"distance to the bank, {CLEARANCE:g} m", *LEVELS)
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
            f"{settings.NEEDED_TIME:g} s left to act by the monitor's own forecast; false is one without a contact in "
            f"{settings.BEFORE_CONTACT:g} s."
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


def score_transits(transits: Mapping[str, WatchedTransit], limit: float = settings.SCORED_CONTACT) -> TransitScores:
    if not 0.0 <= limit < settings.QUIET_CLEARANCE:
        raise InputError(
            f"a clearance of {limit:g} m does not separate contacts from quiet sailing; give 0 to "
            f"{settings.QUIET_CLEARANCE:g} m"
        )
    known = {name: one for name, one in transits.items() if one.known.any()}
    left: dict[str, tuple[float, ...]] = {}
    false, hours = np.zeros(len(PREDICTORS)), 0.0
    for name, one in known.items():
        t, below = one.columns["t"], one.columns["clearance"] < limit
        met = float(t[below.argmax()]) if below.any() else math.inf
        hours += (min(met, float(t[-1])) - float(t[0])) / 3600.0
        spells = [alert_spells(t, urgency) for urgency in _urgencies(one)]
        false += [sum(met - start > settings.BEFORE_CONTACT for start, _ in own) for own in spells]
        if math.isfinite(met):
            left[name] = tuple(_left_at(one, met, own) for own in spells)
    table = np.array([*left.values()]).reshape(-1, len(PREDICTORS))
    in_time = (table >= settings.NEEDED_TIME).sum(axis=0)
    median = np.median(table, axis=0) if len(table) else np.full(len(PREDICTORS), math.nan)
    often = 100.0 * false / hours if hours else np.full(len(PREDICTORS), math.nan)
    rows = tuple(map(PredictorScore, PREDICTORS, in_time.tolist(), median.tolist(), often.tolist()))
    unknown = tuple(name for name in transits if name not in known)
    return TransitScores(len(left), len(known) - len(left), hours, limit, rows, left, unknown)


def _urgencies(one: WatchedTransit) -> list[np.ndarray]:
    """(seconds,) Of each predictor over its threshold; NaN without a forecast [1]."""
    columns, thresholds = one.columns, Thresholds()
    near = np.where(one.known, CLEARANCE / np.maximum(columns["clearance"], LEAST), math.nan)
    left = np.maximum(level_time(columns["last_chance"], columns["nobody"]), LEAST)
    return [near, *(getattr(thresholds, level) / left for level in LEVELS)]


def _left_at(one: WatchedTransit, met: float, spells: list[tuple[float, float]]) -> float:
    """Time left to act when the alert before a contact was raised [s]; 0 where it was gone, or there was none."""
    begin, t = met - settings.BEFORE_CONTACT, one.columns["t"]
    raised = [max(start, begin) for start, end in spells if start < met and end >= begin]
    if not raised:
        return 0.0
    left = float(one.columns["last_chance"][min(int(np.searchsorted(t, raised[0] - SAME)), len(t) - 1)])
    return left if math.isfinite(left) else settings.BEFORE_CONTACT


def alert_spells(t: np.ndarray, urgency: np.ndarray) -> list[tuple[float, float]]:
    """Return from when to when an alert stands, by the rule of the monitor's levels; to infinity at the end [s]."""
    spells: list[tuple[float, float]] = []
    above = below = math.inf
    stands = False
    for now, value in zip(t.tolist(), urgency.tolist(), strict=True):
        above = min(above, now) if value >= 1.0 else above if math.isnan(value) else math.inf
        below = min(below, now) if value < settings.HYSTERESIS else below if math.isnan(value) else math.inf
        if not stands and now - above >= settings.RAISE_DELAY - SAME:
            stands = True
            spells.append((now, math.inf))
            below = math.inf
        elif stands and now - below >= settings.LOWER_DELAY - SAME:
            stands, spells[-1] = False, (spells[-1][0], now)
    return spells
