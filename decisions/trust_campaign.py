"""Errors that a whole campaign shares and that no test shows: how often a verdict misleads without naming them.

    python decisions/trust_campaign.py [--write] [--twins 10]

Each row is of so many twins and of the coefficient that is misled most often: the share in which it is identified
while its interval misses the truth, and the share in which this happens and its limits, or the tipping points of a bank
that is not there, do not name the error with a size below the one that was put in. Twins of errors that go with y have
no bank, on runs of the package's own plan.
"""

import sys
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from pages import Rows, markdown, publish, records
from trust_tank import BANK, CONFIGURATION, FULL, HULL, NONE, Columns, Tank, forces, measured

import narrows as nw

TWINS, FIRST, REACH, RUDDER = 10, 7000, 1.3, 0.75  # [m] where an error has its size; [N] per degree at 1 m/s
MAIN = ("b_vdot", "b_v", "b_r", "c_rdot", "c_v", "c_r")
HEADER = ("error, runs", "size", "identified and missed", "and not named")
Law = Callable[[Columns], Columns]
Record = dict[str, np.ndarray]
Spoil = Callable[[np.random.Generator, int, Record], Record]


@cache
def planned(count: int) -> tuple[Any, ...]:
    """The package's own plan."""
    return tuple(nw.plan_tests(CONFIGURATION, count).runs)


def drifting(run: Columns, angle: np.ndarray, bank: dict[str, float]) -> Columns:
    """Forces of a ship that stands askew by an angle [rad] of which the record has nothing."""
    return forces({**run, "v": run["v"] + run["u"] * angle}, bank)


def cable(size: float) -> tuple[Law, Spoil | None]:
    """A cable [N at 1.3 m]."""
    return lambda run: forces(run, NONE), lambda _, __, q: {**q, "Y": q["Y"] + size * q["y"] / REACH}


def heading(size: float) -> tuple[Law, Spoil | None]:
    """A heading proportional to y [degrees at 1.3 m]."""
    return lambda run: drifting(run, np.radians(size) * run["y"] / REACH, NONE), None


def rudder(size: float) -> tuple[Law, Spoil | None]:
    """A rudder trimmed with y [degrees at 1.3 m]."""

    def trimmed(run: Columns) -> Columns:
        own, side = forces(run, NONE), RUDDER * size * run["y"] / REACH * run["u"] ** 2
        return {**own, "Y": own["Y"] + side, "N": own["N"] - CONFIGURATION.ship.length / 2 * side}

    return trimmed, None


def crossflow(size: float) -> tuple[Law, Spoil | None]:
    """A crossflow proportional to y [cm/s at 1.3 m]."""
    return lambda run: drifting(run, 0.01 * size / run["u"] * run["y"] / REACH, NONE), None


def clocks(size: float) -> tuple[Law, Spoil | None]:
    """Forces that are late [s]."""

    def late(_: np.random.Generator, __: int, q: Record) -> Record:
        return {**q, **{f: np.interp(q["t"] - size, q["t"], q[f]) for f in "XYN"}}

    return lambda run: forces(run, BANK), late


def curvature(size: float) -> tuple[Law, Spoil | None]:
    """Gauges of Y and N that read more by a share at 200 N and 200 N m [%]."""

    def curved(_: np.random.Generator, __: int, q: Record) -> Record:
        return {**q, **{f: q[f] * (1 + size / 100 * np.abs(q[f]) / 200) for f in "YN"}}

    return lambda run: forces(run, BANK), curved


def compliance(size: float) -> tuple[Law, Spoil | None]:
    """A mount that turns under N [degrees per 20 N m]."""
    return lambda run: drifting(run, np.radians(size) * forces(run, BANK)["N"] / 20, BANK), None


# Each error, the names of the limits that stand for it, its sizes, and the runs it is tried on.
CASES: tuple[tuple[Callable[[float], tuple[Law, Spoil | None]], str, tuple[float, ...], tuple[int, ...]], ...] = (
    (cable, "force proportional to y", (0.5, 1.5), (12, 18)),
    (heading, "heading proportional to y", (0.1, 0.3), (12, 18)),
    (rudder, "rudder angle proportional to y", (0.5, 2.0), (12,)),
    (crossflow, "crossflow proportional to y", (1.0,), (12,)),
    (clocks, "delay between clocks", (0.05, 0.1, 0.15), (0,)),
    (curvature, "curvature", (5.0, 15.0), (0,)),
    (compliance, "compliance", (0.2, 1.0), (0,)),
)


def row(
    error: Callable[[float], tuple[Law, Spoil | None]], name: str, size: float, count: int, twins: int = TWINS
) -> tuple[str, ...]:
    """One size of an error on a plan of so many runs, or on the usual runs."""
    law, spoil = error(size)
    runs: Sequence[Any] = planned(count) if count else FULL
    names = ("b_bank", "c_bank") if count else ("b_bank", "c_bank", *MAIN)
    truth = {**HULL, **(NONE if count else BANK)}
    missed, silent = np.zeros(len(names)), np.zeros(len(names))
    for seed in range(FIRST, FIRST + twins):
        fit = nw.identify(measured(np.random.default_rng(seed), runs, law, Tank(gain=0.01, spoil=spoil)))
        for i, one in enumerate(names):
            low, high = fit.intervals[one]
            if fit.verdicts[one].status == "identified" and not low <= truth[one] <= high:
                missed[i] += 1 / twins
                silent[i] += (not warned(fit, one, name, size, truth[one])) / twins
    place = f"a plan of {count}" if count else "15 runs"
    word = (error.__doc__ or "").strip().rstrip(".")
    return (f"`{error.__name__}`: {word}, {place}", f"{size:g}", f"{missed.max():.0%}", f"{silent.max():.0%}")


def warned(fit: nw.Fit, coefficient: str, name: str, size: float, truth: float) -> bool:
    """Whether limits or tipping points of a coefficient name the error, with a size below the one that was put in."""
    scale = float(fit.motions.features["reach"].max()) / REACH if "proportional to y" in name else 1.0
    told = (fit.estimates.limits if truth else fit.estimates.tipping)[coefficient]
    return any(effect.name.startswith(name) and least < size * scale for effect, least in told)


def text(twins: int = TWINS) -> str:
    """A row for each size of each error."""
    rows = []
    for error, name, sizes, plans in CASES:
        for count in plans:
            for size in sizes:
                rows.append(row(error, name, size, count, twins))
                print(*rows[-1], file=sys.stderr, flush=True)
    return markdown(HEADER, rows)


def shown(rows: Rows) -> str:
    """A row an error: its sizes and plans, and how often verdicts mislead."""
    found = records(rows, HEADER[0])
    lines = []
    for name in dict.fromkeys(row[HEADER[0]].rpartition(", ")[0] for row in found):
        own = [row for row in found if row[HEADER[0]].startswith(name)]
        sizes, missed = (sorted({float(row[key].rstrip("%")) for row in own}) for key in HEADER[1:3])
        ends = [" to ".join(dict.fromkeys(f"{end:g}" for end in (values[0], values[-1]))) for values in (sizes, missed)]
        lines.append((name.partition(": ")[2], *ends))
    silent = max(float(row[HEADER[3]].rstrip("%")) for row in found)
    table = markdown(("error", "size", "identified and missed [%]"), lines)
    named = (
        f"Up to {silent:.0f} % of the verdicts do not name the error." if silent else "Every verdict names the error."
    )
    return f"{table}\n\n{named}"


if __name__ == "__main__":
    words = sys.argv[1:]
    count = int(words[words.index("--twins") + 1]) if "--twins" in words else TWINS
    publish(__file__, "uncertainty.md", text(count), shown)
