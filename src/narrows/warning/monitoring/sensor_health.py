"""Whether the sensors can be believed: silences, jumps that were refused, drifts."""

from narrows.estimation.estimate import Estimate
from narrows.warning.alerts.alert import Priority
from narrows.warning.alerts.alert_desk import CALM, Condition
from narrows.warning.hearing.bridge_readings import Heard

# What a forecast cannot do without for long.
NEEDED = ("position", "heading", "rudder")
# Without a word of what is needed [s], after which that is said, and after which nothing is foretold.
SILENT, BLIND = 3.0, 10.0
# Without a word of what was told before [s].
OTHERS_SILENT = 10.0
# For which a refused or a drifting sensor is spoken of [s].
HELD = 10.0


class SensorHealth:
    """What is wrong with the sensors, as it is said."""

    def __init__(self) -> None:
        self._began: float | None = None
        self._doubted: dict[str, float] = {}

    def condition(self, heard: Heard, estimate: Estimate) -> Condition:
        """Return a caution where a sensor is silent or doubted, a warning where nothing can be foretold for it."""
        self._doubted |= {f"{name} jumps": heard.t for name in estimate.refused}
        self._doubted |= {f"{name} drifts, or is led astray": heard.t for name in estimate.suspects}
        self._doubted = {what: t for what, t in self._doubted.items() if heard.t - t < HELD}
        said = [*self._silences(heard), *self._doubted]
        if not said:
            return CALM
        return Condition(Priority.WARNING if self.blind(heard) else Priority.CAUTION, "; ".join(said))

    def blind(self, heard: Heard) -> bool:
        """Return whether too much is unknown for too long to foretell anything."""
        return max(self._needed(heard).values()) > BLIND

    def _needed(self, heard: Heard) -> dict[str, float]:
        """How long ago each that is needed was told; of what never was, since the watch began."""
        self._began = heard.t if self._began is None else self._began
        return {what: heard.ages.get(what, heard.t - self._began) for what in NEEDED}

    def _silences(self, heard: Heard) -> list[str]:
        others = {what: age for what, age in heard.ages.items() if what not in NEEDED and age > OTHERS_SILENT}
        late = {what: age for what, age in self._needed(heard).items() if age > SILENT} | others
        return [f"no {what} for {age:.0f} s" for what, age in late.items()]
