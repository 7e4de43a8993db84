"""Status of the monitor at a time: the ship, the forecast, the alerts, and missing inputs."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from narrows.estimation.states import Estimate
from narrows.ship.particulars import Ship, half_swept
from narrows.warning.alerts.alert import ANY_SENSOR, HOLDS, LOG_LATE, SHIP_OR_WATER, SITUATIONS, Alert, Priority
from narrows.warning.forecasting.forecast import BankForecast
from narrows.warning.settings import NEAR_MISS
from narrows.waterway.waterway import Waterway

NOT_AVAILABLE, CLEAR, WATCH = "not available", "clear", "watch"
# Situations in which less is to be believed.
DOUBTS = tuple(one.identifier for one in (*ANY_SENSOR, SHIP_OR_WATER, LOG_LATE))


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
class BridgeStatus:
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
        return max((alert.priority for alert in self.alerts if alert.state in HOLDS), default=Priority.NONE)

    @property
    def word(self) -> str:
        """One word: never ``clear`` without a forecast, while a last chance counts down, or in a near miss."""
        if self.forecast is None:
            return NOT_AVAILABLE
        if self.level:
            return self.level.words
        return CLEAR if self.forecast.clear and self.clearance >= NEAR_MISS else WATCH

    @property
    def headline(self) -> str:
        if self.forecast is None:
            return self.why
        urgent = next((alert for alert in self.alerts if alert.state in HOLDS and alert.priority is self.level), None)
        return urgent.text if urgent else self.forecast.words()

    @property
    def caveats(self) -> tuple[str, ...]:
        doubts = (alert.text for alert in self.alerts if alert.identifier in DOUBTS and alert.state in HOLDS)
        return (*doubts, *self.limits)

    def line(self) -> str:
        parts = [f"{self.word:>15}"]
        if self.estimate.ready:
            now = self.estimate.values
            parts.append(f"x {now['x']:6.0f} m  y {now['y']:+6.1f} m  heading {math.degrees(now['psi']):+5.1f} deg")
            parts.append(f"clearance {self.clearance:5.1f} m")
        if forecast := self.forecast:
            parts.append(f"last chance {forecast.chance()}  helm {100 * forecast.unattended:3.0f} % unattended")
        return "  ".join(parts)

    def to_dict(self) -> dict[str, Any]:
        forecast = self.forecast.to_dict() if self.forecast else None
        said = {"status": self.word, "headline": self.headline, "caveats": list(self.caveats)}
        ends = {name: end._asdict() if end else None for name, end in zip(ENDS, self.clearances[2:], strict=True)}
        known = {
            "clearances": {**self.clearances._asdict(), **ends},
            "state": self.estimate.values,
            "forecast": forecast,
        }
        alerts = [alert_to_dict(one) for one in self.alerts]
        return {"t": self.t, **said, **known, "alerts": alerts, "faults": dict(self.faults)}


def alert_to_dict(alert: Alert) -> dict[str, Any]:
    words = {"name": SITUATIONS[alert.identifier].name, "priority": alert.priority.words, "state": alert.state.value}
    return {**vars(alert), **words}


ENDS = ("bow", "stern")


def clearances(ship: Ship, waterway: Waterway, estimate: Estimate) -> Clearances:
    """Return the water beside a hull, the banks as they are beside midship."""
    if not estimate.ready:
        return Clearances()
    now = estimate.values
    here = waterway.keel_section(min(max(now["x"], 0.0), waterway.line.length), ship.draft)
    off, room = now["y"] - float(here.middle), float(here.width) / 2 - float(half_swept(ship, now["psi"]))
    ends = [_hull_end(ship, waterway, now, place * ship.length / 2) for place in (1, -1)]
    return Clearances(room + off, room - off, *ends)


def _hull_end(ship: Ship, waterway: Waterway, now: Mapping[str, float], forward: float) -> HullEnd:
    along, across = math.cos(now["psi"]), math.sin(now["psi"])
    here = waterway.keel_section(min(max(now["x"] + forward * along, 0.0), waterway.line.length), ship.draft)
    room, off = float(here.width) / 2 - ship.beam / 2 * along, now["y"] + forward * across - float(here.middle)
    speed = now["u"] * across + (now["v"] + now["r"] * forward) * along
    return HullEnd(room + off, room - off, speed)
