"""What there is to be alerted of: one alert a situation."""

from dataclasses import dataclass


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
