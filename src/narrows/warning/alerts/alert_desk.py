"""All alerts of a monitor: one a situation, changed by conditions, by commands and by time."""

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from narrows.warning.alerts.alert import Alert, AlertState, Command, Priority
from narrows.warning.alerts.situations import SITUATIONS, Situation

# That a condition is spoken of after it last held [s].
LINGERS = 10.0


class Condition(NamedTuple):
    """A situation as it is now."""

    priority: Priority  # How urgent it is
    text: str  # A sentence


CALM = Condition(Priority.NONE, "")


class Lingering:
    """A condition that is spoken of for a while after it last held, so that it does not come and go with noise."""

    def __init__(self, time: float = LINGERS) -> None:
        self.time, self._last, self._until = time, CALM, -math.inf

    def held(self, t: float, condition: Condition) -> Condition:
        """Return the condition, or the one that held a while ago."""
        # t [s]
        if condition.priority:
            self._last, self._until = condition, t + self.time
        return self._last if t < self._until else CALM


class AlertDesk:
    """Holds the alerts."""

    def __init__(self, known: Iterable[Alert] = ()) -> None:
        self._alerts = {identifier: Alert(identifier) for identifier in SITUATIONS}
        self._alerts |= {alert.identifier: alert for alert in known if alert.identifier in SITUATIONS}

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """Those that are not normal, the most urgent first."""
        active = [alert for alert in self._alerts.values() if alert.state is not AlertState.NORMAL]
        return tuple(sorted(active, key=lambda alert: (alert.state is AlertState.RECTIFIED, -alert.priority)))

    def __getitem__(self, situation: Situation) -> Alert:
        """The alert of a situation."""
        return self._alerts[situation.identifier]

    def update(self, t: float, conditions: Mapping[Situation, Condition]) -> list[Alert]:
        """Take the situations as they are, and return the alerts that changed."""
        # t [s]
        changed = []
        for identifier, before in self._alerts.items():
            after = before
            if condition := conditions.get(SITUATIONS[identifier]):
                after = after.conditioned(condition.priority, condition.text, t)
            after = after.timed(t)
            self._alerts[identifier] = after
            if (after.state, after.priority, after.revision) != (before.state, before.priority, before.revision):
                changed.append(after)
        return changed

    def command(self, t: float, identifier: int, instance: int, command: Command) -> Alert | None:
        """Do what the bridge asks for, and return the alert; None where it is refused."""
        # t [s]
        alert = self._alerts.get(identifier)
        if alert is None or alert.instance != instance or alert.state is AlertState.NORMAL:
            return None
        after = alert.commanded(command, t)
        if after is not None:
            self._alerts[identifier] = after
        return after
