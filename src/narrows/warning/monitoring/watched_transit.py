"""Status of the monitor at a time, and a transit as it was watched: what was known, which alerts, how near it went."""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.base.results import Aliased, BaseResult, BaseSummary
from narrows.estimation.states import Estimate
from narrows.ship.particulars import Configuration, Ship, half_swept
from narrows.simulation.outcome import water_notes
from narrows.warning import settings
from narrows.warning.alerts.alert import ANY_SENSOR, LOG_LATE, OTHER_DEPTH, SAME, Alert, BankLevel, Priority
from narrows.warning.forecasting.forecaster import BankForecast, level_time, water_beside
from narrows.waterway.waterway import Waterway

if TYPE_CHECKING:
    import pandas as pd


NOT_AVAILABLE, CLEAR, WATCH = "not available", "clear", "watch"
# Situations in which less is to be believed.
DOUBTS = tuple(one.identifier for one in (*ANY_SENSOR, OTHER_DEPTH, LOG_LATE))


class HullEnd(NamedTuple):
    """Water beside the bow or the stern, as far as the keel has room."""

    port: float  # [m]
    starboard: float  # [m]
    speed: float  # Across the waterway, to starboard [m/s]


class Clearances(NamedTuple):
    """Water between the hull's corners and the banks [m], infinite where it is not known."""

    port: float = math.inf
    starboard: float = math.inf
    bow: HullEnd | None = None
    stern: HullEnd | None = None


@dataclass(frozen=True)
class BridgeStatus(Aliased):
    t: float  # When [s]
    estimate: Estimate  # Estimate of the ship
    forecast: BankForecast | None  # Forecast; none where inputs are missing
    alerts: tuple[Alert, ...]  # That are not normal, the most urgent first
    changed: tuple[Alert, ...]  # That changed now
    clearances: Clearances  # Clearances of the hull to the banks [m]
    faults: dict[str, int]  # Messages that were left out so far, by what is wrong with them
    why: str = ""  # Why there is no forecast; empty where there is one
    limits: tuple[str, ...] = ()  # Conditions that the model's tests did not cover: a standing note

    @property
    def clearance(self) -> float:
        """Clearance of the hull to the nearer bank [m]."""
        return min(self.clearances.port, self.clearances.starboard)

    @property
    def level(self) -> Priority:
        """Level of the most urgent alert whose condition holds."""
        return max((alert.priority for alert in self.alerts if alert.holds), default=Priority.NONE)

    @property
    def word(self) -> str:
        """One word: never ``clear`` without a forecast, while a last chance counts down, or in a near miss."""
        if self.forecast is None:
            return NOT_AVAILABLE
        if self.level:
            return self.level.words
        return CLEAR if self.forecast.clear and self.clearance >= settings.NEAR_MISS else WATCH

    @property
    def headline(self) -> str:
        if self.forecast is None:
            return self.why
        urgent = next((alert for alert in self.alerts if alert.holds and alert.priority is self.level), None)
        return urgent.text if urgent else self.forecast.words()

    @property
    def caveats(self) -> tuple[str, ...]:
        doubts = (alert.text for alert in self.alerts if alert.identifier in DOUBTS and alert.holds)
        return (*doubts, *self.limits)

    def line(self) -> str:
        parts = [f"{self.word:>15}"]
        if self.estimate.ready:
            now = self.estimate.values
            parts.append(f"x {now['x']:6.0f} m  y {now['y']:+6.1f} m  heading {math.degrees(now['psi']):+5.1f} deg")
            parts.append(f"clearance {self.clearance:5.1f} m")
        if forecast := self.forecast:
            parts.append(f"last chance {forecast.time_left()}  helm {100 * forecast.unattended:3.0f} % unattended")
        return "  ".join(parts)

    def to_dict(self) -> dict[str, Any]:
        forecast = self.forecast.to_dict() if self.forecast else None
        said = {"status": self.word, "headline": self.headline, "caveats": list(self.caveats)}
        ends = {name: end and end._asdict() for name, end in zip(("bow", "stern"), self.clearances[2:], strict=True)}
        known = {"clearances": self.clearances._asdict() | ends, "state": self.estimate.values, "forecast": forecast}
        alerts = [alert_to_dict(one) for one in self.alerts]
        return {"t": self.t, **said, **known, "alerts": alerts, "faults": dict(self.faults)}


def alert_to_dict(alert: Alert) -> dict[str, Any]:
    words = {"name": alert.name, "priority": alert.priority.words, "state": alert.state.value}
    return {**vars(alert), **words}


def clearances(ship: Ship, waterway: Waterway, estimate: Estimate) -> Clearances:
    """Return the water beside a hull, the banks as they are beside midship."""
    if not estimate.ready:
        return Clearances()
    now, ends = estimate.values, []
    sides = water_beside(ship, waterway, now["x"], now["y"], half_swept(ship, now["psi"]))
    along, across = math.cos(now["psi"]), math.sin(now["psi"])
    for forward in (ship.length / 2, -ship.length / 2):
        x, y = now["x"] + forward * along, now["y"] + forward * across
        speed = now["u"] * across + (now["v"] + now["r"] * forward) * along
        port, starboard = water_beside(ship, waterway, x, y, ship.beam / 2 * along).tolist()
        ends.append(HullEnd(port, starboard, speed))
    return Clearances(*sides.tolist(), *ends)


DECISION_SUPPORT = "This is decision support, and no type-approved equipment; the watch is kept by people."
COLUMNS = (
    "t", "x", "y", "psi", "u", "clearance", "nobody", "unattended", "contact", "last_chance", "rudder", "rudder_needed",
    "rudder_margin", "level",
)  # fmt: skip


@dataclass(frozen=True)
class AlertText:
    t: float  # Since the watch began [s]
    alert: Alert  # As it was then


@dataclass(frozen=True, repr=False, eq=False)
class WatchedTransit(BaseResult):
    ship: Ship  # Its hull
    waterway: Waterway  # Waterway of the transit
    # (seconds,) By ``COLUMNS``, in SI; NaN where it was not known: t since the watch began; contact of the most likely
    # run and last chance of the 95 % ship, infinite where there is none, 0 where it is gone
    columns: dict[str, np.ndarray]
    alerts: tuple[AlertText, ...]  # Each time that one changed
    faults: dict[str, int]  # Messages that were left out, by what is wrong with them
    depth: float | None = None  # Depth of the model, for a waterway without one [m]

    @property
    def names(self) -> tuple[str, str]:
        return self.ship.name or "A ship", self.waterway.name

    @property
    def level(self) -> Priority:
        return max((said.alert.priority for said in self.alerts), default=Priority.NONE)

    @property
    def known(self) -> np.ndarray:
        return np.asarray(np.isfinite(self.columns["nobody"]))

    @property
    def located(self) -> np.ndarray:
        return np.asarray(np.isfinite(self.columns["x"]) & np.isfinite(self.columns["y"]))

    @property
    def notes(self) -> tuple[str, ...]:
        left = [f"{count} messages {what} were left out." for what, count in self.faults.items()]
        return (DECISION_SUPPORT, *water_notes(self.waterway, self.depth), *left)

    def summary(self) -> str:
        seconds, near = len(self.columns["t"]), self._nearest()
        lines = [f"{' on '.join(self.names)}: {seconds} seconds watched, {int(self.known.sum())} with a forecast."]
        firsts = {said.alert.priority: said for said in reversed(self.alerts) if said.alert.priority}
        for priority, first in sorted(firsts.items(), reverse=True):
            lines.append(f"First {priority.words} after {first.t:.0f} s: {first.alert.text}.".replace("..", "."))
        if near is not None:
            lines.append(_nearness(float(self.columns["t"][near]), float(self.columns["clearance"][near])))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        near, margin = self._nearest(), self.columns["rudder_margin"]
        ship, waterway = self.names
        return {
            "summary": self.summary(), "ship": ship, "waterway": waterway,
            "seconds": len(self.columns["t"]), "forecast": int(self.known.sum()), "level": self.level.words,
            "alerts": [{"t": said.t, **alert_to_dict(said.alert)} for said in self.alerts],
            "least_clearance": None if near is None else float(self.columns["clearance"][near]),
            "least_rudder_margin": float(np.nanmin(margin)) if np.isfinite(margin).any() else None,
            "faults": self.faults, "notes": list(self.notes),
        }  # fmt: skip

    def to_dataframe(self) -> "pd.DataFrame":
        import pandas as pd

        return pd.DataFrame(self.columns).set_index("t")

    def _nearest(self) -> int | None:
        clearance = self.columns["clearance"]
        return int(np.nanargmin(clearance)) if np.isfinite(clearance).any() else None


def _nearness(t: float, clearance: float) -> str:
    if clearance <= settings.CONTACT_CLEARANCE:
        how = "in contact with it" if clearance <= 0 else "in contact with it, or too near to tell"
        return f"At a bank after {t:.0f} s: {how}, as the sensors have it."
    miss = ", a near miss" if clearance < settings.NEAR_MISS else ""
    return f"Nearest to a bank after {t:.0f} s: {clearance:.0f} m of water beside the hull{miss}."


class TransitLog:
    def __init__(self, configuration: Configuration, waterway: Waterway) -> None:
        self.configuration, self.waterway = configuration, waterway
        # A ring of a day that is allocated once: memory does not grow during a watch.
        self._rows, self._count = np.empty((settings.MOST_SECONDS, len(COLUMNS))), 0
        self._alerts: deque[AlertText] = deque(maxlen=settings.MOST_ALERTS)
        self._faults: dict[str, int] = {}
        self._began = math.nan

    def add(self, status: BridgeStatus) -> None:
        self._began = status.t if math.isnan(self._began) else self._began
        t = status.t - self._began
        self._rows[self._count % len(self._rows)] = _row(t, status)
        self._count += 1
        self._alerts += [AlertText(t, alert) for alert in status.changed]
        self._faults = status.faults

    def transit(self) -> WatchedTransit:
        # In order of time: a full ring begins at the row that is overwritten next.
        rows = np.roll(self._rows[: self._count], -self._count, axis=0)
        columns = dict(zip(COLUMNS, rows.T, strict=True))
        ship, depth = self.configuration.ship, self.configuration.canal.depth
        return WatchedTransit(ship, self.waterway, columns, tuple(self._alerts), dict(self._faults), depth)


def _row(t: float, status: BridgeStatus) -> tuple[float, ...]:
    now, forecast, known = status.estimate.values, status.forecast, status.estimate.ready
    state = [now[name] if known else math.nan for name in ("x", "y", "psi", "u")]
    predicted = [math.nan] * 7
    if forecast:
        predicted = [forecast.nobody, forecast.unattended, forecast.likely.contact, max(forecast.last_chance, 0.0)]
        predicted += [forecast.rudder, forecast.rudder_needed, forecast.rudder_margin]
    return (t, *state, status.clearance if known else math.nan, *predicted, float(status.level))


# Scores of recorded transits: the time left to act when each predictor warned, and false alerts.
# Threshold of the predictor without a model [m], by warning_scores.py.
CLEARANCE = 20.0
LEVELS = tuple(reversed(settings.LEVELS.items()))
PREDICTORS = (f"distance to the bank, {CLEARANCE:g} m", *(level for level, _ in LEVELS))
LEAST = 1e-3  # Water [m] and times [s] that are none


@dataclass(frozen=True, repr=False)
class TransitScores(BaseSummary):
    contacts: int  # Transits with a contact
    clear: int  # Transits without one
    hours: float  # That were watched with a forecast [h]
    # By predictor, with its threshold, or level: contacts before which it was raised with 10 s left (``in_time``);
    # median time ``left`` to act when it was raised before a contact [s]; ``false`` alerts in 100 hours
    table: "pd.DataFrame"
    left: dict[str, tuple[float, ...]]  # By transit with a contact: time left to act when each predictor was raised [s]
    unknown: tuple[str, ...]  # Transits without a forecast

    @property
    def notes(self) -> tuple[str, ...]:
        rule = (
            f"A contact is a clearance below {settings.CONTACT_CLEARANCE:g} m by the estimate; in time is an alert "
            f"with {settings.NEEDED_TIME:g} s left to act by the monitor's own forecast; false is one without a "
            f"contact in {settings.BEFORE_CONTACT:g} s."
        )
        few = ("A few transits determine these numbers poorly: see the intervals in docs/benchmarks.md.",)
        return (rule, *few, *(f"There was no forecast for {name}: it is left out." for name in self.unknown))

    def summary(self) -> str:
        met = f"{self.contacts} {'transit' if self.contacts == 1 else 'transits'} with a contact"
        lines = [f"{met}, {self.clear} without, {self.hours:.1f} h."]
        for name, row in self.table.iterrows():
            left = f", {row['left']:.0f} s left to act (median)" if math.isfinite(row["left"]) else ""
            in_time = f"in time in {row['in_time']:.0f} of {self.contacts}"
            lines.append(f"{name}: {in_time}{left}; {row['false']:.0f} false alerts in 100 h.")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        return {
            "summary": self.summary(), "contacts": self.contacts, "clear": self.clear, "hours": self.hours,
            "limit": settings.CONTACT_CLEARANCE, "predictors": self.table.reset_index().to_dict("records"),
            "left": {name: dict(zip(PREDICTORS, row, strict=True)) for name, row in self.left.items()},
            "notes": list(self.notes),
        }  # fmt: skip


def score_transits(transits: Mapping[str, WatchedTransit]) -> TransitScores:
    import pandas as pd

    known = {name: one for name, one in transits.items() if one.known.any()}
    left: dict[str, tuple[float, ...]] = {}
    false, hours = np.zeros(len(PREDICTORS)), 0.0
    for name, one in known.items():
        t, below = one.columns["t"], one.columns["clearance"] < settings.CONTACT_CLEARANCE
        met = float(t[below.argmax()]) if below.any() else math.inf
        hours += (min(met, float(t[-1])) - float(t[0])) / 3600.0
        spells = [alert_spells(t, urgency) for urgency in _urgencies(one)]
        false += [sum(met - start > settings.BEFORE_CONTACT for start, _ in own) for own in spells]
        if math.isfinite(met):
            left[name] = tuple(_left_at(one, met, own) for own in spells)
    found = np.array([*left.values()]).reshape(-1, len(PREDICTORS))
    median = np.median(found, axis=0) if len(found) else math.nan
    columns = {"in_time": (found >= settings.NEEDED_TIME).sum(axis=0), "left": median}
    columns["false"] = 100.0 * false / hours if hours else math.nan
    unknown = tuple(name for name in transits if name not in known)
    table = pd.DataFrame(columns, index=pd.Index(PREDICTORS, name="predictor"))
    return TransitScores(len(left), len(known) - len(left), hours, table, left, unknown)


def _urgencies(one: WatchedTransit) -> list[np.ndarray]:
    """(seconds,) Of each predictor over its threshold; NaN without a forecast [1]."""
    columns = one.columns
    near = np.where(one.known, CLEARANCE / np.maximum(columns["clearance"], LEAST), math.nan)
    left = np.maximum(level_time(columns["last_chance"], columns["nobody"]), LEAST)
    return [near, *(time / left for _, time in LEVELS)]


def _left_at(one: WatchedTransit, met: float, spells: list[tuple[float, float]]) -> float:
    """Time left to act when the alert before a contact was raised [s]; 0 where it was gone, or there was none."""
    begin, t = met - settings.BEFORE_CONTACT, one.columns["t"]
    raised = [max(start, begin) for start, end in spells if start < met and end >= begin]
    if not raised:
        return 0.0
    left = float(one.columns["last_chance"][np.searchsorted(t, raised[0] - SAME)])
    return left if math.isfinite(left) else settings.BEFORE_CONTACT


def alert_spells(t: np.ndarray, urgency: np.ndarray) -> list[tuple[float, float]]:
    """Return from when to when an alert stands, by the rule of the monitor's levels; to infinity at the end [s]."""
    spells, level = list[tuple[float, float]](), BankLevel()
    for now, value in zip(t.tolist(), urgency.tolist(), strict=True):
        if math.isnan(value):
            continue
        stood = level.level
        stands = level.update(now, Priority(value >= 1.0), Priority(value >= settings.HYSTERESIS))
        if stands and not stood:
            spells.append((now, math.inf))
        elif stood and not stands:
            spells[-1] = spells[-1][0], now
    return spells
