"""Contacts that a warning averts, beside its false alerts: the table of docs/warning.md.

Ships of 230 m sail an hour on a canal with bends and narrows. Hands of four kinds steer; every ship has its own
coefficients, current, gusts, meetings and indicator. Half of the ships have a lapse: the rudder is forgotten, put over
to the wrong side, or the bank grows; most lapses that end well are left out. Ships that their hand cannot hold in a
calm hour are left out too. The estimator knows the ships by fixes, compass, rate of turn and log.

After an alert a person takes a log-normal time to react (median 10 s, 95 % under 25 s) and then steers the escape in
the true simulation. Averted is a contact that does not happen then. False is an alert in a transit without a lapse
that no contact follows within 300 s; near misses after a lapse are counted apart. A threshold is the lowest at which
so many false alerts come in 100 hours, found in one half of the transits and used in the other, both ways round.
Intervals hold 90 % of draws of the contacts with replacement.

python decisions/warning_scores.py [--write] [--kept FOLDER] [--parts PARTS]
"""

import sys
from pathlib import Path

import numpy as np
from pages import markdown, publish
from watched.runs import BEFORE, EVERY, FROM, Run, averted, kept_runs
from watched.truths import Physics

from narrows.warning.transit_scores import alert_spells

RATES, DELAYS, DRAWS, WITHIN = (10.0, 2.0), 8, 1000, (0.05, 0.95)
"""False alerts in 100 hours; reactions to each alert; draws of an interval."""
MEDIAN, LATE = 10.0, 25.0
"""Of the reaction [s]: half are faster, and 95 %."""
KNOWN, PARTS = Physics("as the model has it, its coefficients drawn from their covariance"), 3
Runs = list[tuple[int, Run]]


def predictors(run: Run) -> dict[str, np.ndarray]:
    """Numbers that grow with the danger, (times, transits)."""

    def by_time(time: np.ndarray) -> np.ndarray:
        return 1.0 / np.maximum(time.astype(float), 0.5)

    left = np.maximum(run["last_chance"], 0.0)
    return {
        "distance to the bank": by_time(run["room"]), "curved by the rate of turn": by_time(run["curve"]),
        "one run of the model": by_time(run["contact"]), "last chance: the package's rule": by_time(left),
    }  # fmt: skip


def spells(run: Run, number: np.ndarray, threshold: float, which: np.ndarray) -> dict[int, list[float]]:
    """When alerts were raised in some transits, while they were afloat."""
    t = FROM + EVERY * np.arange(len(number), dtype=float)
    raised = {}
    for ship in which[number[:, which].max(axis=0) >= threshold].tolist():
        afloat = t < run["struck"][ship]
        raised[ship] = [start for start, _ in alert_spells(t[afloat], number[afloat, ship] / threshold)]
    return raised


def false_alerts(run: Run, number: np.ndarray, threshold: float, which: np.ndarray) -> int:
    starts = spells(run, number, threshold, which)
    struck = run["struck"]
    return sum(not struck[ship] - BEFORE <= start < struck[ship] for ship, own in starts.items() for start in own)


def threshold_at(runs: Runs, name: str, rate: float, half: int) -> float:
    """The lowest with no more false alerts in 100 h, by the ships of one half."""
    parts = [(run, predictors(run)[name], _normal(run, half)) for _, run in runs]
    hours = sum(_hours(run, which) for run, _, which in parts)
    levels = np.unique(np.concatenate([number[:, which].max(axis=0) for _, number, which in parts]))
    for level in levels:
        if 100.0 * sum(false_alerts(run, number, level, which) for run, number, which in parts) <= rate * hours:
            return float(level)
    return float(levels[-1]) * 1.001


def _normal(run: Run, half: int) -> np.ndarray:
    ships = np.flatnonzero(~run["lapse"])
    return ships[ships // 2 % 2 == half]


def _hours(run: Run, which: np.ndarray) -> float:
    end = FROM + EVERY * len(run["room"])
    return float((np.minimum(run["struck"][which], end) - FROM).sum() / 3600.0)


def row(
    physics: Physics, runs: Runs, name: str, thresholds: tuple[float, float]
) -> tuple[np.ndarray, list[float], float]:
    """Share of reactions that avert each contact, the last chance when it was warned, and false alerts in 100 h."""
    saved, left, false, hours = [], [], 0, 0.0
    random = np.random.default_rng(2)
    for seed, run in runs:
        number, met = predictors(run)[name], run["met"]
        warned = np.full(len(met), np.inf)
        for half, threshold in enumerate(thresholds):
            false += false_alerts(run, number, threshold, _normal(run, half))
            hours += _hours(run, _normal(run, half))
            starts = spells(run, number, threshold, met[met // 2 % 2 == half])
            for place, ship in enumerate(met.tolist()):
                known = [start for start in starts.get(ship, []) if start >= run["struck"][ship] - BEFORE]
                warned[place] = min([warned[place], *known])
        delays = MEDIAN * np.exp(np.log(LATE / MEDIAN) / 1.645 * random.standard_normal((len(met), DELAYS)))
        which = np.repeat(np.arange(len(met)), DELAYS)
        clear, _ = averted(physics, seed, run, which, np.ceil(warned[:, None] + delays).ravel())
        saved.append(clear.reshape(-1, DELAYS).mean(axis=1))
        place = np.where(np.isfinite(warned), (warned - FROM) // EVERY, 0).astype(int)
        left += np.where(np.isfinite(warned), np.clip(run["last_chance"][place, met], 0, BEFORE), 0.0).tolist()
    return np.concatenate(saved), left, 100.0 * false / hours


def text(folder: Path | None = None, parts: int = PARTS) -> str:
    """The table, and what it is of."""
    runs = list(kept_runs(KNOWN, 0, range(parts), folder))
    rows = []
    for name in predictors(runs[0][1]):
        cells = []
        for rate in RATES:
            thresholds = threshold_at(runs, name, rate, 1), threshold_at(runs, name, rate, 0)
            saved, left, false = row(KNOWN, runs, name, thresholds)
            drawn = saved[np.random.default_rng(0).integers(0, len(saved), (DRAWS, len(saved)))].mean(axis=1)
            low, high = 100.0 * np.quantile(drawn, WITHIN)
            cells += [f"{100 * saved.mean():.0f} ({low:.0f} to {high:.0f})", f"{np.median(left):.0f}", f"{false:.0f}"]
        rows.append((name, *cells))
    heads = [f"{rate:g}: {what}" for rate in RATES for what in ("averted [%]", "left to act [s]", "false")]
    count = sum(len(run["met"]) for _, run in runs), sum(len(run["struck"]) for _, run in runs)
    return f"{count[0]} contacts in {count[1]} transits of an hour.\n\n{markdown(('predictor', *heads), rows)}"


if __name__ == "__main__":
    asked = dict(zip(sys.argv[1:], sys.argv[2:], strict=False))
    kept = Path(asked["--kept"]) if "--kept" in asked else None
    publish(__file__, "warning.md", text(kept, int(asked.get("--parts", PARTS))))
