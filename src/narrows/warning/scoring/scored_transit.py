"""A recorded transit as a score asks for it: what each predictor said in each second, and when it came near."""

import math
from dataclasses import dataclass

import numpy as np

from narrows.warning.alerts.bank_level import Thresholds
from narrows.warning.monitoring.bridge_status import BridgeStatus

# Of predictors beside the package's own, as fitted at 2 % of false alarms: water [m], times to contact [s], chance.
ROOM, CURVED, ONE_RUN, PILOT = 25.0, 50.0, 60.0, 0.85
LEVELS = ("caution", "warning", "alarm")
PREDICTORS = (
    f"distance to the bank, {ROOM:g} m", f"curved by the rate of turn, {CURVED:g} s",
    f"one run of the model, {ONE_RUN:g} s", f"chance of contact with a pilot now, {100 * PILOT:g} %", *LEVELS,
)  # fmt: skip
# Water and times that are none.
LEAST = 1e-3


@dataclass(frozen=True, eq=False)
class ScoredTransit:
    """What was said of a transit."""

    name: str  # Of the recording
    t: np.ndarray  # (seconds,) Since the watch began [s]
    # (seconds, predictors) Of ``PREDICTORS``, over their thresholds; NaN where there was no forecast [1]
    urgencies: np.ndarray
    # (seconds,) Of the hull to the nearer bank as it was estimated; NaN where it is not known [m]
    clearance: np.ndarray

    @property
    def least(self) -> float:
        """The least clearance [m]; NaN where it was never known."""
        return float(np.nanmin(self.clearance)) if np.isfinite(self.clearance).any() else math.nan

    def struck(self, limit: float) -> float:
        """Return when the clearance first was below a limit [s]; infinite where it never was."""
        # limit [m]
        below = self.clearance < limit
        return float(self.t[below.argmax()]) if below.any() else math.inf


class TransitScorer:
    """Gathers what a monitor says of a transit."""

    def __init__(self, name: str, thresholds: Thresholds) -> None:
        self.name, self.thresholds = name, thresholds
        self._rows: list[tuple[float, ...]] = []

    def add(self, status: BridgeStatus) -> None:
        """Take what is known at a time."""
        room = status.clearance if status.estimate.ready else math.nan
        self._rows.append((status.t, room, *self._urgencies(status, room)))

    def _urgencies(self, status: BridgeStatus, room: float) -> tuple[float, ...]:
        told = status.forecast
        if told is None:
            return (math.nan,) * len(PREDICTORS)
        times = (CURVED / max(told.curved, LEAST), ONE_RUN / max(told.likely.contact, LEAST))
        levels = (told.urgency / getattr(self.thresholds, level) for level in LEVELS)
        return (ROOM / max(room, LEAST), *times, told.pilot_now.probability / PILOT, *levels)

    def transit(self) -> ScoredTransit:
        """Return the transit as it was watched."""
        table = np.array(self._rows, float).reshape(-1, 2 + len(PREDICTORS))
        t = table[:, 0] - table[:1, 0]
        return ScoredTransit(self.name, t, table[:, 2:], table[:, 1])
