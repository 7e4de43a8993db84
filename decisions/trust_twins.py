"""How often a verdict misleads and an interval misses, on twins that break assumptions: a table of the docs.

    python decisions/trust_twins.py [--write] [kind ...]

Each cell of a strength has a hundred twins: the share in which a coefficient of the bank is called identified while its
interval misses the truth, how often b_bank is called identified, and how often its interval holds the truth.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np
from pages import markdown, publish
from trust_kinds import KINDS, Kind

import narrows as nw

TWINS, FIRST = 100, 5000
HEADER = (
    "kind",
    "strength",
    "identified and missed",
    "b_bank identified",
    "b_bank held",
    "c_bank identified",
    "c_bank held",
)


def judged(kind: Kind, strength: float, seed: int) -> list[tuple[bool, bool]]:
    """Of b_bank and c_bank of a twin: whether it is called identified, and whether its interval holds the truth."""
    tests, truth = kind(np.random.default_rng(seed), strength)
    fit = nw.identify(tests, "paper+keel_gap" if kind.__name__ == "hull_by_depth" else "paper")
    ends = fit.intervals
    return [
        (fit.verdicts[n].status == "identified", ends[n][0] <= truth[n] <= ends[n][1]) for n in ("b_bank", "c_bank")
    ]


def row(kind: Kind, strength: float, twins: int = TWINS) -> tuple[str, ...]:
    """One strength of a kind."""
    with ProcessPoolExecutor() as pool:
        seen = np.array(list(pool.map(partial(judged, kind, strength), range(FIRST, FIRST + twins))))
    missed = (seen[:, :, 0] & ~seen[:, :, 1]).any(axis=1).mean()
    shares = (missed, *(seen[:, i, j].mean() for i in (0, 1) for j in (0, 1)))
    word = (kind.__doc__ or "").strip().rstrip(".")
    return (f"`{kind.__name__}`: {word}", f"{strength:g}", *(f"{share:.0%}" for share in shares))


def text(twins: int = TWINS, kinds: tuple[str, ...] = ()) -> str:
    """Count, and write a row for each strength of each kind."""
    chosen = {kind: strengths for kind, strengths in KINDS.items() if not kinds or kind.__name__ in kinds}
    return markdown(HEADER, [row(kind, s, twins) for kind, strengths in chosen.items() for s in strengths])


if __name__ == "__main__":
    publish(__file__, "uncertainty.md", text(kinds=tuple(own for own in sys.argv[1:] if own != "--write")))
