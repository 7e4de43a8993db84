"""Kijima's corrections on the KCS: one depth taken to the others, beside what was measured there.

python decisions/shallow.py [--write]
"""

from pages import markdown, publish

import narrows as nw
from narrows.base.results import interval, readable

LABELS = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}
NAMES = ("b_uv", "c_uv", "c_ur")


def text() -> str:
    """Take the model of the deepest tests to the other depths."""
    tests = nw.measured_tests("kcs").by_condition()
    fits = {label: nw.identify(tests[label], nw.CROSSFLOW) for label in LABELS}
    first, *others = LABELS
    rows = []
    for label in others:
        depth = fits[label].model.configuration.canal.depth
        corrected = nw.at_depth(fits[first].model, depth or 0.0)
        for name in NAMES:
            (low, high), there = fits[label].intervals[name], fits[first].coefficients[name]
            measured, predicted = fits[label].coefficients[name], corrected.model.coefficients[name]
            half = (high - low) / 2
            before, after, known = (readable(value, half) for value in (there, predicted, measured))
            error, factor = f"{100 * (predicted / measured - 1):+.0f} %", f"{corrected.factors[name]:.2f}"
            ends = f"{known} ({interval((low, high), half)})"
            rows.append((f"{LABELS[first]} to {LABELS[label]}", name, before, factor, after, ends, error))
    header = ("clearance", "coefficient", "at 100 %", "factor", "corrected", "measured (95 %)", "error")
    return markdown(header, rows)


if __name__ == "__main__":
    publish(__file__, "squat.md", text())
