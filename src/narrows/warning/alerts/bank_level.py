"""How urgent what is forecast is: chances for cautions and warnings, the most likely run for alarms.

At few false alarms one run ranks better than chances that are tied at 1, so alarms go by its time to contact and its
last chance. What is on goes off later than it came on: a threshold is left by a margin, and for some time.
"""

import math
from dataclasses import dataclass

from narrows.errors import InputError
from narrows.warning.alerts.alert import Priority
from narrows.warning.forecasting.forecast import BankForecast, LikelyRun

MARGIN = 0.7
"""Of a threshold, below which what is on goes off."""
RAISED_AFTER, LOWERED_AFTER = 2.0, 10.0
"""For how long it is to be more urgent, or less, before that is said [s]."""


@dataclass(frozen=True)
class Thresholds:
    """From when on a forecast is urgent.

    Parameters
    ----------
    caution, warning : float [1]
        Chance of contact with a pilot who takes over now.
    caution_soon, warning_soon : float [1]
        Chance of contact within 60 s, the rudder as it is.
    alarm_contact : float [s]
        To contact of the most likely run, the rudder as it is.
    alarm_chance : float [s]
        To its last chance.
    emergency : float [s]
        To contact, where the last chance is gone.

    Raises
    ------
    InputError
        Where a chance is none, or a warning would come before its caution.
    """

    caution: float = 0.1
    warning: float = 0.3
    caution_soon: float = 0.2
    warning_soon: float = 0.5
    alarm_contact: float = 90.0
    alarm_chance: float = 20.0
    emergency: float = 30.0

    def __post_init__(self) -> None:
        for low, high in (("caution", "warning"), ("caution_soon", "warning_soon")):
            first, second = getattr(self, low), getattr(self, high)
            if not 0.0 < first <= second <= 1.0:
                raise InputError(
                    f"{low} = {first}, {high} = {second}: give chances from over 0 to 1, the warning's larger"
                )
        for name in ("alarm_contact", "alarm_chance", "emergency"):
            if not getattr(self, name) >= 0.0:
                raise InputError(f"{name} = {getattr(self, name)} is no time; give seconds")

    def level(self, forecast: BankForecast, eased: float = 1.0) -> Priority:
        """Return how urgent a forecast is.

        Parameters
        ----------
        forecast : BankForecast
            What will happen.
        eased : float [1]
            Factor on the chances, and one over that on the times.
        """
        now, soon, run = forecast.pilot_now.probability, forecast.as_it_is.soon, forecast.likely
        if run.gone and run.contact <= self.emergency / eased:
            return Priority.EMERGENCY_ALARM
        if run.contact <= self.alarm_contact / eased and _chance(run) <= self.alarm_chance / eased:
            return Priority.ALARM
        if now >= eased * self.warning or soon >= eased * self.warning_soon:
            return Priority.WARNING
        return Priority.CAUTION if now >= eased * self.caution or soon >= eased * self.caution_soon else Priority.NONE


def _chance(run: LikelyRun) -> float:
    return 0.0 if run.gone else run.last_chance


class BankLevel:
    """The level as it is said: raised and lowered with delay, so that nothing chatters at a threshold.

    Parameters
    ----------
    thresholds : Thresholds
        From when on a forecast is urgent.
    """

    def __init__(self, thresholds: Thresholds) -> None:
        self.thresholds, self.level = thresholds, Priority.NONE
        self._above = self._below = math.inf

    def update(self, t: float, forecast: BankForecast) -> Priority:
        """Take a forecast, and return the level that is said (ours).

        Parameters
        ----------
        t : float [s]
            When.
        forecast : BankForecast
            What will happen.
        """
        wanted = self.thresholds.level(forecast)
        kept = max(wanted, min(self.level, self.thresholds.level(forecast, MARGIN)))
        self._above = min(self._above, t) if wanted > self.level else math.inf
        self._below = min(self._below, t) if kept < self.level else math.inf
        if t - self._above >= RAISED_AFTER or wanted is Priority.EMERGENCY_ALARM:
            self.level, self._above = wanted, math.inf
        elif t - self._below >= LOWERED_AFTER:
            self.level, self._below = kept, math.inf
        return self.level
