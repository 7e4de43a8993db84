"""Scores of recorded transits: contacts that were missed, how early the others were told, and what was told in vain."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError
from narrows.results import Described
from narrows.warning.alerts.alert import Thresholds
from narrows.warning.monitoring.bridge_status import BridgeStatus
from narrows.warning.settings import HYSTERESIS, LOWER_DELAY, NEEDED_LEAD, QUIET_CLEARANCE, RAISE_DELAY, SCORED_CONTACT

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class PredictorScore:
    predictor: str  # With its threshold, or a level of the monitor
    missed: int  # Contacts before which it did not stand for 20 s
    lead: float  # Median time that it stood before a contact; NaN without one [s]
    false: int  # Quiet transits in which it was raised
    near: int  # Transits that came near, without contact, in which it was raised


@dataclass(frozen=True, repr=False)
class TransitScores(Described):
    contacts: int  # Transits by what became of them
    quiet: int  # Transits by what became of them
    near: int  # Transits by what became of them
    limit: float  # Clearance that counts as contact [m]
    rows: tuple[PredictorScore, ...]  # A predictor each
    leads: dict[str, tuple[float, ...]]  # By transit with a contact: how long each predictor stood before it [s]
    unknown: tuple[str, ...]  # Transits of which nothing could be foretold

    @property
    def notes(self) -> tuple[str, ...]:
        rule = (
            f"A contact is a clearance below {self.limit:g} m as the estimate has it; quiet is what always had more "
            f"than {QUIET_CLEARANCE:g} m; missed is what stood less than {NEEDED_LEAD:g} s before a contact."
        )
        few = ("So few transits tell little: see the intervals in docs/warning.md.",)
        left = tuple(f"Nothing could be foretold of {name}: it is left out." for name in self.unknown)
        return (rule, *few, *left)

    def summary(self) -> str:
        met = f"{self.contacts} {'transit' if self.contacts == 1 else 'transits'} with a contact"
        lines = [f"{met}, {self.near} that came near, {self.quiet} quiet ones."]
        for row in self.rows:
            lead = f", {row.lead:.0f} s before it (median)" if math.isfinite(row.lead) else ""
            vain = f"in vain in {row.false} of {self.quiet}"
            lines.append(f"{row.predictor}: missed {row.missed} of {self.contacts}{lead}; {vain}.")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        counts = {"contacts": self.contacts, "near": self.near, "quiet": self.quiet, "limit": self.limit}
        leads = {name: dict(zip(PREDICTORS, row, strict=True)) for name, row in self.leads.items()}
        rows = [vars(row) for row in self.rows]
        return {"summary": self.summary(), **counts, "predictors": rows, "leads": leads, "notes": [*self.notes]}

    def to_dataframe(self) -> "pd.DataFrame":
        import pandas as pd

        return pd.DataFrame([vars(row) for row in self.rows]).set_index("predictor")


@dataclass(frozen=True, eq=False)
class ScoredTransit:
    name: str  # Of the recording
    t: np.ndarray  # (seconds,) Since the watch began [s]
    urgencies: np.ndarray  # (seconds, predictors) Over their thresholds; NaN without a forecast [1]
    clearance: np.ndarray  # (seconds,) Estimated, to the nearer bank; NaN where unknown [m]

    @property
    def least(self) -> float:
        """The least clearance [m]; NaN where it was never known."""
        return float(np.nanmin(self.clearance)) if np.isfinite(self.clearance).any() else math.nan

    def struck(self, limit: float) -> float:
        """Return when the clearance first was below a limit [s]; infinite where it never was."""
        below = self.clearance < limit
        return float(self.t[below.argmax()]) if below.any() else math.inf


def score_transits(transits: Sequence[ScoredTransit], limit: float = SCORED_CONTACT) -> TransitScores:
    if not 0.0 <= limit < QUIET_CLEARANCE:
        raise InputError(
            f"a clearance of {limit:g} m cannot tell contacts from quiet transits; give 0 to {QUIET_CLEARANCE:g} m"
        )
    known = [one for one in transits if np.isfinite(one.urgencies).any()]
    unknown = tuple(one.name for one in transits if not np.isfinite(one.urgencies).any())
    met = [one for one in known if math.isfinite(one.struck(limit))]
    quiet = [one for one in known if one.least > QUIET_CLEARANCE]
    near = [one for one in known if one not in met and one not in quiet]
    leads: dict[str, tuple[float, ...]] = {}
    for one in met:
        since, struck = standing_since(one.t, one.urgencies), np.full(len(PREDICTORS), one.struck(limit))
        leads[one.name] = tuple(lead_times(one.t, since, struck).tolist())
    told, vain, close = (np.array([*rows]).reshape(-1, len(PREDICTORS)) for rows in (
        leads.values(), map(_raised, quiet), map(_raised, near)
    ))  # fmt: skip
    rows = tuple(
        PredictorScore(
            name, int((told[:, k] < NEEDED_LEAD).sum()), float(np.median(told[:, k])) if len(met) else math.nan,
            int(vain[:, k].sum()), int(close[:, k].sum()),
        )
        for k, name in enumerate(PREDICTORS)
    )  # fmt: skip
    return TransitScores(len(met), len(quiet), len(near), limit, rows, leads, unknown)


def _raised(one: ScoredTransit) -> np.ndarray:
    return np.asarray(np.isfinite(standing_since(one.t, one.urgencies)).any(axis=0))


# A recorded transit as a score asks for it: what each predictor said in each second, and when it came near.
# Of predictors beside the package's own, as fitted at 2 % of false alarms: water [m], times to contact [s], chance.
ROOM, CURVED, ONE_RUN, PILOT = 25.0, 50.0, 60.0, 0.85
LEVELS = ("caution", "warning", "alarm")

PREDICTORS = (
    f"distance to the bank, {ROOM:g} m", f"curved by the rate of turn, {CURVED:g} s",
    f"one run of the model, {ONE_RUN:g} s", f"chance of contact with a pilot now, {100 * PILOT:g} %", *LEVELS,
)  # fmt: skip

# Water and times that are none.
LEAST = 1e-3


class TransitScorer:
    def __init__(self, name: str, thresholds: Thresholds) -> None:
        self.name, self.thresholds = name, thresholds
        self._rows: list[tuple[float, ...]] = []

    def add(self, status: BridgeStatus) -> None:
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
        table = np.array(self._rows, float).reshape(-1, 2 + len(PREDICTORS))
        t = table[:, 0] - table[:1, 0]
        return ScoredTransit(self.name, t, table[:, 2:], table[:, 1])


# Times [s] that are one.
SAME = 1e-9


def standing_since(t: np.ndarray, urgency: np.ndarray) -> np.ndarray:
    """Return since when an alert stands, (times,...) [s]; infinite where none does."""
    # t (times,) [s]; urgency (times, ...)
    shape = urgency.shape[1:]
    above, below, since = (np.full(shape, np.inf) for _ in range(3))
    told = np.empty(urgency.shape)
    for k, now in enumerate(t):
        known = ~np.isnan(urgency[k])
        high, low = known & (urgency[k] >= 1.0), known & (urgency[k] < HYSTERESIS)
        above = np.where(high, np.minimum(above, now), np.where(known, np.inf, above))
        below = np.where(low, np.minimum(below, now), np.where(known, np.inf, below))
        stands = np.isfinite(since)
        since = np.where(~stands & (now - above >= RAISE_DELAY - SAME), now, since)
        since = np.where(stands & (now - below >= LOWER_DELAY - SAME), np.inf, since)
        told[k] = since
    return told


def lead_times(t: np.ndarray, since: np.ndarray, struck: np.ndarray) -> np.ndarray:
    """Return how long before a contact the alert that then stands was raised [s]; 0 where none stands."""
    # t (times,) [s]; since (times, n) [s]; struck (n,) [s]
    last = np.maximum(np.searchsorted(t, struck - SAME) - 1, 0)
    stands = since[last, np.arange(len(struck))]
    return np.where(np.isfinite(stands), struck - stands, 0.0)


def highest_held(t: np.ndarray, urgency: np.ndarray, struck: np.ndarray) -> np.ndarray:
    """Return the highest urgency that would raise an alert, (n,): it held for as long as one waits."""
    # t (times,) [s]; urgency (times, n); struck (n,) [s]
    rows = 1 + int(np.ceil((RAISE_DELAY - SAME) / (t[1] - t[0])))
    live = np.where((t[:, None] < struck), np.nan_to_num(urgency), 0.0)
    held = np.lib.stride_tricks.sliding_window_view(live, rows, axis=0).min(axis=-1)
    return np.asarray(held.max(axis=0))
