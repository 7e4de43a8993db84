"""Faults of a ship's log, one at a time: which `nw.check_log` finds, by manoeuvre, and what it finds where none is.

    python decisions/log_faults.py [--write]    # into docs/benchmarks.md

Twins of KVLCC2 at full size, with the noise of a voyage data recorder.
"""

import sys
from collections.abc import Callable
from pathlib import Path

from pages import markdown, publish

import narrows as nw

sys.path.append(str(Path(__file__).parent.parent / "tests"))
from faults import FAULTS, Spoil
from logs import bend, bent_waterway, circle, kvlcc2, zigzag

SEEDS = 5
MANOEUVRES: dict[str, tuple[Callable[[int], nw.ShipRecord], nw.Waterway | None]] = {
    "a zigzag 20/20": (lambda seed: zigzag(20.0, seed), None),
    "a turning circle": (lambda seed: circle(35.0, seed), None),
    "a way round a bend": (bend, bent_waterway(length=9000.0)),
}


def said(manoeuvre: str, spoil: Spoil, check: str) -> str:
    """Whether a fault is found by its own check: always, at times, or by another that stops there."""
    record, waterway = MANOEUVRES[manoeuvre]
    found = [nw.check_log([spoil(record(seed))], kvlcc2(), waterway) for seed in range(SEEDS)]
    own = sum(any(one.check == check for one in log.wrong) for log in found)
    if own in (0, SEEDS):
        return "found" if own else "by another" if all(log.wrong for log in found) else "–"
    return "at times"


def text() -> str:
    """Make the table."""
    rows = [(fault, *(said(name, spoil, check) for name in MANOEUVRES)) for fault, (spoil, check, _) in FAULTS.items()]
    false = [
        str(sum(len(nw.check_log([record(seed)], kvlcc2(), way)) for seed in range(SEEDS)))
        for record, way in MANOEUVRES.values()
    ]
    return markdown(("fault", *MANOEUVRES), [*rows, (f"findings in {SEEDS} records without a fault", *false)])


if __name__ == "__main__":
    publish(__file__, "benchmarks.md", text())
