"""All alerts of a monitor: one a situation, changed by conditions, by commands and by time."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from narrows.errors import InputError
from narrows.warning.alerts.alert import SITUATIONS, Alert, AlertState, Command, Priority, Situation
from narrows.warning.forecasting.forecast import BankForecast

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


# How urgent what is forecast is: one number for cautions, warnings and alarms, and an emergency where it is too late.
# What is on goes off later than it came on: a threshold is left by a margin, and for some time. How many false alarms
# a threshold gives is measured by decisions/warning_scores.py.
# Of a threshold, below which what is on goes off.
MARGIN = 0.7

# For how long it is to be more urgent, or less, before that is said [s].
RAISED_AFTER, LOWERED_AFTER = 2.0, 10.0


@dataclass(frozen=True)
class Thresholds:
    """From when on a forecast is urgent."""

    # Urgency of a forecast; usually such that 5, 2 and 1 % of quiet transits of 8 minutes have one [1]
    caution: float = 0.38
    # Urgency of a forecast; usually such that 5, 2 and 1 % of quiet transits of 8 minutes have one [1]
    warning: float = 0.69
    # Urgency of a forecast; usually such that 5, 2 and 1 % of quiet transits of 8 minutes have one [1]
    alarm: float = 0.91
    emergency: float = 30.0  # To contact, where the last chance is gone [s]

    def __post_init__(self) -> None:
        if not 0.0 < self.caution <= self.warning <= self.alarm:
            raise InputError(
                f"caution = {self.caution}, warning = {self.warning}, alarm = {self.alarm}: give urgencies over 0, "
                "none smaller than the one before"
            )
        if not self.emergency >= 0.0:
            raise InputError(f"emergency = {self.emergency} is no time; give seconds")

    def level(self, forecast: BankForecast, eased: float = 1.0) -> Priority:
        """Return how urgent a forecast is."""
        run, urgency = forecast.likely, forecast.urgency
        if run.gone and run.contact <= self.emergency / eased:
            return Priority.EMERGENCY_ALARM
        levels = (self.alarm, Priority.ALARM), (self.warning, Priority.WARNING), (self.caution, Priority.CAUTION)
        return next((level for threshold, level in levels if urgency >= eased * threshold), Priority.NONE)


class BankLevel:
    """The level as it is said: raised and lowered with delay, so that nothing chatters at a threshold."""

    def __init__(self, thresholds: Thresholds) -> None:
        self.thresholds, self.level = thresholds, Priority.NONE
        self._above = self._below = math.inf

    def update(self, t: float, forecast: BankForecast) -> Priority:
        """Take a forecast, and return the level that is said."""
        # t [s]
        wanted = self.thresholds.level(forecast)
        kept = max(wanted, min(self.level, self.thresholds.level(forecast, MARGIN)))
        self._above = min(self._above, t) if wanted > self.level else math.inf
        self._below = min(self._below, t) if kept < self.level else math.inf
        if t - self._above >= RAISED_AFTER or wanted is Priority.EMERGENCY_ALARM:
            self.level, self._above = wanted, math.inf
        elif t - self._below >= LOWERED_AFTER:
            self.level, self._below = kept, math.inf
        return self.level
