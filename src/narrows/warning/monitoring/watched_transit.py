"""A transit as it was watched: what was known second by second, which alerts came, how near it went."""

import math
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.results import BaseResult
from narrows.ship.particulars import Configuration, Ship
from narrows.simulation.outcome import water_notes
from narrows.warning.alerts.alert import Alert, Priority
from narrows.warning.monitoring.bridge_status import BridgeStatus, alert_to_dict
from narrows.warning.settings import CONTACT_CLEARANCE, MOST_ALERTS, MOST_SECONDS, NEAR_MISS
from narrows.waterway.waterway import Waterway

if TYPE_CHECKING:
    import pandas as pd

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
        for priority in reversed(Priority):
            first = next((said for said in self.alerts if priority and said.alert.priority is priority), None)
            if first:
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
    if clearance <= CONTACT_CLEARANCE:
        how = "in contact with it" if clearance <= 0 else "in contact with it, or too near to tell"
        return f"At a bank after {t:.0f} s: {how}, as the sensors have it."
    miss = ", a near miss" if clearance < NEAR_MISS else ""
    return f"Nearest to a bank after {t:.0f} s: {clearance:.0f} m of water beside the hull{miss}."


class TransitLog:
    def __init__(self, configuration: Configuration, waterway: Waterway) -> None:
        self.configuration, self.waterway = configuration, waterway
        self._table, self._count = np.empty((MOST_SECONDS, len(COLUMNS))), 0
        self._alerts: deque[AlertText] = deque(maxlen=MOST_ALERTS)
        self._faults: dict[str, int] = {}
        self._began = math.nan

    def add(self, status: BridgeStatus) -> None:
        self._began = status.t if math.isnan(self._began) else self._began
        t = status.t - self._began
        self._table[self._count % MOST_SECONDS] = _row(t, status)
        self._count += 1
        self._alerts += [AlertText(t, alert) for alert in status.changed]
        self._faults = status.faults

    def transit(self) -> WatchedTransit:
        first = self._count % MOST_SECONDS if self._count > MOST_SECONDS else 0
        table = np.roll(self._table[: self._count], -first, axis=0)
        columns = dict(zip(COLUMNS, table.T, strict=True))
        ship, depth = self.configuration.ship, self.configuration.canal.depth
        return WatchedTransit(ship, self.waterway, columns, tuple(self._alerts), dict(self._faults), depth)


def _row(t: float, status: BridgeStatus) -> tuple[float, ...]:
    now, forecast = status.estimate.values, status.forecast
    state = tuple(now[name] if status.estimate.ready else math.nan for name in ("x", "y", "psi", "u"))
    clearance = status.clearance if status.estimate.ready else math.nan
    if forecast is None:
        return (t, *state, clearance, *(math.nan,) * 7, float(status.level))
    rudder = forecast.rudder, forecast.rudder_needed, forecast.rudder_margin
    times = forecast.likely.contact, max(forecast.last_chance, 0.0)
    return (t, *state, clearance, forecast.nobody, forecast.unattended, *times, *rudder, float(status.level))
