"""Contacts that a warning averts, beside its false alerts: the tables of docs/benchmarks.md.

Ships of 230 m sail an hour on a canal with bends and narrows. Hands of four kinds steer; every ship has its own
coefficients, current, gusts, meetings and indicator. Half of the ships have a lapse: the rudder is forgotten, put over
to the wrong side, or the bank grows; most lapses that end well are left out. Ships that their hand cannot hold in a
calm hour are left out too. The estimator knows the ships by fixes, compass, rate of turn and log.

After an alert a person takes a log-normal time to react (median 10 s, 95 % under 25 s) and then steers the escape in
the true simulation. Averted is a contact that does not happen then. False is an alert in a transit without a lapse
that no contact follows within 300 s; needless is one whose advice the hand is following already. A threshold is the
lowest at which so many false alerts come in 100 hours, found in one half of the transits and used in the other, both
ways round. Intervals hold 90 % of draws of the contacts with replacement. The bound is an alert at the first second of
every lapse, and none else. With --others come truths of other kinds, at the levels as they are.

python decisions/warning_scores.py [--write] [--others] [--kept FOLDER]
"""

import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pages import Rows, markdown, part, publish, records
from scipy.special import ndtr
from watched.runs import BEFORE, EVERY, FROM, Run, averted, kept_runs
from watched.truths import DEPTH, LAPSES, LENGTH, Physics, modelled

from narrows.warning.forecasting.forecaster import level_time
from narrows.warning.forecasting.helmsman import escape_numbers
from narrows.warning.monitoring.watched_transit import alert_spells
from narrows.warning.settings import CLEAR_SHARE, LEVELS, NEAR_MISS

RATES, DRAWS, WITHIN = (10.0, 2.0), 1000, (0.05, 0.95)
"""False alerts in 100 hours; draws of an interval."""
MEDIAN, LATE = 10.0, 25.0
"""Of the reaction [s]: half are faster, and 95 %."""
KNOWN, PARTS = Physics("the model, its coefficients drawn from their covariance"), 2
OTHERS = (
    Physics("helmsmen who jump to a new line", abrupt=True), Physics("banks exponential in the gap", exponential=True),
    Physics("coefficients twice as far off", spread=2.0), Physics("a tenth less water", depth=0.9 * DEPTH),
    Physics("a current with shear, ahead and across", shear=0.3), Physics("helmsmen of other kinds", other_hands=True),
)  # fmt: skip
RULE, CURVED = "time to act and the helmsman: the rule of the package", "curved by the rate of turn"
MINUTE, SEEN, DOING = 60.0, 10.0, np.radians(10.0)
"""In which "clear" is wrong, and after which a lapse could be seen [s]; how near the rudder is to what is advised where
that is done already."""
WRONG_ORDER_TIMES = 0.0, 20.0, 30.0, 40.0, 50.0


def by_time(time: np.ndarray) -> np.ndarray:
    return 1.0 / np.maximum(time.astype(float), 0.5)


def predictors(run: Run) -> dict[str, np.ndarray]:
    """Numbers that grow with the danger, (times, transits)."""
    left = np.maximum(run["last_chance"], 0.0)
    return {
        "distance to the bank": by_time(run["room"]), CURVED: by_time(run["curve"]),
        "one run of the model": by_time(run["contact"]), "chance that the escape fails": run["failing"].astype(float),
        "time to act alone": by_time(left),
        RULE: by_time(level_time(run["last_chance"], run["nobody"])),
    }  # fmt: skip


def spells(run: Run, number: np.ndarray, threshold: float, which: np.ndarray) -> dict[int, list[float]]:
    """When alerts were raised in some transits, while they were afloat."""
    t = FROM + EVERY * np.arange(len(number), dtype=float)
    raised = {}
    for ship in which[number[:, which].max(axis=0) >= threshold].tolist():
        afloat = t < run["struck"][ship]
        raised[ship] = [start for start, _ in alert_spells(t[afloat], number[afloat, ship] / threshold)]
    return raised


def false_alerts(run: Run, number: np.ndarray, threshold: float, which: np.ndarray) -> np.ndarray:
    """How many alerts no contact follows: false ones, and needless ones, whose advice is done already."""
    struck, starts = run["struck"], spells(run, number, threshold, which)
    found = [
        (int(start), ship) for ship, own in starts.items() for start in own
        if not struck[ship] - BEFORE <= start < struck[ship]
    ]  # fmt: skip
    seen = [run["seen"][t, :, ship] for t, ship in found]
    done = sum(bool(abs(one[4] - advice(*one[:4], one[5])) < DOING) for one in seen)
    return np.array([len(found) - done, done])


def advice(y: float, psi: float, turn: float, u: float, across: float) -> float:
    """The rudder that the escape orders [rad]."""
    limit = modelled().configuration.gear.limit
    law = escape_numbers(0.0, LENGTH, limit)
    course = np.clip(-y * law["reach"], -law["approach"], law["approach"])
    off = psi + across / max(u, 0.1) - course
    return float(np.clip(-law["by_psi"] * off - law["by_r"] * turn / max(u, 0.1), -limit, limit))


class Watch(NamedTuple):
    """Transits of a kind, and what becomes of their contacts if a person is alerted 0, 2, 4 ... s before."""

    runs: list[Run]
    averted: list[np.ndarray]  # (contacts, times) By the mean over reactions [1]
    gained: list[np.ndarray]  # (contacts, times) Least water beside the hull, 0 at a contact [m]

    @property
    def contacts(self) -> int:
        return sum(len(run["met"]) for run in self.runs)


@cache
def watch(number: int, folder: Path | None) -> Watch:
    physics = OTHERS[number - 1] if number else KNOWN
    runs, averts, gains = [], [], []
    before = np.arange(0.0, BEFORE + EVERY, EVERY)
    weights = np.diff(ndtr(np.log(np.maximum(before, 1e-9) / MEDIAN) / (np.log(LATE / MEDIAN) / 1.645)), prepend=0.0)
    for seed, run in kept_runs(physics, number, range(1 if number else PARTS), folder):
        struck = np.ceil(run["struck"][run["met"]])
        which = np.repeat(np.arange(len(struck)), len(before))
        for found, kept in zip(
            averted(physics, seed, run, which, (struck[:, None] - before).ravel()), (averts, gains), strict=True
        ):
            by_time = found.reshape(len(struck), -1).astype(float)
            kept.append(np.array([np.convolve(weights, row)[: len(row)] for row in by_time]))
        runs.append(run)
    return Watch(runs, averts, gains)


def half_of(ships: np.ndarray) -> np.ndarray:
    return ships // 2 % 2


def normal(run: Run, half: int | None = None) -> np.ndarray:
    ships = np.flatnonzero(~run["lapse"])
    return ships if half is None else ships[half_of(ships) == half]


def hours(run: Run, which: np.ndarray) -> float:
    end = FROM + EVERY * len(run["room"])
    return float((np.minimum(run["struck"][which], end) - FROM).sum() / 3600.0)


def threshold_at(runs: list[Run], name: str, rate: float, half: int | None = None) -> float:
    """The lowest with no more false alerts in 100 h, by the ships of one half, or by all."""
    parts = [(run, predictors(run)[name], normal(run, half)) for run in runs]
    most = rate * sum(hours(run, which) for run, _, which in parts) / 100.0
    levels = np.unique(np.concatenate([number[:, which].max(axis=0) for _, number, which in parts]))
    first, last = 0, len(levels) - 1
    while first < last:
        middle = (first + last) // 2
        few = sum(false_alerts(run, number, levels[middle], which)[0] for run, number, which in parts) <= most
        first, last = (first, middle) if few else (middle + 1, last)
    return float(levels[first]) * 1.0001


class Score(NamedTuple):
    averted: np.ndarray  # (contacts,) Share of the reactions [1]
    gained: np.ndarray  # (contacts,) [m]
    left: np.ndarray  # (contacts,) To act by the forecast when it was raised; 0 where it was not [s]
    false: np.ndarray  # In 100 hours, and needless ones


def score(known: Watch, name: str, thresholds: tuple[float, float]) -> Score:
    """What alerts at a threshold of each half achieve."""
    averts, gains, left, false = [], [], [], np.zeros(2)
    for run, share, gained in zip(known.runs, known.averted, known.gained, strict=True):
        number, met = predictors(run)[name], run["met"]
        warned = np.full(len(met), np.inf)
        for half, threshold in enumerate(thresholds):
            false += false_alerts(run, number, threshold, normal(run, half))
            starts = spells(run, number, threshold, met[half_of(met) == half])
            for place, ship in enumerate(met.tolist()):
                since = [start for start in starts.get(ship, []) if start >= run["struck"][ship] - BEFORE]
                warned[place] = min([warned[place], *since])
        averts.append(at_alert(run, share, warned))
        gains.append(at_alert(run, gained, warned))
        place = np.where(np.isfinite(warned), (warned - FROM) / EVERY, 0).astype(int)
        left.append(np.where(np.isfinite(warned), np.clip(run["last_chance"][place, met], 0, BEFORE), 0.0))
    watched = sum(hours(run, normal(run)) for run in known.runs)
    return Score(*(np.concatenate(parts) for parts in (averts, gains, left)), 100.0 * false / watched)


def at_alert(run: Run, values: np.ndarray, warned: np.ndarray) -> np.ndarray:
    """Values of the time at which each contact was warned of; 0 where it was not."""
    before = np.where(np.isfinite(warned), run["struck"][run["met"]] - warned, 0.0)
    return values[np.arange(len(values)), np.clip(before // EVERY, 0, BEFORE // EVERY).astype(int)]


def bound(known: Watch, after: float = 0.0) -> np.ndarray:
    """What an alert at a time after each lapse averts; a contact without one is warned of as early as can be."""
    shares = []
    for run, share in zip(known.runs, known.averted, strict=True):
        struck, when = run["struck"][run["met"]], run["when"][run["met"]]
        warned = np.maximum(np.where(np.isfinite(when), when + after, 0.0), struck - BEFORE)
        shares.append(at_alert(run, share, warned))
    return np.concatenate(shares)


def percent(share: np.ndarray) -> str:
    drawn = share[np.random.default_rng(0).integers(0, len(share), (DRAWS, len(share)))].mean(axis=1)
    low, high = 100.0 * np.quantile(drawn, WITHIN)
    return f"{100 * share.mean():.0f} ({low:.0f} to {high:.0f})"


def of_predictors(known: Watch) -> str:
    rows = []
    for name in predictors(known.runs[0]):
        many, few = (
            score(known, name, (threshold_at(known.runs, name, rate, 1), threshold_at(known.runs, name, rate, 0)))
            for rate in RATES
        )
        rows.append((
            name, percent(many.averted), percent(few.averted), f"{many.gained.mean():.0f}",
            f"{np.median(many.left):.0f}", "; ".join(f"{one.false[0]:.0f}, {one.false[1]:.0f}" for one in (many, few)),
        ))  # fmt: skip
    rows.append(("bound: each lapse is seen at once", *(2 * (percent(bound(known)),)), "", "", ""))
    heads = (
        "averted at 10 [%]",
        "averted at 2 [%]",
        "water gained [m]",
        "left to act [s]",
        "false, needless in 100 h at 10; at 2",
    )
    return markdown(("predictor", *heads), rows)


def of_levels(known: Watch) -> str:
    rows = []
    for level, time in reversed(LEVELS.items()):
        found = score(known, RULE, (1.0 / time, 1.0 / time))
        rows.append(
            (
                level,
                percent(found.averted),
                f"{np.median(found.left):.0f}",
                f"{found.false[0]:.0f}",
                f"{found.false[1]:.0f}",
            )
        )
    return markdown(("level", "averted [%]", "left to act [s]", "false in 100 h", "needless in 100 h"), rows)


def of_others(known: Watch, folder: Path | None) -> str:
    """Averted in truths of other kinds [%], and false alerts in 100 hours: thresholds are those of the known truth."""
    chosen = (
        (RULE, 1.0 / LEVELS["warning"]),
        (RULE, 1.0 / LEVELS["alarm"]),
        (CURVED, threshold_at(known.runs, CURVED, RATES[0])),
    )
    rows = []
    for number, physics in enumerate((KNOWN, *OTHERS)):
        other = watch(number, folder)
        found = [score(other, name, (threshold, threshold)) for name, threshold in chosen]
        sailed = any(len(normal(run)) for run in other.runs)
        false = "; ".join(f"{one.false[0]:.0f}" for one in found) if sailed else "-"
        averts = (percent(share) for share in (*(one.averted for one in found), bound(other)))
        rows.append((physics.words, f"{other.contacts}", *averts, f"{np.median(found[0].left):.0f}", false))
    heads = "contacts", "warning", "alarm", "curved", "bound", "left to act at the warning [s]", "false in 100 h"
    return markdown(("truth", *heads), rows)


def of_clear(known: Watch) -> str:
    """How often "clear" was told within a minute before the last chance went, by what a wrong order must leave."""
    rows = []
    for least in WRONG_ORDER_TIMES:
        told, shares = [], []
        for run in known.runs:
            calm = np.isinf(run["last_chance"]) & (run["as_is"] <= CLEAR_SHARE) & (run["room"] >= NEAR_MISS)
            calm &= run["wrong_order"] >= least
            told += clear_before(run, calm)
            shares.append(calm[:, normal(run)].mean())
        kinds, since = np.array(told).reshape(-1, 2).T
        counts = (f"{(kinds == kind).sum()}, {((kinds == kind) & (since >= SEEN)).sum()}" for kind in range(4))
        rows.append((f"{least:.0f} s" if least else "not required", *counts, f"{100 * np.mean(shares):.0f}"))
    gone = sum(int(last_chances_gone(run).sum()) for run in known.runs)
    text = (
        f'The last chance passed in {gone} cases. How often "clear" was shown within {MINUTE:.0f} s before, and how '
        f"often {SEEN:.0f} s or more after the lapse began:"
    )
    return f"{text}\n\n" + markdown(
        ("time required after a wrong order", *LAPSES, "no lapse", "safe time clear [%]"), rows
    )


def last_chances_gone(run: Run) -> np.ndarray:
    t = FROM + EVERY * np.arange(1, len(run["last_chance"]))
    goes = (run["last_chance"][1:] < 0) & (run["last_chance"][:-1] >= 0)
    return np.asarray(goes & (t[:, None] < run["struck"]))


def clear_before(run: Run, calm: np.ndarray) -> list[tuple[int, float]]:
    """Kind of lapse, 3 without one, and how long after it began [s], of each last "clear" in such a minute."""
    told = []
    for place, ship in np.argwhere(last_chances_gone(run)):
        minute = np.arange(max(place + 1 - int(MINUTE / EVERY), 0), place + 1)
        clear = minute[calm[minute, ship]]
        since = FROM + EVERY * clear[-1:] - run["when"][ship]
        # A lapse that began more than five minutes before is not the cause.
        lapse = run["lapse"][ship] and (since < BEFORE).all()
        told += [(int(run["kind"][ship]) if lapse else len(LAPSES), float(one)) for one in since]
    return told


def text(folder: Path | None = None, others: bool = False) -> str:
    known = watch(0, folder)
    counted = f"{known.contacts} contacts in {sum(len(run['struck']) for run in known.runs)} transits of an hour."
    parts = [
        counted,
        of_predictors(known),
        "Alert levels with the default thresholds:",
        of_levels(known),
        of_clear(known),
    ]
    if others:
        words = (
            "Truths of other kinds: averted [%]; false alerts in 100 h at the warning, the alarm, and the curved track:"
        )
        parts += [words, of_others(known, folder)]
    return "\n\n".join(parts)


PARTS_OF_RULE = ("chance that the escape fails", "time to act alone")


def shown(rows: Rows) -> str:
    """What an alert averts by predictor, by level and by truth."""
    counted, levels, *_ = (row[0] for row in rows if len(row) == 1)
    rules = [row for row in records(rows, "predictor") if row["predictor"] not in PARTS_OF_RULE]
    truths = records(rows, "truth")[1:]
    others = [(row["truth"], row["warning"], row["false in 100 h"].partition(";")[0]) for row in truths]
    parts = (
        part(rules, "predictor", "averted at 10 [%]", "averted at 2 [%]", "left to act [s]"),
        levels,
        part(records(rows, "level"), "level", "averted [%]", "left to act [s]", "false in 100 h"),
        "The warning with truths of other kinds (-: not counted):",
        markdown(("truth", "averted [%]", "false in 100 h"), others),
    )
    return "\n\n".join((counted, *parts))


if __name__ == "__main__":
    asked = dict(zip(sys.argv[1:], sys.argv[2:], strict=False))
    kept = Path(asked["--kept"]) if "--kept" in asked else None
    publish(__file__, "benchmarks.md", text(kept, "--others" in sys.argv), shown)
