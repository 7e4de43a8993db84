"""Faults of a ship's log, one at a time: what each does to a fit, and how often `nw.check_log` finds it.

    python decisions/log_faults.py [--write]    # into docs/benchmarks.md

A zigzag is of KVLCC2 at full size. Transits are twins of the KCS at 400 m (`transits.py`), each drawn from the
covariance of its tests. Both have the noise of a voyage data recorder. A fault harms a twin where the fit of the spoilt
log has b_bank or c_bank more than half a standard error from that of the good log.
"""

import itertools
import sys
from functools import cache
from pathlib import Path

import numpy as np
from pages import Rows, markdown, part, publish, records
from transits import BANKS, KINDS, ship, twin

import narrows as nw
from narrows.logbook.filtering.likelihood import search
from narrows.logbook.learning.log_setup import log_problem
from narrows.logbook.settings import HARMFUL_SHIFT

sys.path.append(str(Path(__file__).parent.parent / "tests"))
from faults import FAULTS, Spoil, late, moved, off, scaled
from logs import kvlcc2, zigzag

TWINS, GOOD = 12, 40
ZIGZAGS, CLEAN = "every known fault, in a zigzag 20/20", "no fault"
DEGREE = 0.017453292519943295


def over_ground(record: nw.ShipRecord) -> nw.ShipRecord:
    """A log that counts the current."""
    current = np.ptp(record["x"].values) / np.ptp(record["x"].t) - record["u"].values.mean()
    return off(float(current), "u")(record)


# What harms in transits, and what a straight canal hardly shows.
IN_TRANSITS: dict[str, Spoil] = {
    **{name: FAULTS[name][0] for name in (
        "a rudder positive to port", "a rudder half as large", "a rudder 8 s late", "a heading 12 degrees off",
        "a yaw rate half as large", "y to port", "a position that jumps 15 m", "values written ten times",
    )},
    "a rudder read 1.5 times": scaled(1.5, "rudder"), "an antenna at the bow": moved(200.0),
    "a heading 8 s late": late(8.0, "psi"), "a rudder zero of 5 degrees": off(5 * DEGREE, "rudder"),
    "positions 10 s late": late(10.0, "x", "y"), "u read 1.1 times": scaled(1.1, "u"),
    "u over ground": over_ground,
}  # fmt: skip


def in_zigzags() -> tuple[str, ...]:
    """Return how many faults their own check finds in a zigzag."""
    checks = [(nw.check_log([spoil(zigzag(20.0))], kvlcc2()), check) for spoil, check, _ in FAULTS.values()]
    found = sum(any(one.check == check for one in all_found) for all_found, check in checks)
    return "", "", f"{found} of {len(FAULTS)}", "", ""


@cache
def transits(count: int) -> tuple[nw.ShipLog, ...]:
    """Return logs of twins that come through."""
    known = (twin(KINDS[1], seed) for seed in itertools.count())
    return tuple(itertools.islice((one[1] for one in known if one is not None), count))


def bank_fit(log: list[nw.ShipRecord]) -> tuple[np.ndarray, np.ndarray] | None:
    """Return b_bank and c_bank with their standard errors; None where the model cannot follow."""
    posed = log_problem(ship(), log, "vdr")
    found = search(posed.problem, posed)
    if found is None or found.diverged or not found.records:
        return None
    places = [found.problem.prior.names.index(name) for name in BANKS]
    errors = np.sqrt(np.diag(np.linalg.inv(found.information + found.problem.precision)))
    return found.unknowns[places], errors[places]


good_fit = cache(lambda place: bank_fit(list(transits(TWINS)[place])))


def in_transits(spoil: Spoil) -> tuple[str, ...]:
    """Return how far a fault moves the fit, how many twins it harms, in how many it is found, and stops the fit."""
    shifts, found, wrong = [], [], []
    for place, good in enumerate(transits(TWINS)):
        log = [spoil(record) for record in good]
        checked = nw.check_log(log, ship())
        found.append(len(checked) > 0)
        wrong.append(not checked.clean)
        before, after = good_fit(place), bank_fit(log)
        shifts.append(np.max(np.abs(after[0] - before[0]) / before[1]) if before and after else np.inf)
    harmed = np.array(shifts) > HARMFUL_SHIFT
    return (
        f"{np.median(shifts):.1f}", f"{harmed.sum()} of {TWINS}", f"{sum(found)} of {TWINS}",
        f"{sum(wrong)} of {TWINS}", f"{(harmed & np.array(found)).sum()} of {harmed.sum()}" if harmed.any() else "",
    )  # fmt: skip


def text(chosen: tuple[str, ...] = (ZIGZAGS, *IN_TRANSITS, CLEAN)) -> str:
    """Make the table."""
    made = {ZIGZAGS: in_zigzags, CLEAN: without_fault}
    rows = []
    for name in chosen:
        rows.append((name, *(made[name]() if name in made else in_transits(IN_TRANSITS[name]))))
        print(rows[-1], file=sys.stderr, flush=True)
    return markdown(
        ("fault", "shift in transits [standard errors]", "transits harmed", "found", "must be mended",
         "found where it harms"), rows
    )  # fmt: skip


def shown(rows: Rows) -> str:
    """The faults that some logs hide, and the names of the others."""
    found = [row for row in records(rows, "fault") if row["shift in transits [standard errors]"]]
    always = [row["fault"] for row in found if row["found"] == f"{TWINS} of {TWINS}"]
    heads = "fault", "shift in transits [standard errors]", "transits harmed", "found", "found where it harms"
    hidden = part([row for row in found if row["fault"] not in always], *heads)
    return f"Found in all {TWINS} transits: {', '.join(always)}.\n\n{hidden}"


def without_fault() -> tuple[str, ...]:
    """Return in how many good logs something is found, and stops the fit."""
    checked = [nw.check_log(log, ship()) for log in transits(GOOD)]
    found, wrong = sum(len(one) > 0 for one in checked), sum(not one.clean for one in checked)
    return "", "", f"{found} of {GOOD}", f"{wrong} of {GOOD}", ""


if __name__ == "__main__":
    publish(__file__, "benchmarks.md", text(), shown)
