"""What tells the bank from the yaw rate: sets of synthetic tests, their inflation, intervals, verdicts and power.

    python design/separation.py [TWINS]

Power is the share of twins, with b_bank a tenth of the published one, whose interval does not hold 0.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from rich.console import Console
from rich.table import Table

import narrows as nw

PUBLISHED = nw.published("mikkelsen2025_dtc")
FAINT = PUBLISHED.with_coefficients(b_bank=0.107, c_bank=0.013)
YAW = nw.HarmonicRun("yaw 0.9 m 25 s", "yaw", 0.9, 25.0)
SMALLER = nw.HarmonicRun("yaw 0.5 m 25 s", "yaw", 0.5, 25.0)
SLOWER = tuple(nw.HarmonicRun(f"yaw {a} m 25 s 0.7 m/s", "yaw", a, 25.0, 0.7) for a in (0.9, 0.5))
SETS = {
    "harmonic yaw, one run": (YAW,),
    "harmonic yaw, two amplitudes": (YAW, SMALLER),
    "harmonic yaw, two amplitudes at two speeds": (YAW, SMALLER, *SLOWER),
    "and another period at one speed": (YAW, SMALLER, nw.HarmonicRun("yaw 0.3 m 14 s", "yaw", 0.3, 14.0)),
    "and harmonic sway": (YAW, SMALLER, nw.HarmonicRun("sway", "sway", 0.9, 25.0)),
    "and straight runs off the centreline": (YAW, SMALLER, *(nw.StraightRun(f"y {y}", y) for y in (0.9, 1.5))),
    "six runs of narrows design": nw.plan_tests(PUBLISHED.setting, 6, tank=nw.Tank(speeds=(0.7, 1.0))).runs,
}


def fitted(name: str, truth: nw.Model, seed: int = 0) -> nw.Fit:
    """Fit one twin."""
    return nw.identify(nw.twin(truth, SETS[name], correlation_time=0.5, rate=10.0, seed=seed))


def seen(name: str, seed: int) -> bool:
    """Whether a faint bank is told from none."""
    low, high = fitted(name, FAINT, seed).intervals["b_bank"]
    return not low <= 0 <= high


def main(twins: int) -> None:
    """Print a row for each set of tests."""
    table = Table(title="b_bank, in truth 1.07, from sets of tests; the published model, correlated noise")
    for header in ("tests", "VIF", "b_bank", "95 % interval", "verdict", "power [%]"):
        table.add_column(header, justify="left" if header in ("tests", "verdict") else "right", no_wrap=True)
    with ProcessPoolExecutor() as pool:
        for name in SETS:
            fit = fitted(name, PUBLISHED)
            (low, high), verdict = fit.intervals["b_bank"], fit.verdicts["b_bank"]
            word = " ".join((verdict.status, *(("with", *verdict.partners) if verdict.partners else ())))
            power = 100 * sum(pool.map(partial(seen, name), range(twins), chunksize=10)) / twins
            figures = (f"{fit.diagnostics()['Y'].vif['b_bank']:.0f}", f"{fit.coefficients['b_bank']:.3f}")
            table.add_row(name, *figures, f"{low:.3f} to {high:.3f}", word, f"{power:.0f}")
    Console(width=140).print(table)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 300)
