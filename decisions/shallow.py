"""Kijima's corrections on the KCS: one depth taken to the others, beside what was measured there.

python decisions/shallow.py [--write]
"""

from pages import markdown, publish

import narrows as nw

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
        moved = nw.at_depth(fits[first].model, depth or 0.0)
        for name in NAMES:
            (low, high), told = fits[label].intervals[name], moved.model.coefficients[name]
            measured = fits[label].coefficients[name]
            figures = (f"{fits[first].coefficients[name]:.4g}", f"{moved.factors[name]:.2f}", f"{told:.4g}")
            error = f"{100 * (told / measured - 1):+.0f} %"
            rows.append(
                (
                    f"{LABELS[first]} to {LABELS[label]}",
                    name,
                    *figures,
                    f"{measured:.4g} ({low:.4g} to {high:.4g})",
                    error,
                )
            )
    header = ("clearance", "coefficient", "there", "factor", "corrected", "measured (95 %)", "error")
    return markdown(header, rows)


if __name__ == "__main__":
    publish(__file__, "squat.md", text())
