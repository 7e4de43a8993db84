"""The monitor: from what was told in a second to alerts, whatever came in."""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from narrows.errors import InputError
from narrows.estimation.estimate import Estimate
from narrows.estimation.estimator import Estimator
from narrows.estimation.sensors import CourseOverGround, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.warning import settings
from narrows.warning.alerts.alert import (
    BANK,
    BEYOND_DATA,
    CALM,
    LOG_LATE,
    NO_FORECAST,
    SENSORS,
    Alert,
    AlertDesk,
    BankLevel,
    Condition,
    Hysteresis,
    Priority,
    Situation,
    Thresholds,
)
from narrows.warning.alerts.alert_sentences import command_of
from narrows.warning.forecasting.forecast import BankForecast
from narrows.warning.forecasting.forecaster import Forecaster
from narrows.warning.forecasting.future_lanes import PredictedFan
from narrows.warning.inputs.bridge_readings import GROUND_LOG, BridgeReadings, Messages, Tick
from narrows.warning.monitoring.alert_publisher import AlertPublisher
from narrows.warning.monitoring.bridge_status import BridgeStatus, clearances
from narrows.waterway.waterway import Waterway


def bridge_sensors(antenna: tuple[float, float] = (0.0, 0.0)) -> list[Any]:
    forward, starboard = antenna
    receiver = Gnss(forward=forward, starboard=starboard), CourseOverGround(forward=forward, starboard=starboard)
    return [*receiver, Gyro(), RateOfTurn(), Log(), Log(settings.GROUND_LOG_NOISE, name=GROUND_LOG), RudderIndicator()]


@dataclass
class BridgeMonitor:
    model: Model  # The ship at its own size, with the terms of a rudder
    waterway: Waterway  # Where it sails, that knows where on earth it is
    line: float = 0.0  # That a pilot who takes over brings it to, to starboard of the waterway's line [m]
    antenna: tuple[float, float] = (0.0, 0.0)  # Of the position: forward and to starboard of midship [m]
    thresholds: Thresholds = field(default_factory=Thresholds)  # From when on a forecast is urgent
    members: int = 1000  # Of the ensemble
    publisher: AlertPublisher = field(default_factory=AlertPublisher)  # Logs and sends alerts

    def __post_init__(self) -> None:
        self.bridge = BridgeReadings(self.waterway, self.model.configuration.ship.draft)
        self.estimator = Estimator(self.model, bridge_sensors(self.antenna), waterway=self.waterway)
        self._foreteller = Forecaster(self.estimator, self.line, members=self.members)
        self.forecaster: Callable[[Estimate, Mapping[str, float]], BankForecast] = self._foreteller
        log = self.publisher.log
        self.desk = AlertDesk(log.alerts if log else ())
        self._level, self._health = BankLevel(self.thresholds), SensorHealth()
        self._beyond = Hysteresis()
        self._positions: dict[str, float] = {}
        self._began: float | None = None

    def prepare(self, u: float) -> None:
        """Compile what is not compiled yet, so that the first alert does not wait for it."""
        half = self.waterway.line.length / 2
        still = {"gyro": 0.0, "log": u, "rudder": 0.0}
        for t in range(3):
            estimate = self.estimator.update(float(t), {**still, "gnss": (half, self.line)})
        self.forecaster(estimate, {"rudder": 0.0})
        self.estimator.forget()

    def update(self, tick: Tick, since_1970: float) -> BridgeStatus:
        heard = self.bridge.heard(tick)
        self._began = tick.t if self._began is None else self._began
        estimate = self._estimated(heard)
        forecast, why = self._forecast(heard, estimate)
        conditions = self._conditions(heard, estimate, forecast, why)
        changed = [*self._commanded(tick, since_1970), *self.desk.update(tick.t, conditions)]
        self.publisher.publish(changed, since_1970)
        self.publisher.beat(tick.t, self.desk.alerts, forecast is not None)
        room = clearances(self.model.configuration.ship, self.waterway, estimate)
        return BridgeStatus(tick.t, estimate, forecast, self.desk.alerts, tuple(changed), room, heard.faults, why)

    def fan(self, status: BridgeStatus) -> PredictedFan:
        return self._foreteller.fan(status.estimate, self._positions)

    def _commanded(self, tick: Tick, since_1970: float) -> list[Alert]:
        changed = []
        for command in filter(None, map(command_of, tick.commands)):
            alert = self.desk.command(tick.t, *command)
            if alert is None:
                self.publisher.refuse(command, since_1970)
            else:
                changed.append(alert)
        return changed

    def _estimated(self, heard: Messages) -> Estimate:
        actuators = self.estimator.filter.actuators
        known = {
            name: reading
            for name, reading in heard.readings.items()
            if name in self.estimator.filter.sensors or name in actuators
        }
        self._positions |= {name: value for name, value in known.items() if name in actuators}  # type: ignore[misc]
        return self.estimator.update(heard.t, known)

    def _forecast(self, heard: Messages, estimate: Estimate) -> tuple[BankForecast | None, str]:
        """What will happen, or why that cannot be told."""
        if not estimate.ready:
            return None, estimate.notes[-1] if estimate.notes else "Nothing is known of the ship yet."
        if self._health.blind(heard):
            return None, "Too little has been told for too long."
        if not 0.0 <= estimate["x"] <= self.waterway.line.length:
            return None, f"The ship is not on {self.waterway.name}."
        start = time.monotonic()
        try:
            forecast = self.forecaster(estimate, self._positions)
        except InputError as error:
            return None, str(error)
        late = time.monotonic() - start
        return (
            (None, f"A forecast took {late:.1f} s, and was out of date.") if late > settings.PERIOD else (forecast, "")
        )

    def _conditions(
        self, heard: Messages, estimate: Estimate, forecast: BankForecast | None, why: str
    ) -> dict[Situation, Condition]:
        late = self.publisher.late
        conditions = {
            SENSORS: self._health.condition(heard, estimate),
            LOG_LATE: Condition(Priority.CAUTION, late) if late else CALM,
        }
        early = heard.t - (self._began or 0.0) < settings.GRACE
        conditions[NO_FORECAST] = CALM if forecast or early else Condition(Priority.WARNING, why)
        if estimate.ready:
            beyond = beyond_data(self.model, self.waterway, estimate, heard)
            conditions[BEYOND_DATA] = self._beyond.held(heard.t, beyond)
        if forecast:  # What is not available is not clear: without a forecast the alert stays what it was.
            level = self._level.update(heard.t, forecast)
            conditions[BANK] = Condition(level, forecast.words()) if level else CALM
        return conditions


def beyond_data(model: Model, waterway: Waterway, estimate: Estimate, heard: Messages) -> Condition:
    ship, now = model.configuration.ship, estimate.values
    here = waterway.section(min(max(now["x"], 0.0), waterway.line.length))
    asked = {"speed": now["u"], "abs_y": abs(now["y"] - float(here.middle)), "abs_psi": abs(now["psi"])}
    asked |= {"width_to_beam": float(here.width) / ship.beam, "depth_to_draft": float(here.depth) / ship.draft}
    known = {name: value for name, value in asked.items() if math.isfinite(value)}
    said = list(extrapolation(model.data_range, known))
    if heard.draft is not None and abs(heard.draft - ship.draft) > settings.DRAFT_TOLERANCE * ship.draft:
        said.append(f"The ship reports a draft of {heard.draft:g} m; its model is of {ship.draft:g} m.")
    if heard.depth is not None and abs(heard.depth - float(here.depth)) > settings.DEPTH_TOLERANCE * float(here.depth):
        charted = f"{waterway.name} has {float(here.depth):.1f} m here"
        said.append(f"The echo sounder tells {heard.depth:.1f} m of water; {charted}.")
    return Condition(Priority.CAUTION, " ".join(said)) if said else CALM


# Whether the sensors can be believed: silences, jumps that were refused, drifts.
# What a forecast cannot do without for long.
NEEDED = ("position", "heading", "rudder")


class SensorHealth:
    def __init__(self) -> None:
        self._began: float | None = None
        self._doubted: dict[str, float] = {}

    def condition(self, heard: Messages, estimate: Estimate) -> Condition:
        """Return a caution where a sensor is silent or doubted, a warning where nothing can be foretold for it."""
        self._doubted |= {f"{name} jumps": heard.t for name in estimate.refused}
        self._doubted |= {f"{name} drifts, or is led astray": heard.t for name in estimate.suspects}
        self._doubted = {what: t for what, t in self._doubted.items() if heard.t - t < settings.DOUBT_HOLD_TIME}
        said = [*self._silences(heard), *self._doubted]
        if not said:
            return CALM
        return Condition(Priority.WARNING if self.blind(heard) else Priority.CAUTION, "; ".join(said))

    def blind(self, heard: Messages) -> bool:
        """Return whether too much is unknown for too long to foretell anything."""
        return max(self._needed(heard).values()) > settings.BLIND_AFTER

    def _needed(self, heard: Messages) -> dict[str, float]:
        """How long ago each that is needed was told; of what never was, since the watch began."""
        self._began = heard.t if self._began is None else self._began
        return {what: heard.ages.get(what, heard.t - self._began) for what in NEEDED}

    def _silences(self, heard: Messages) -> list[str]:
        others = {
            what: age for what, age in heard.ages.items() if what not in NEEDED and age > settings.OTHER_SENSOR_SILENCE
        }
        late = {what: age for what, age in self._needed(heard).items() if age > settings.SENSOR_SILENCE} | others
        return [f"no {what} for {age:.0f} s" for what, age in late.items()]
