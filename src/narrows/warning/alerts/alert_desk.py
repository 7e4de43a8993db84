"""All alerts of a monitor: one a situation, changed by conditions, by commands and by time."""

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from narrows.warning.alerts.alert import Alert, AlertState, Command, Priority
from narrows.warning.alerts.situations import SITUATIONS, Situation

LINGERS = 10.0
"""That a condition is spoken of after it last held [s]."""


class Condition(NamedTuple):
    """A situation as it is now.

    Parameters
    ----------
    priority : Priority
        How urgent it is.
    text : str
        A sentence.
    """

    priority: Priority
    text: str


CALM = Condition(Priority.NONE, "")


class Lingering:
    """A condition that is spoken of for a while after it last held, so that it does not come and go with noise.

    Parameters
    ----------
    time : float [s]
        For how long.
    """

    def __init__(self, time: float = LINGERS) -> None:
        self.time, self._last, self._until = time, CALM, -math.inf

    def held(self, t: float, condition: Condition) -> Condition:
        """Return the condition, or the one that held a while ago (ours).

        Parameters
        ----------
        t : float [s]
            When.
        condition : Condition
            As it is.
        """
        if condition.priority:
            self._last, self._until = condition, t + self.time
        return self._last if t < self._until else CALM


class AlertDesk:
    """Holds the alerts.

    Parameters
    ----------
    known : iterable of Alert
        As they were when it was last at work.
    """

    def __init__(self, known: Iterable[Alert] = ()) -> None:
        self._alerts = {identifier: Alert(identifier) for identifier in SITUATIONS}
        self._alerts |= {alert.identifier: alert for alert in known if alert.identifier in SITUATIONS}

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """Those that are not normal, the most urgent first."""
        active = [alert for alert in self._alerts.values() if alert.state is not AlertState.NORMAL]
        return tuple(sorted(active, key=lambda alert: (alert.state is AlertState.RECTIFIED, -alert.priority)))

    def __getitem__(self, situation: Situation) -> Alert:
        """The alert of a situation.

        Parameters
        ----------
        situation : Situation
            Which.
        """
        return self._alerts[situation.identifier]

    def update(self, t: float, conditions: Mapping[Situation, Condition]) -> list[Alert]:
        """Take the situations as they are, and return the alerts that changed (ours).

        Parameters
        ----------
        t : float [s]
            When.
        conditions : mapping of Situation to Condition
            Those of which something is known; the others stay as they are.
        """
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
        """Do what the bridge asks for, and return the alert; None where it is refused (ours).

        Parameters
        ----------
        t : float [s]
            When.
        identifier, instance : int
            Which alert; that of another time is refused.
        command : Command
            What is asked for.
        """
        alert = self._alerts.get(identifier)
        if alert is None or alert.instance != instance or alert.state is AlertState.NORMAL:
            return None
        after = alert.commanded(command, t)
        if after is not None:
            self._alerts[identifier] = after
        return after
