"""How early a warning of the banks comes, and how often wrongly, beside what bridges have: tables of docs/warning.md.

A 230 m container ship in a straight canal 300 m wide, 8 minutes: people hold one of seven lines with an order every ten
seconds, half of them go 20 m to a side, it blows for a minute. In half of the transits the bank's force grows to 1.5
to 4 times itself for 1 to 2.5 minutes, and whoever steers lets go for up to 2 minutes of it. Every ship has a current,
a rudder indicator and coefficients of its own, and is known by fixes, compass, rate of turn and log, to the estimator.

Each predictor is a number that grows with the danger; alerts are raised and lowered by the rule of the package's own
level. A threshold lets so many of the quiet transits (no contact, always more than 20 m of water) have an alert: found
in one half of the transits and used in the other, both ways round. Missed is what stands less than 20 s before the
contact. What runs aground in the first minute that is foretold, or in the two minutes after the last, is left out;
a ship that is still afloat then was not about to. Intervals hold 90 % of a thousand draws of
the transits with replacement, the thresholds as they are. The first thousand transits chose the package's number and
its weights, and stand in no table.

python decisions/warning_scores.py [--write] [--kept FOLDER] [--count TRANSITS] [--others TRANSITS]
"""

import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from pages import markdown, publish
from watched.runs import EVERY, FROM, Run, kept_runs
from watched.truths import DEPTH, DURATION, Physics

from narrows.warning.forecasting.forecast import urgency_of
from narrows.warning.settings import NEEDED_LEAD, SHORTEST_CONTACT_TIME
from narrows.warning.transit_scores import highest_held, lead_times, standing_since

RATES = (0.05, 0.02, 0.01)
"""Of quiet transits that have an alert."""
CHOSEN_ON, SCORED, OTHERS = 1000, 4000, 1000
"""Transits that chose the package's number; of the first table; of each row of the second."""
FIRST_MINUTE, NEAR, DRAWS, WITHIN = FROM + 60.0, 20.0, 1000, (0.05, 0.95)
KNOWN = Physics("as the model has it, its coefficients drawn from their covariance")
OTHER_TRUTHS = (
    Physics("banks whose force goes with the distance", form="distance"),
    Physics("coefficients twice as far off as their covariance says", spread=2.0),
    Physics("a tenth less water than charted", depth=0.9 * DEPTH),
)
CURVED, ONE_RUN, OURS = "curved by the rate of turn", "one run of the model", "urgency: the package's rule"


def predictors(run: Run) -> dict[str, np.ndarray]:
    """Numbers that grow with the danger, (times, transits)."""

    def by_time(name: str) -> np.ndarray:
        return 1.0 / np.maximum(run[name].astype(float), SHORTEST_CONTACT_TIME)

    both = np.minimum(90.0 * by_time("contact"), 20.0 * by_time("last_chance"))
    return {
        "distance to the bank": by_time("room"), "straight on": by_time("line"), CURVED: by_time("curve"),
        ONE_RUN: by_time("contact"), "the same, with its last chance": both,
        "chance of contact within 60 s, the rudder as it is": run["soon"].astype(float),
        "chance of contact with a pilot now": run["pilot_now"].astype(float),
        OURS: urgency_of(*(run[name].astype(float) for name in ("pilot_now", "contact", "curve"))),
    }  # fmt: skip


@dataclass(frozen=True)
class Transits:
    """What became of transits, and what was foretold of them."""

    run: Run

    @cached_property
    def t(self) -> np.ndarray:
        """Of the forecasts."""
        return FROM + EVERY * np.arange(len(self.run["room"]), dtype=float)

    @cached_property
    def struck(self) -> np.ndarray:
        """When a bank was met."""
        return self.run["struck"].astype(float)

    @cached_property
    def aground(self) -> np.ndarray:
        """Which count as contacts."""
        return (self.struck > FIRST_MINUTE) & (self.struck <= DURATION)

    @cached_property
    def quiet(self) -> np.ndarray:
        """Which count as quiet."""
        return ~np.isfinite(self.struck) & (self.run["least"] > NEAR)

    def leads(self, number: np.ndarray, thresholds: np.ndarray) -> np.ndarray:
        """Of each transit, how long before the contact the alert was raised that then stood; NaN without contact."""
        which, leads = np.flatnonzero(self.aground), np.full(len(self.struck), np.nan)
        since = standing_since(self.t, number[:, which] / thresholds[which])
        leads[which] = lead_times(self.t, since, self.struck[which])
        return leads


@dataclass(frozen=True)
class Score:
    """Of a predictor at a threshold: false alarms, misses and leads of single transits; NaN where they do not count."""

    threshold: float
    false: np.ndarray
    missed: np.ndarray
    leads: np.ndarray

    @cached_property
    def _drawn(self) -> np.ndarray:
        return np.random.default_rng(0).integers(0, len(self.false), (DRAWS, len(self.false)))

    def share(self, cases: np.ndarray) -> str:
        """In percent, with its interval."""
        drawn = np.nanmean(cases[self._drawn], axis=1)
        return _told(100 * np.nanmean(cases), 100 * np.quantile(drawn, WITHIN), 1)

    @property
    def lead(self) -> str:
        """Its median, with its interval."""
        drawn = np.nanmedian(self.leads[self._drawn], axis=1)
        return _told(np.nanmedian(self.leads), np.quantile(drawn, WITHIN), 0)


def _told(value: float, within: np.ndarray, places: int) -> str:
    low, high = (f"{end:.{places}f}" for end in within)
    return f"{value:.{places}f} ({low} to {high})"


def lowest_threshold(peaks: np.ndarray, rate: float) -> float:
    """The lowest that no more than so many reach; infinite where more are tied at the highest."""
    values = np.unique(peaks)
    reached = 1.0 - np.searchsorted(np.sort(peaks), values) / len(peaks)
    few = values[(reached <= rate) & (values > 0.0)]
    return float(few[0]) if len(few) else np.inf


def cross_fitted(transits: Transits, number: np.ndarray, rate: float) -> Score:
    """Thresholds from one half, scores from the other, both ways round."""
    count = len(transits.struck)
    peaks, half = highest_held(transits.t, number, transits.struck), np.random.default_rng(1).permutation(count) % 2
    both = [lowest_threshold(peaks[transits.quiet & (half != part)], rate) for part in (0, 1)]
    return scored(transits, number, np.array(both)[half])


def scored(transits: Transits, number: np.ndarray, thresholds: np.ndarray) -> Score:
    """Scores by thresholds of each transit."""
    raised = highest_held(transits.t, number, transits.struck) >= thresholds
    leads = transits.leads(number, thresholds)
    false = np.where(transits.quiet, raised, np.nan)
    return Score(float(np.mean(thresholds)), false, np.where(np.isnan(leads), np.nan, leads < NEEDED_LEAD), leads)


def first_table(transits: Transits) -> tuple[str, dict[str, list[float]]]:
    """Every predictor at three rates of false alarms, and the thresholds."""
    rows, thresholds = [], {}
    for name, number in predictors(transits.run).items():
        scores = [cross_fitted(transits, number, rate) for rate in RATES]
        thresholds[name] = [score.threshold for score in scores]
        cells = [cell for score in scores for cell in _cells(score)]
        rows.append((name, *cells))
    heads = [head for rate in RATES for head in (f"{100 * rate:g} %: missed [%]", "lead [s]")]
    return markdown(("predictor", *heads), rows), thresholds


def _cells(score: Score) -> tuple[str, str]:
    if not np.isfinite(score.threshold):
        return "tied", "tied"
    return score.share(score.missed), score.lead


def other_rows(physics: Physics, transits: Transits, thresholds: dict[str, list[float]]) -> list[tuple[str, ...]]:
    """Three predictors by the thresholds of the first table, where the truth is another."""
    numbers, rows = predictors(transits.run), []
    for name in (CURVED, ONE_RUN, OURS):
        cells = []
        for threshold in thresholds[name]:
            score = scored(transits, numbers[name], np.full(len(transits.struck), threshold))
            cells.append(f"{100 * np.nanmean(score.false):.1f}; {100 * np.nanmean(score.missed):.1f}; {score.lead}")
        rows.append((physics.words, name, f"{int(transits.aground.sum())}", *cells))
    return rows


def joined(physics: Physics, number: int, skipped: int, count: int, folder: Path | None) -> Transits:
    """Transits of a kind, without the first ones."""
    runs = list(kept_runs(physics, number, range(skipped, skipped + count), folder))
    return Transits({name: np.concatenate([run[name] for run in runs], axis=-1) for name in runs[0]})


def text(folder: Path | None = None, count: int = SCORED, others: int = OTHERS) -> str:
    """Both tables, and what they are of."""
    known = joined(KNOWN, 0, CHOSEN_ON, count, folder)
    first, thresholds = first_table(known)
    kinds = [(KNOWN, known)] + [
        (physics, joined(physics, number, 0, others, folder))
        for number, physics in enumerate(OTHER_TRUTHS, 1)
        if others
    ]
    heads = [f"at {100 * rate:g} %: false [%]; missed [%]; lead [s]" for rate in RATES]
    rows = [row for physics, transits in kinds for row in other_rows(physics, transits, thresholds)]
    second = markdown(("truth", "predictor", "contacts", *heads), rows)
    ours = ", ".join(f"{threshold:.2f}" for threshold in thresholds[OURS])
    late = int((np.isfinite(known.struck) & ~known.aground).sum())
    counts = (
        f"{len(known.struck)} transits: {int(known.aground.sum())} contacts, {int(known.quiet.sum())} quiet ones, "
        f"{late} left out for a contact in the first minute or after the end. Urgency at these rates: {ours}."
    )
    return f"{counts}\n\n{first}\n\nThe same thresholds, where the truth is not what the model says:\n\n{second}"


if __name__ == "__main__":
    asked = dict(zip(sys.argv[1:], sys.argv[2:], strict=False))
    numbers = int(asked.get("--count", SCORED)), int(asked.get("--others", OTHERS))
    publish(__file__, "warning.md", text(Path(asked["--kept"]) if "--kept" in asked else None, *numbers))
