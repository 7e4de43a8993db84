"""How often the 95 % intervals hold the truth, on synthetic tests whose truth is known.

    python decisions/interval_coverage.py [--write]

Two sets of tests (the paper's three, and sixteen runs with both kinds at several speeds), white noise and noise that
is correlated over a second, and a truth with two coefficients on their bounds: b_v = c_r = 0. Runs differ by noise
alone, and the fit is told so. A cell is the share of twins whose interval holds the coefficient of its column; with
200 twins it is sure to 3 either way.
"""

from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np
from pages import markdown, publish

import narrows as nw
from narrows.captive.synthetic import PAPER_RUNS

PUBLISHED = nw.published("mikkelsen2025_dtc")
TRUTHS = {"inside": PUBLISHED, "two at a bound": PUBLISHED.with_coefficients(b_v=0.0, c_r=0.0)}
SHAPES = [(0.9, 25, 1.0), (0.3, 12, 1.0), (0.6, 18, 1.0), (0.9, 30, 0.8), (0.5, 16, 0.8), (0.7, 22, 0.6)]
SHAPES += [(0.4, 20, 0.6), (0.8, 20, 1.0)]
MANY_RUNS = tuple(
    nw.HarmonicRun(f"{kind} {a} m {period} s {u} m/s", kind, a, period, u)
    for kind in ("yaw", "sway")
    for a, period, u in SHAPES
)
RUNS = {"3 runs": PAPER_RUNS, "16 runs": MANY_RUNS}
COLUMNS = tuple(term.name for term in (*nw.PAPER.sway, *nw.PAPER.yaw))
TWINS, RESAMPLES = 200, 500


def covered(truth: str, runs: str, correlation: float, kind: str, seed: int) -> list[bool]:
    """Fit one twin and say of which coefficients its intervals hold the truth."""
    tests = nw.twin(TRUTHS[truth], RUNS[runs], correlation_time=correlation, seed=seed, rate=10.0)
    fit = nw.identify(tests, errors=nw.RunErrors(0, 0, 0))
    intervals = fit.intervals if kind == "identify" else fit.bootstrap(RESAMPLES, kind, seed).intervals()
    return [intervals[n][0] <= TRUTHS[truth].coefficients[n] <= intervals[n][1] for n in COLUMNS]


def text() -> str:
    """Count, and write a row for each configuration."""
    settings = [(t, r, c, "identify") for t in TRUTHS for r in RUNS for c in (0.0, 1.0)]
    settings += [(t, "16 runs", 1.0, kind) for t in TRUTHS for kind in ("errors", "tests")]
    rows = []
    with ProcessPoolExecutor() as pool:
        for case in settings:
            count = TWINS if case[-1] == "identify" else TWINS // 2
            held = np.array(list(pool.map(partial(covered, *case), range(count), chunksize=25)))
            truth, runs, correlation, kind = case
            said = "identify" if kind == "identify" else f"bootstrap, {kind}"
            rows.append(
                (truth, runs, f"{correlation:g} s", said, *(f"{100 * share:.1f}" for share in held.mean(axis=0)))
            )
    return markdown(("truth", "tests", "correlation", "intervals", *COLUMNS), rows)


if __name__ == "__main__":
    publish(__file__, "uncertainty.md", text())
