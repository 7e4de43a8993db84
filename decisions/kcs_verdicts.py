"""What became of each verdict on the KCS tests at three depths since errors are those of runs: a table of the docs.

python decisions/kcs_verdicts.py [--write]

Before: rows clustered by test, repeats each on their own, inflation at speeds that chain. After: computed here.
"""

from pages import markdown, publish

import narrows as nw

CLEARANCES = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}
BEFORE = {
    ("C0101A01", "b_vdot"): ("618 to 842", "identified"),
    ("C0101A01", "b_rdot"): ("-60.1 to 128", "weakly identified"),
    ("C0101A01", "b_v"): ("62.7 to 140", "weakly identified"),
    ("C0101A01", "b_r"): ("46.1 to 95.6", "confounded"),
    ("C0101A01", "b_vv"): ("0 to 726", "at its bound"),
    ("C0101A01", "b_rr"): ("12.3 to 738", "weakly identified"),
    ("C0101A01", "b_bank"): ("0.179 to 0.291", "confounded"),
    ("C0101A01", "c_vdot"): ("-60.1 to 128", "weakly identified"),
    ("C0101A01", "c_rdot"): ("762 to 809", "identified"),
    ("C0101A01", "c_v"): ("138 to 362", "weakly identified"),
    ("C0101A01", "c_r"): ("72.7 to 276", "confounded"),
    ("C0101A01", "c_vv"): ("-5.45e+03 to -441", "weakly identified"),
    ("C0101A01", "c_rr"): ("276 to 2.2e+03", "weakly identified"),
    ("C0101A01", "c_bank"): ("-0.0871 to 0.0247", "confounded"),
    ("C0101A02", "b_vdot"): ("714 to 1.06e+03", "identified"),
    ("C0101A02", "b_rdot"): ("-64.2 to 219", "weakly identified"),
    ("C0101A02", "b_v"): ("64.5 to 263", "weakly identified"),
    ("C0101A02", "b_r"): ("32.9 to 111", "confounded"),
    ("C0101A02", "b_vv"): ("0 to 1.98e+03", "weakly identified"),
    ("C0101A02", "b_rr"): ("-17 to 1.47e+03", "weakly identified"),
    ("C0101A02", "b_bank"): ("0.114 to 0.282", "confounded"),
    ("C0101A02", "c_vdot"): ("-64.2 to 219", "weakly identified"),
    ("C0101A02", "c_rdot"): ("818 to 950", "identified"),
    ("C0101A02", "c_v"): ("237 to 543", "weakly identified"),
    ("C0101A02", "c_r"): ("67.3 to 401", "confounded"),
    ("C0101A02", "c_vv"): ("-8.1e+03 to -1.11e+03", "weakly identified"),
    ("C0101A02", "c_rr"): ("633 to 4.8e+03", "weakly identified"),
    ("C0101A02", "c_bank"): ("-0.106 to 0.0822", "confounded"),
    ("C0101A03", "b_vdot"): ("835 to 1.41e+03", "identified"),
    ("C0101A03", "b_rdot"): ("-305 to 662", "weakly identified"),
    ("C0101A03", "b_v"): ("225 to 1.04e+03", "weakly identified"),
    ("C0101A03", "b_r"): ("17.6 to 188", "confounded"),
    ("C0101A03", "b_vv"): ("0 to 3.99e+03", "at its bound"),
    ("C0101A03", "b_rr"): ("-2.03e+03 to 1.82e+03", "weakly identified"),
    ("C0101A03", "b_bank"): ("-0.0341 to 0.274", "confounded"),
    ("C0101A03", "c_vdot"): ("-305 to 662", "weakly identified"),
    ("C0101A03", "c_rdot"): ("1.07e+03 to 1.33e+03", "identified"),
    ("C0101A03", "c_v"): ("533 to 1.01e+03", "weakly identified"),
    ("C0101A03", "c_r"): ("58.2 to 540", "confounded"),
    ("C0101A03", "c_vv"): ("-1.4e+04 to -2.83e+03", "weakly identified"),
    ("C0101A03", "c_rr"): ("2.57e+03 to 1.19e+04", "weakly identified"),
    ("C0101A03", "c_bank"): ("-0.194 to 0.0882", "confounded"),
}
"""Interval and verdict of each coefficient as the first edition of the package had them."""
MOST = 2
"""Reasons that are given."""


def text() -> str:
    """Fit each depth, and write a row for each coefficient of sway and yaw."""
    rows = []
    for label, tests in nw.measured_tests("kcs").by_condition().items():
        fit = nw.identify(tests)
        for term in (*fit.terms.sway, *fit.terms.yaw):
            (low, high), verdict = fit.intervals[term.name], fit.verdicts[term.name]
            before = BEFORE[label, term.name]
            now = (f"{low:.3g} to {high:.3g}", verdict.status)
            rows.append((CLEARANCES[label], term.name, *before, *now, "; ".join(verdict.reasons[:MOST])))
    return markdown(("clearance", "coefficient", "before", "verdict", "now", "verdict", "why"), rows)


if __name__ == "__main__":
    publish(__file__, "uncertainty.md", text())
