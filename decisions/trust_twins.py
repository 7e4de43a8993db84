"""How often a verdict misleads and an interval misses, on twins that break assumptions: a table of the docs.

    python decisions/trust_twins.py [--write] [--counted] [--twins 10] [--processes 2] [kind ...]

Each cell is of so many twins: the share in which a coefficient of the bank is called identified while its interval
misses the truth, how often it is identified, and how often its interval holds the truth. Honest kinds, whose errors
are those of runs alone, also have the half width over that of an oracle, which knows the errors' covariance.
All rows are in ``trust_twins.csv``; the page has those that mislead. With ``--counted`` the file is read, not computed.
"""

import csv
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
from pages import markdown, publish
from trust_kinds import HULL, KINDS, Kind
from trust_oracle import HONEST, oracle

import narrows as nw

TWINS, FIRST = 10, 5000
MAIN = ("b_vdot", "b_v", "b_r", "c_rdot", "c_v", "c_r")
TABLE = Path(__file__).with_suffix(".csv")
NAMES = ("b_bank", "c_bank", *MAIN)
HEADER = (
    "kind", "strength", "identified and missed", "b_bank identified", "b_bank covered", "c_bank identified",
    "c_bank covered", "hull covered", "half width of b_bank; all eight, over an oracle's",
)  # fmt: skip


def judged(kind: Kind, strength: float, seed: int) -> list[tuple[bool, bool, float]]:
    """Of each coefficient of a twin: whether it is identified, whether its interval holds the truth, the half width."""
    tests, truth = kind(np.random.default_rng(seed), strength)
    truth = {**HULL, **truth}
    fit = nw.identify(tests, "paper+keel_gap" if kind.__name__ == "hull_by_depth" else "paper")
    ends = fit.intervals
    return [
        (fit.verdicts[n].status == "identified", ends[n][0] <= truth[n] <= ends[n][1], (ends[n][1] - ends[n][0]) / 2)
        for n in NAMES
    ]


def row(kind: Kind, strength: float, twins: int = TWINS, processes: int = 1) -> tuple[str, ...]:
    """One strength of a kind."""
    with ProcessPoolExecutor(processes) as pool:
        seen = np.array(list(pool.map(partial(judged, kind, strength), range(FIRST, FIRST + twins))), float)
    found, held, half = np.moveaxis(seen, 2, 0)
    missed = (found * (1 - held))[:, :2].any(axis=1).mean()
    shares = (missed, found[:, 0].mean(), held[:, 0].mean(), found[:, 1].mean(), held[:, 1].mean())
    hull, ratio = "", ""
    if kind.__name__ in HONEST:
        best = oracle(kind.__name__, strength)
        over = half.mean(axis=0) / (1.96 * np.array([best[name] for name in NAMES]))
        hull, ratio = f"{held[:, 2:].mean():.0%}", f"{over[0]:.2g}; {np.median(over):.2g}"
    word = (kind.__doc__ or "").strip().rstrip(".")
    return (f"`{kind.__name__}`: {word}", f"{strength:g}", *(f"{share:.0%}" for share in shares), hull, ratio)


def counted(twins: int, processes: int, kinds: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Count, and return a row for each strength of each kind."""
    chosen = {kind: strengths for kind, strengths in KINDS.items() if not kinds or kind.__name__ in kinds}
    rows = []
    for kind, strengths in chosen.items():
        for strength in strengths:
            rows.append(row(kind, strength, twins, processes))
            print(rows[-1][0][:40], *rows[-1][1:], file=sys.stderr, flush=True)
    return rows


def kept() -> list[tuple[str, ...]]:
    """Rows of the file."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        return [tuple(line) for line in csv.reader(file)][1:]


def misled(rows: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Rows in which a verdict misleads."""
    return [line for line in rows if line[2] != "0%"]


def by_kind(rows: list[tuple[str, ...]]) -> str:
    """A row a kind, with all strengths: how often a verdict misleads, how often the intervals hold the truth."""
    lines = []
    for kind in dict.fromkeys(line[0] for line in rows):
        own = [line for line in rows if line[0] == kind]
        lines.append((kind, *(", ".join(line[k].rstrip("%") for line in own) for k in (1, 2, 4, 6))))
    return markdown(("kind", "strengths s", *(f"{HEADER[k]} [%]" for k in (2, 4, 6))), lines)


def text(rows: list[tuple[str, ...]]) -> str:
    """Write the rows in which a verdict misleads, and what the others have in common."""
    missed, honest = misled(rows), [line for line in rows if line[8]]
    complete = sum(line[2] == "0%" and {line[4], line[6]} == {"100%"} for line in rows)
    least = min((line for line in rows if line[2] == "0%"), key=lambda line: int(line[4].rstrip("%")))
    over = np.array([[float(value) for value in line[8].split(";")] for line in honest]).reshape(-1, 2)
    hull = [float(line[7].rstrip("%")) for line in honest]
    others = f"In the other {len(rows) - len(missed)} of {len(rows)} cases no verdict misleads"
    lines = [
        f"{others}, and in {complete} of them all intervals hold the truth. "
        f"The lowest share is {least[4]} of b_bank, in {least[0].partition(':')[0]} at {least[1]}."
    ]
    if honest:
        lines.append(
            f"In honest kinds {min(hull):.0f} to {max(hull):.0f} % of the hull's intervals hold the truth; "
            f"half widths are {over[:, 0].min():.2g} to {over[:, 0].max():.2g} times the oracle's for b_bank, "
            f"{over[:, 1].min():.2g} to {over[:, 1].max():.2g} times in the median of eight coefficients."
        )
    return "\n".join([by_kind(missed), "", *lines])


if __name__ == "__main__":
    given = [word for word in sys.argv[1:] if word != "--write"]
    twins, processes = (
        int(given.pop(given.index(name) + 1)) if name in given else usual
        for name, usual in (("--twins", TWINS), ("--processes", 1))
    )
    kinds = tuple(word for word in given if not word.startswith("--"))
    rows = kept() if "--counted" in given else counted(twins, processes, kinds)
    if "--write" in sys.argv and not kinds:
        with TABLE.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([HEADER, *rows])
    publish(__file__, "uncertainty.md", text(rows))
