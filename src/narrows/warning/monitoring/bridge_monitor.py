"""The monitor: from the messages of a second to alerts, whatever they contain; the same for Python."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

import narrows
from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.results import Aliased
from narrows.estimation.estimator import Estimator, checked_readings
from narrows.estimation.sensors import CourseOverGround, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from narrows.estimation.states import Estimate
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.model.water import speeds_afloat
from narrows.quantities.names import KNOT
from narrows.readers.nmea import Entry, NmeaDecoder, sentences
from narrows.ship.checks import is_finite
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.warning import settings
from narrows.warning.alerts.alert import (
    ANY_SENSOR,
    BANKS,
    CALM,
    LOG_LATE,
    NO_FORECAST,
    OTHER_DEPTH,
    OTHER_SENSORS,
    SENSORS,
    Alert,
    AlertCommand,
    AlertDesk,
    BankLevel,
    Condition,
    Priority,
    Situation,
    level_of,
)
from narrows.warning.forecasting.forecaster import BankForecast, Forecaster
from narrows.warning.forecasting.helmsman import Helmsmen
from narrows.warning.inputs.bridge_readings import GROUND_LOG, NEEDED, BridgeReadings, Messages, Tick
from narrows.warning.monitoring.alert_publisher import AlertPublisher, arc
from narrows.warning.monitoring.watched_transit import BridgeStatus, clearances
from narrows.waterway.waterway import Waterway, straight_waterway


@dataclass
class BridgeMonitor:
    model: Model  # The ship at its own size, with the terms of a rudder
    waterway: Waterway  # Waterway with its place on earth
    line: float = 0.0  # Offset to which the escape steers, to starboard of the waterway's line [m]
    antenna: tuple[float, float] = (0.0, 0.0)  # Place of the antenna: forward and to starboard of midship [m]
    members: int = 1000  # Size of the ensemble
    publisher: AlertPublisher = field(default_factory=AlertPublisher)  # Logs and sends alerts
    live: bool = True  # True where a forecast that takes longer than a second is out of date

    def __post_init__(self) -> None:
        self.bridge = BridgeReadings(self.waterway, self.model.configuration.ship.draft)
        forward, starboard = self.antenna
        receiver = Gnss(forward=forward, starboard=starboard), CourseOverGround(forward=forward, starboard=starboard)
        sensors: list[Any] = [*receiver, Gyro(settings.GYRO_NOISE), RateOfTurn(settings.TURN_NOISE), Log()]
        sensors.append(Log(settings.GROUND_LOG_NOISE, name=GROUND_LOG))
        self.estimator = Estimator(self.model, [*sensors, RudderIndicator()], waterway=self.waterway)
        self.forecaster: Callable[..., BankForecast] = Forecaster(self.estimator, self.line, members=self.members)
        self.helmsman = Helmsmen(1, self.model.configuration.ship.length)
        log = self.publisher.log
        self.desk = AlertDesk(log.alerts if log else ())
        known = {side: self.desk[bank] for side, bank in BANKS.items()}
        self._levels = {
            side: BankLevel(alert.priority if alert.holds else Priority.NONE) for side, alert in known.items()
        }  # After a restart an alert is not over before a forecast was calm for as long as ever.
        self._cautions = Cautions()
        self._positions: dict[str, float] = {}
        self._began: float | None = None

    def prepare(self, u: float) -> None:
        """Compile what is not compiled yet, so that the first alert does not wait for it."""
        half = self.waterway.line.length / 2
        still = {"gyro": 0.0, "log": u, "rudder": 0.0}
        for t in range(3):
            estimate = self.estimator.update(float(t), {**still, "gnss": (half, self.line)})
        self.forecaster(estimate, {"rudder": 0.0}, self.helmsman)
        self.estimator.forget()

    def update(self, tick: Tick, since_1970: float) -> BridgeStatus:
        return self.watch(self.bridge.convert(tick), since_1970, tick.commands)

    def watch(self, messages: Messages, since_1970: float, commands: Sequence[AlertCommand] = ()) -> BridgeStatus:
        t = messages.t
        self._began = t if self._began is None else self._began
        actuators = self.estimator.filter.actuators
        known = {n: one for n, one in messages.readings.items() if n in (*self.estimator.filter.sensors, *actuators)}
        self._positions |= {name: value for name, value in known.items() if name in actuators}  # type: ignore[misc]
        estimate = self.estimator.update(messages.t, known)
        if estimate.ready:
            now = {name: np.array([value]) for name, value in estimate.values.items()}
            bend = self.waterway.line.curvature(min(max(estimate["x"], 0.0), self.waterway.line.length))
            rudder = np.array([self._positions.get("rudder", 0.0)])
            self.helmsman.update(now["y"], now["psi"], now["r"] - float(bend) * now["u"], now["u"], rudder)
        forecast, why = self._forecast(messages, estimate)
        conditions = self._conditions(messages, estimate, forecast, why)
        changed = []
        for command in commands:
            if alert := self.desk.command(t, *command):
                changed.append(alert)
            else:
                self.publisher.send(arc(command, since_1970))
        changed += self.desk.update(t, conditions)
        self.publisher.publish(changed, since_1970)
        self.publisher.beat(t, self.desk.alerts, forecast is not None)
        room = clearances(self.model.configuration.ship, self.waterway, estimate)
        limits = extrapolations(self.model, self.waterway, estimate) if estimate.ready else ()
        return BridgeStatus(t, estimate, forecast, self.desk.alerts, tuple(changed), room, messages.faults, why, limits)

    def _forecast(self, messages: Messages, estimate: Estimate) -> tuple[BankForecast | None, str]:
        if not estimate.ready:
            return None, estimate.notes[-1] if estimate.notes else "No estimate of the ship yet."
        if blind(messages):
            return None, "Sensors have been silent for too long."
        if not 0.0 <= estimate["x"] <= self.waterway.line.length:
            return None, f"The ship is not on {self.waterway.name}."
        start = time.monotonic()
        try:
            forecast = self.forecaster(estimate, self._positions, self.helmsman)
        except InputError as error:
            return None, str(error)
        late = time.monotonic() - start
        if self.live and late > settings.PERIOD:
            return None, f"A forecast took {late:.1f} s, and was out of date."
        return forecast, ""

    def _conditions(
        self, messages: Messages, estimate: Estimate, forecast: BankForecast | None, why: str
    ) -> dict[Situation, Condition]:
        late = self.publisher.late
        depth = other_depth(self.waterway, estimate, messages) if estimate.ready else ""
        conditions = self._cautions.conditions(messages, estimate, depth)
        if not estimate.ready:  # No estimate is no agreement: the alert stays as it was.
            del conditions[OTHER_DEPTH]
        conditions[LOG_LATE] = Condition(Priority.CAUTION, late) if late else CALM
        early = messages.t - (self._began or 0.0) < settings.GRACE
        conditions[NO_FORECAST] = CALM if forecast or early else Condition(Priority.WARNING, why)
        if forecast:  # No forecast is not a clear forecast: the alert stays as it was.
            side = forecast.side
            for name, bank in BANKS.items():
                wanted, eased = (level_of(forecast, ease) if name == side else Priority.NONE for ease in EASES)
                level = self._levels[name].update(messages.t, wanted, eased)
                text = forecast.words() if name == side else self.desk[bank].text
                conditions[bank] = Condition(level, text) if level else CALM
        return conditions


EASES = 1.0, settings.HYSTERESIS
NO_BOTTOM = (
    "From {:.1f} knots the ship touches the bottom here by its squat, or chokes the section: no forecast has it."
)


def extrapolations(model: Model, waterway: Waterway, estimate: Estimate) -> tuple[str, ...]:
    """Return the conditions here and now that the model's tests did not cover."""
    ship, now = model.configuration.ship, estimate.values
    here = waterway.section(min(max(now["x"], 0.0), waterway.line.length))
    asked = {"speed": now["u"], "abs_y": abs(now["y"] - float(here.middle)), "abs_psi": abs(now["psi"])}
    asked |= {"width_to_beam": float(here.width) / ship.beam, "depth_to_draft": float(here.depth) / ship.draft}
    known = {name: value for name, value in asked.items() if math.isfinite(value)}
    water = {**model.configuration.values(), "width": here.width, "depth": here.depth}
    fastest = min(speeds_afloat(water)) if math.isfinite(here.depth) else math.inf
    bottom = (NO_BOTTOM.format(fastest / KNOT),) if abs(now["u"]) > fastest else ()
    return (*extrapolation(model.data_range, known, unknown=True), *bottom)


def other_depth(waterway: Waterway, estimate: Estimate, messages: Messages) -> str:
    depth = float(waterway.section(min(max(estimate["x"], 0.0), waterway.line.length)).depth)
    if messages.depth is None or abs(messages.depth - depth) <= settings.DEPTH_TOLERANCE * depth:
        return ""
    return f"the echo sounder reads {messages.depth:.1f} m of water; {waterway.name} has {depth:.1f} m"


# Quantity that each sensor of the estimator measures.
MEASURES = {
    "gnss": "position", "course": "speed over ground", "gyro": "heading", "rate_of_turn": "yaw rate",
    "log": "speed through the water", GROUND_LOG: "speed over ground",
}  # fmt: skip


class Cautions:
    """Cautions on sensors and water; doubts and differences are shown for a while after they last held."""

    def __init__(self) -> None:
        self._held: dict[tuple[Situation, str], tuple[float, str]] = {}  # When it last held, and in words

    def conditions(self, messages: Messages, estimate: Estimate, depth: str) -> dict[Situation, Condition]:
        """Return a caution for each sensor that is silent or doubted, a warning where it ends the forecasts."""
        for names, words in ((estimate.refused, "jumps"), (estimate.suspects, "drifts, or is led astray")):
            for name in names:
                situation = SENSORS.get(MEASURES.get(name, name), OTHER_SENSORS)
                self._held[situation, name + words] = messages.t, f"{name} {words}"
        if depth:
            self._held[OTHER_DEPTH, ""] = messages.t, depth
        self._held = {what: one for what, one in self._held.items() if messages.t - one[0] < settings.HOLD_TIME}
        said: dict[Situation, list[str]] = {one: [] for one in (*ANY_SENSOR, OTHER_DEPTH)}
        for what, age in messages.ages.items():
            if age > (settings.SENSOR_SILENCE if what in NEEDED else settings.OTHER_SENSOR_SILENCE):
                said[SENSORS.get(what, OTHER_SENSORS)].append(f"no {what} for {age:.0f} s")
        for (situation, _), (_, words) in self._held.items():
            said[situation].append(words)
        priorities = dict.fromkeys((SENSORS[what] for what in blind(messages)), Priority.WARNING)
        return {
            one: Condition(priorities.get(one, Priority.CAUTION), "; ".join(words)) if words else CALM
            for one, words in said.items()
        }


def blind(messages: Messages) -> list[str]:
    """Return what has been unknown for too long to forecast anything."""
    return [what for what in NEEDED if messages.ages[what] > settings.BLIND_AFTER]


CANAL_LENGTHS = 200.0  # Length of the model's own canal as a waterway [ship lengths]
# Sensor of each state that is given by its name.
SENSOR_OF = {"psi": "gyro", "u": "log", "r": "rate_of_turn"}


class Monitor(Aliased):
    """Bank warnings for a ship: the engine of ``narrows monitor``; decision support, not type-approved equipment.

    Raises an InputError if the model has no rudder, or the compiler (the extra ``compiled``) is missing.

    Parameters
    ----------
    model : Model
        The ship at its own size, with the terms of a rudder.
    waterway : Waterway, optional
        Default: the model's own canal, straight.
    line : float [m]
        Offset from the line of the waterway to which the escape manoeuvre steers.
    members : int
        Number of samples of a forecast.

    Examples
    --------
    >>> monitor = nw.Monitor("estimated_kcs", members=50)
    >>> for t in range(6):
    ...     status = monitor.update(t, x=1000.0 + 4.0 * t, y=100.0, psi=0.0, u=4.0, r=0.0, rudder=0.0)
    >>> status.word, monitor.alerts
    ('watch', ())
    """

    @accept_aliases
    def __init__(
        self, model: Model, waterway: Waterway | None = None, line: float = 0.0, members: int = settings.MEMBERS
    ) -> None:
        check_waterway(waterway)
        line = finite_numbers(line=line)["line"]
        water = waterway or straight_waterway(model.canal, CANAL_LENGTHS * model.ship.length)
        # Only sentences need a place on earth.
        self._is_placed = water.origin is not None
        placed = water if self._is_placed else replace(water, origin=(0.0, 0.0))
        self.engine = BridgeMonitor(model, placed, line, members=members, live=False)
        self.status: BridgeStatus | None = None
        self._decoder: NmeaDecoder | None = None
        self._last: dict[str, float] = {}

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """Alerts that are not normal, the most urgent first."""
        return self.status.alerts if self.status else ()

    def update(self, t: float, readings: Any = None, **named: Any) -> BridgeStatus:
        """Use the ``readings`` of a second ending at ``t`` [s]; return estimate, forecast and alerts.

        They are NMEA 0183 sentences, or numbers along the waterway by the names of sensors, as for
        ``Estimator.update``, or of states: x, y [m], psi, rudder [rad], u [m/s] through the water, r [rad/s]; also by
        keyword (``named``). Raises an InputError for an unknown name, what is no reading or time, and for a sentence
        without a place on earth.
        """
        if not is_finite(t):
            raise InputError(f"t = {shown(t)} is no time; give seconds, then the readings")
        if self.status and t < self.status.t:
            raise InputError(f"t = {t:g} s is before the last readings; make a new Monitor for another recording")
        if readings is None or isinstance(readings, Mapping | pd.Series):
            messages = self._messages(t, {**({} if readings is None else readings), **named})
        else:
            lines = [readings] if isinstance(readings, str | bytes) else readings
            if named or not (isinstance(lines, Sequence) and all(isinstance(line, str | bytes) for line in lines)):
                raise InputError(f"readings = {shown(readings)}: give sentences, or else numbers by name")
            messages = self._decoded(t, lines)
        self.status = self.engine.watch(messages, t)
        return self.status

    @accept_aliases
    def run(self, log: Any) -> tuple[Alert, ...]:
        """Use a recording second by second, and return each alert as it was raised, in order; ``status`` is the last.

        ``log`` is a ``ShipLog``, a record, or what ``read_log`` reads: positions along the waterway of the monitor.
        """
        raised: list[Alert] = []
        records = [log] if hasattr(log, "signals") else log if hasattr(log, "records") else narrows.read_log(log)
        for record in records:
            table = record.to_dataframe()
            table = table[[name for name in table if name in ("x", "y", "rudder", "revolutions", *SENSOR_OF)]]
            rows = table.groupby(np.floor(table.index.to_numpy())).last()
            for second, row in zip(rows.index.tolist(), rows.to_dict("records"), strict=True):
                raised += [one for one in self.update(second + 1.0, row).changed if one.holds]
        return tuple(raised)

    def _decoded(self, t: float, lines: Sequence[str | bytes]) -> Messages:
        if not self._is_placed:
            raise InputError("sentences have longitude and latitude; give a waterway with its origin, or readings")
        decoder = self._decoder = self._decoder or NmeaDecoder()
        told = sentences([line.encode() if isinstance(line, str) else line for line in lines], decoder.faults)
        entries = [Entry(t, message) for one in told if (message := decoder.decode(one))]
        return self.engine.bridge.convert(Tick(t, entries, dict(decoder.faults)))

    def _messages(self, t: float, given: Mapping[str, Any]) -> Messages:
        readings = {SENSOR_OF.get(name, name): value for name, value in given.items() if name not in ("x", "y")}
        if ("x" in given) != ("y" in given):
            raise InputError("a place is x along the waterway and y to starboard of its line; give both")
        if "x" in given:
            readings["gnss"] = given["x"], given["y"]
        sensors, actuators = self.engine.estimator.filter.sensors, self.engine.estimator.filter.actuators
        measured, positions, _ = checked_readings(readings, sensors, actuators)
        for name in (*measured, *positions):
            self._last[MEASURES.get(name, name)] = t
        for what in NEEDED:
            self._last.setdefault(what, t)
        known: dict[str, Any] = {**measured, **positions}
        return Messages(t, known, {what: t - last for what, last in self._last.items()}, {})
