"""What tells the bank from the yaw rate: sets of synthetic tests, their inflation, intervals, verdicts and power.

    python decisions/separation.py [--write]

Power is the probability that the interval of a bank a tenth as strong excludes 0, given its half width in one twin.
"""

from statistics import NormalDist

from pages import markdown, publish

import narrows as nw
from narrows.base.results import interval

PUBLISHED = nw.published("mikkelsen2025_dtc")
FAINT = PUBLISHED.with_coefficients(b_bank=0.107, c_bank=0.013)
YAW = nw.HarmonicRun("yaw 0.9 m 25 s", "yaw", 0.9, 25.0)
SMALLER = nw.HarmonicRun("yaw 0.5 m 25 s", "yaw", 0.5, 25.0)
SLOWER = tuple(nw.HarmonicRun(f"yaw {a} m 25 s 0.7 m/s", "yaw", a, 25.0, 0.7) for a in (0.9, 0.5))
SETS = {
    "harmonic yaw, one run": (YAW,),
    "harmonic yaw, two amplitudes": (YAW, SMALLER),
    "harmonic yaw, two amplitudes at two speeds": (YAW, SMALLER, *SLOWER),
    "two amplitudes, and another period at one speed": (
        YAW,
        SMALLER,
        nw.HarmonicRun("yaw 0.3 m 14 s", "yaw", 0.3, 14.0),
    ),
    "two amplitudes, and harmonic sway": (YAW, SMALLER, nw.HarmonicRun("sway", "sway", 0.9, 25.0)),
    "two amplitudes, and straight runs off the centreline": (
        YAW,
        SMALLER,
        *(nw.StraightRun(f"y {y}", y) for y in (0.9, 1.5)),
    ),
    "six runs of narrows plan": nw.plan_tests(PUBLISHED.configuration, 6, tank=nw.Tank(speeds=(0.7, 1.0))).runs,
}


def fitted(name: str, truth: nw.Model) -> nw.Fit:
    """Fit one twin."""
    return nw.identify(nw.twin(truth, SETS[name], correlation_time=0.5, rate=10.0))


def power(name: str) -> float:
    """Probability that an estimate about the faint bank lies more than its half width from 0."""
    low, high = fitted(name, FAINT).intervals["b_bank"]
    half, normal = (high - low) / 2, NormalDist()
    strength = FAINT["b_bank"] / half * 1.96
    return normal.cdf(strength - 1.96) + normal.cdf(-strength - 1.96)


def text(sets: tuple[str, ...] = tuple(SETS)) -> str:
    """Write a row for each set of tests."""
    rows = []
    for name in sets:
        fit = fitted(name, PUBLISHED)
        (low, high), verdict = fit.intervals["b_bank"], fit.verdicts["b_bank"]
        word = verdict.status + (f" with {' and '.join(verdict.partners)}" if verdict.partners else "")
        inflation = (
            f"{float(f'{vif:.2g}'):g}" if (vif := fit.diagnostics.overall["Y"].vif["b_bank"]) > 10 else f"{vif:.1f}"
        )
        rows.append((name, inflation, interval((low, high), (high - low) / 2), word, f"{100 * power(name):.0f} %"))
    return markdown(("tests", "VIF", "b_bank, 95 %", "verdict", "power"), rows)


if __name__ == "__main__":
    publish(__file__, "uncertainty.md", text())
