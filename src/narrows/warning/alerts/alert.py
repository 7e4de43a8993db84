"""An alert and what becomes of it: raised, silenced, acknowledged, rectified.

References
----------
IEC 62923-1:2018, Bridge alert management, for priorities, states and the 30 s of a silence.
"""

from dataclasses import dataclass, replace
from enum import Enum, IntEnum

# For which an alert is silenced [s]; then it sounds again.
SILENCE = 30.0

# Without an acknowledgement [s], after which an alert sounds anew, and how often that is counted.
PATIENCE, MOST_REPEATS = 60.0, 9

MOST_REVISIONS = 99


class Priority(IntEnum):
    """How urgent, the least first."""

    NONE = 0
    CAUTION = 1
    WARNING = 2
    ALARM = 3
    EMERGENCY_ALARM = 4

    @property
    def letter(self) -> str:
        """Of a sentence; nothing where there is no alert."""
        return "" if self is Priority.NONE else self.name[0]

    @property
    def words(self) -> str:
        """As people say it."""
        return self.name.lower().replace("_", " ")


class AlertState(Enum):
    """Who has heard it, and whether its condition holds."""

    NORMAL = "normal"
    UNACKNOWLEDGED = "unacknowledged"
    SILENCED = "silenced"
    ACKNOWLEDGED = "acknowledged"
    RECTIFIED = "rectified, unacknowledged"


class Command(Enum):
    """What a bridge asks for, by the letter of its sentence."""

    ACKNOWLEDGE = "A"
    REPEAT = "Q"
    TRANSFER = "O"
    SILENCE = "S"


SOUNDING = (AlertState.UNACKNOWLEDGED,)

# States in which the condition holds.
HOLDS = (AlertState.UNACKNOWLEDGED, AlertState.SILENCED, AlertState.ACKNOWLEDGED)

# States in which an acknowledgement is waited for.
WAITING = (AlertState.UNACKNOWLEDGED, AlertState.SILENCED, AlertState.RECTIFIED)


@dataclass(frozen=True)
class Alert:
    """One situation at a time, and what was said of it."""

    identifier: int  # Of the situation
    priority: Priority = Priority.NONE  # How urgent; of what is rectified, how urgent it was
    state: AlertState = AlertState.NORMAL  # Who has heard it
    text: str = ""  # A sentence
    changed: float = 0.0  # When priority, state or the number of repeats last changed [s]
    instance: int = 0  # How often the situation came up
    revision: int = 0  # How often it changed, from 1 to 99 and over again; 0 before
    repeats: int = 0  # How often it sounded anew

    @property
    def sounds(self) -> bool:
        """Whether it is to be heard: a caution is not."""
        return self.state in SOUNDING and self.priority > Priority.CAUTION

    def conditioned(self, priority: Priority, text: str, t: float) -> "Alert":
        """Return the alert where its situation is as urgent as it is now."""
        # t [s]
        if priority is Priority.NONE:
            return self._rectified(t)
        if self.state in HOLDS and priority == self.priority:
            return replace(self, text=text)
        instance = self.instance + (self.state is AlertState.NORMAL)
        # A caution asks for no acknowledgement; of what is less urgent than what was heard, none is asked again.
        heard = self.state is AlertState.ACKNOWLEDGED and priority < self.priority
        calm = heard or priority is Priority.CAUTION
        state = AlertState.ACKNOWLEDGED if calm else AlertState.UNACKNOWLEDGED
        return replace(self, instance=instance)._changed(t, state, priority=priority, text=text, repeats=0)

    def _rectified(self, t: float) -> "Alert":
        if self.state not in HOLDS:
            return self
        gone = self.state is AlertState.ACKNOWLEDGED
        return self._changed(t, AlertState.NORMAL if gone else AlertState.RECTIFIED)

    def commanded(self, command: Command, t: float) -> "Alert | None":
        """Return the alert after a command of the bridge; None where that command is refused."""
        # t [s]
        if command is Command.REPEAT and self.state is not AlertState.NORMAL:
            return self
        if command is Command.ACKNOWLEDGE and self.state in WAITING:
            gone = self.state is AlertState.RECTIFIED
            return self._changed(t, AlertState.NORMAL if gone else AlertState.ACKNOWLEDGED)
        if command is Command.SILENCE and self.state is AlertState.UNACKNOWLEDGED:
            return self._changed(t, AlertState.SILENCED)
        return None

    def timed(self, t: float) -> "Alert":
        """Return the alert where time has passed: a silence ends, what nobody acknowledges sounds anew."""
        # t [s]
        if self.state is AlertState.SILENCED and t - self.changed >= SILENCE:
            return self._changed(t, AlertState.UNACKNOWLEDGED)
        if self.sounds and t - self.changed >= PATIENCE and self.repeats < MOST_REPEATS:
            return self._changed(t, self.state, repeats=self.repeats + 1)
        return self

    def _changed(self, t: float, state: AlertState, **others: object) -> "Alert":
        changes: dict[str, object] = {"state": state, "changed": t, "revision": self.revision % MOST_REVISIONS + 1}
        return replace(self, **changes, **others)  # type: ignore[arg-type]


# What there is to be alerted of: one alert a situation.
@dataclass(frozen=True)
class Situation:
    """Something that a bridge is alerted of."""

    identifier: int  # In sentences; from 10000 on they are a maker's own
    name: str  # Of it, in up to 16 letters


BANK = Situation(10110, "BANK CONTACT")

SENSORS = Situation(10120, "BANK SENSORS")

BEYOND_DATA = Situation(10130, "BANK MODEL RANGE")

NO_FORECAST = Situation(10140, "NO BANK FORECAST")

LOG_LATE = Situation(10150, "ALERT LOG LATE")

# By identifier.
SITUATIONS = {one.identifier: one for one in (BANK, SENSORS, BEYOND_DATA, NO_FORECAST, LOG_LATE)}
