"""An alert and what becomes of it: raised, silenced, acknowledged, rectified; the log of all alerts.

They are on disk before they are published, and states are back after a restart. A thread writes, and who publishes
waits for it no longer than a deadline: a disk that is stuck or full delays an alert by that, and mutes none. What could
not be written is kept, in order, and written as soon as it can be.

Source: IEC 62923-1:2018, Bridge alert management, for priorities, states and the 30 s of a silence.
"""

import json
import math
import re
import sqlite3
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from pathlib import Path
from queue import Queue
from threading import Event, Thread
from typing import NamedTuple

from narrows.base.errors import InputError, reason
from narrows.base.results import Aliased
from narrows.warning import settings
from narrows.warning.forecasting.forecaster import BankForecast

MOST_REVISIONS = 99
SAME = 1e-9  # Times that differ by less are one [s]


class Priority(IntEnum):
    NONE = 0
    CAUTION = 1
    WARNING = 2
    ALARM = 3
    EMERGENCY_ALARM = 4

    @property
    def letter(self) -> str:
        return "" if self is Priority.NONE else self.name[0]

    @property
    def words(self) -> str:
        return self.name.lower().replace("_", " ")


class AlertState(Enum):
    NORMAL = "normal"
    UNACKNOWLEDGED = "unacknowledged"
    SILENCED = "silenced"
    ACKNOWLEDGED = "acknowledged"
    RECTIFIED = "rectified, unacknowledged"


class Command(Enum):
    """Commands of a bridge, by the letter of its sentence."""

    ACKNOWLEDGE = "A"
    REPEAT = "Q"
    TRANSFER = "O"  # Another system asks for the responsibility: refused
    SILENCE = "S"


MAKER = "NRW"  # Manufacturer's code in the sentences
ACN = re.compile(rb"^\$[A-Z]{2}ACN,[^,]*,([A-Z]{0,3}),(\d{1,7}),(\d{1,6}),([AQOS]),C\*[0-9A-F]{2}$")
# States in which the condition holds.
HOLDS = (AlertState.UNACKNOWLEDGED, AlertState.SILENCED, AlertState.ACKNOWLEDGED)
# States that wait for an acknowledgement, the last one without its condition.
WAITING = (AlertState.UNACKNOWLEDGED, AlertState.SILENCED, AlertState.RECTIFIED)


@dataclass(frozen=True)
class Alert(Aliased):
    identifier: int  # Number of the situation
    priority: Priority = Priority.NONE  # Urgency; for a rectified alert the former urgency
    state: AlertState = AlertState.NORMAL  # Acknowledged, silenced ...
    text: str = ""  # A sentence
    changed: float = 0.0  # When priority, state or the number of repeats last changed [s]
    instance: int = 0  # Count of occurrences of the situation
    revision: int = 0  # Count of changes, from 1 to 99 and over again; 0 before
    repeats: int = 0  # Count of repeated soundings

    @property
    def name(self) -> str:
        return SITUATIONS[self.identifier].name

    @property
    def holds(self) -> bool:
        return self.state in HOLDS

    @property
    def category(self) -> str:
        """A: to be judged by the picture of this page; B: by the text of the alert."""
        return "A" if self.identifier in (one.identifier for one in BANKS.values()) else "B"

    @property
    def sounds(self) -> bool:
        """Whether the alert sounds: a caution does not."""
        return self.state is AlertState.UNACKNOWLEDGED and self.priority > Priority.CAUTION

    def conditioned(self, priority: Priority, text: str, t: float) -> "Alert":
        if priority is Priority.NONE:
            rectified = AlertState.NORMAL if self.state is AlertState.ACKNOWLEDGED else AlertState.RECTIFIED
            return self._changed(t, rectified) if self.holds else self
        if self.holds and priority == self.priority:
            return replace(self, text=text)
        instance = self.instance + (self.state is AlertState.NORMAL)
        # A caution needs no acknowledgement, an acknowledged alert of lower priority no second one;
        # an unacknowledged alert waits at any priority.
        waits = self.state in WAITING or priority > Priority.CAUTION
        answered = self.state is AlertState.ACKNOWLEDGED and priority < self.priority
        state = AlertState.UNACKNOWLEDGED if waits and not answered else AlertState.ACKNOWLEDGED
        return replace(self, instance=instance)._changed(t, state, priority=priority, text=text, repeats=0)

    def commanded(self, command: Command, t: float) -> "Alert | None":
        after = None
        if command is Command.REPEAT and self.state is not AlertState.NORMAL:
            return self
        if command is Command.ACKNOWLEDGE and self.state in WAITING:
            after = AlertState.NORMAL if self.state is AlertState.RECTIFIED else AlertState.ACKNOWLEDGED
        elif command is Command.SILENCE and self.sounds:
            after = AlertState.SILENCED
        return after and self._changed(t, after)

    def timed(self, t: float) -> "Alert":
        """Return the alert where time has passed: a silence ends, what nobody acknowledges sounds anew."""
        if self.state is AlertState.SILENCED and t - self.changed >= settings.SILENCE:
            return self._changed(t, AlertState.UNACKNOWLEDGED)
        if self.sounds and t - self.changed >= settings.REPEAT_AFTER and self.repeats < settings.MOST_REPEATS:
            return self._changed(t, self.state, repeats=self.repeats + 1)
        return self

    def _changed(self, t: float, state: AlertState, **others: object) -> "Alert":
        changes: dict[str, object] = {"state": state, "changed": t, "revision": self.revision % MOST_REVISIONS + 1}
        return replace(self, **changes, **others)  # type: ignore[arg-type]


class AlertCommand(NamedTuple):
    identifier: int  # Number of the alert
    instance: int  # Instance of the alert
    command: Command  # Requested change of its state


def command_of(text: bytes) -> AlertCommand | None:
    """Return the command of a sentence ACN whose checksum is right; None if it is for another maker."""
    match = ACN.match(text)
    if match is None or match[1] not in (b"", MAKER.encode()):
        return None
    return AlertCommand(int(match[2]), int(match[3]), Command(match[4].decode()))


# Hazards: one alert each, with its own state.
class Situation(NamedTuple):
    identifier: int  # In sentences; from 10000 on they are a maker's own
    name: str  # Name of the hazard, in up to 16 letters


BANKS = {"port": Situation(10110, "BANK TO PORT"), "starboard": Situation(10111, "BANK TO STBD")}
OTHER_DEPTH = Situation(10130, "DEPTH OF WATER")
NO_FORECAST = Situation(10140, "NO BANK FORECAST")
LOG_LATE = Situation(10150, "ALERT LOG LATE")
OTHER_SENSORS = Situation(10120, "OTHER SENSORS")
# By what is measured.
SENSORS = {
    "position": Situation(10121, "SENSOR POSITION"), "heading": Situation(10122, "SENSOR HEADING"),
    "yaw rate": Situation(10123, "SENSOR YAW RATE"), "rudder": Situation(10124, "SENSOR RUDDER"),
    "speed through the water": Situation(10125, "SENSOR LOG"), "speed over ground": Situation(10126, "SENSOR COG SOG"),
    "revolutions": Situation(10127, "SENSOR RPM"),
}  # fmt: skip
ANY_SENSOR = (*SENSORS.values(), OTHER_SENSORS)
# By identifier.
SITUATIONS = {one.identifier: one for one in (*BANKS.values(), *ANY_SENSOR, OTHER_DEPTH, NO_FORECAST, LOG_LATE)}


# All alerts of a monitor: one a hazard, changed by conditions, by commands and by time.
class Condition(NamedTuple):
    priority: Priority  # Urgency
    text: str  # A sentence


CALM = Condition(Priority.NONE, "")


class AlertDesk:
    def __init__(self, known: Iterable[Alert] = ()) -> None:
        self._alerts = {identifier: Alert(identifier) for identifier in SITUATIONS}
        self._alerts |= {alert.identifier: alert for alert in known if alert.identifier in SITUATIONS}

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """Those that are not normal, the most urgent first."""
        active = [alert for alert in self if alert.state is not AlertState.NORMAL]
        return tuple(sorted(active, key=lambda alert: (alert.state is AlertState.RECTIFIED, -alert.priority)))

    def __iter__(self) -> Iterator[Alert]:
        return iter(self._alerts.values())

    def __getitem__(self, situation: Situation) -> Alert:
        return self._alerts[situation.identifier]

    def update(self, t: float, conditions: Mapping[Situation, Condition]) -> list[Alert]:
        changed = []
        for identifier, before in self._alerts.items():
            condition = conditions.get(SITUATIONS[identifier])
            after = self._alerts[identifier] = (before.conditioned(*condition, t) if condition else before).timed(t)
            changed += [after] * (after.revision != before.revision)
        return changed

    def command(self, t: float, identifier: int, instance: int, command: Command) -> Alert | None:
        alert = self._alerts.get(identifier)
        if alert is None or alert.instance != instance or alert.state is AlertState.NORMAL:
            return None
        if after := alert.commanded(command, t):
            self._alerts[identifier] = after
        return after


def level_of(forecast: BankForecast, eased: float = 1.0) -> Priority:
    if forecast.likely.gone and math.isfinite(forecast.likely.contact):
        return Priority.EMERGENCY_ALARM
    levels = (Priority[name.upper()] for name, time in settings.LEVELS.items() if forecast.level_time <= time / eased)
    return next(levels, Priority.NONE)


class BankLevel:
    """The level as it is said: raised and lowered with delay, so that nothing chatters at a threshold."""

    def __init__(self, level: Priority = Priority.NONE) -> None:
        self.level = level
        self._above = self._below = math.inf

    def update(self, t: float, wanted: Priority, eased: Priority) -> Priority:
        """Return the level after a second; it is kept where ``eased``, that of longer times to act, is as high."""
        kept = max(wanted, min(self.level, eased))
        self._above = min(self._above, t) if wanted > self.level else math.inf
        self._below = min(self._below, t) if kept < self.level else math.inf
        if t - self._above >= settings.RAISE_DELAY - SAME:
            self.level, self._above = wanted, math.inf
        elif t - self._below >= settings.LOWER_DELAY - SAME:
            self.level, self._below = kept, math.inf
        return self.level


TABLE = "CREATE TABLE IF NOT EXISTS alerts (number INTEGER PRIMARY KEY, written REAL NOT NULL, content TEXT NOT NULL)"


class AlertLog(AbstractContextManager["AlertLog"]):
    def __init__(
        self,
        path: Path,
        deadline: float = settings.DISK_TIMEOUT,
        connect: Callable[[], sqlite3.Connection] | None = None,
    ) -> None:
        self.path, self.deadline, self.trouble = path, deadline, ""
        self._connect = connect or (lambda: _opened(path))
        known = logged(path) if path.exists() else {}
        self.alerts = tuple({alert.identifier: alert for alert in known.values()}.values())
        self.count = max(known, default=0)
        self._waiting, self._closing = Queue[tuple[tuple[int, float, str], Event] | None](), Event()
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def __exit__(self, *error: object) -> None:
        self._closing.set()
        self._waiting.put(None)
        self._thread.join(self.deadline + settings.DISK_RETRY)

    def alert(self, alert: Alert) -> bool:
        """Write an alert; return whether it is on disk before the deadline."""
        content = {**vars(alert), "priority": alert.priority.name, "state": alert.state.name}
        self.count += 1
        row = self.count, time.time(), json.dumps(content, sort_keys=True)
        self._waiting.put((row, written := Event()))
        return written.wait(self.deadline)

    def _run(self) -> None:
        connection: sqlite3.Connection | None = None
        for row, written in iter(self._waiting.get, None):
            while not written.is_set():
                try:
                    connection = connection or self._connect()
                    with connection:
                        connection.execute("INSERT OR IGNORE INTO alerts VALUES (?, ?, ?)", row)
                    self.trouble = ""
                    written.set()
                except sqlite3.Error as error:
                    if connection:
                        connection.close()
                    connection, self.trouble = None, reason(error)
                    if self._closing.wait(settings.DISK_RETRY):
                        return
        if connection:
            connection.close()


def logged(path: Path) -> dict[int, Alert]:
    """Return the alerts of a log by the numbers of their rows."""
    try:
        with closing(_opened(path)) as connection:
            rows = connection.execute("SELECT number, content FROM alerts ORDER BY number").fetchall()
        lasts = {number: json.loads(content) for number, content in rows}
        return {
            number: Alert(**{**last, "priority": Priority[last["priority"]], "state": AlertState[last["state"]]})
            for number, last in lasts.items()
        }
    except (sqlite3.Error, ValueError, TypeError, KeyError) as error:
        raise InputError(f"{path}: is no log of alerts ({reason(error)}); name another") from None


def _opened(path: Path) -> sqlite3.Connection:
    connection = sqlite3.connect(path, timeout=settings.DISK_TIMEOUT)
    try:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute(TABLE)
    except sqlite3.Error:
        connection.close()  # Python 3.13 warns of a connection that is dropped open.
        raise
    return connection
