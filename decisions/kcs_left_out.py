"""How well a fit predicts measured motions that it has not seen: a table of the docs.

    python decisions/kcs_left_out.py [--write]

Each distinct motion of the bundled KCS tests is left out in turn, its repeats with it, and predicted by the others.
"""

from pages import markdown, publish

import narrows as nw

CLEARANCES = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}
HEADER = ("clearance", "terms", "Y", "N")


def row(label: str, terms: str) -> tuple[str, ...]:
    """One condition under one table of terms: share inside the interval, its median half width, and over the force."""
    fit = nw.identify(nw.measured_tests("kcs").by_condition()[label], terms)
    units = {"Y": "N", "N": "N m"}
    cells = {
        one.force: f"{100 * one.held:.0f} %, {one.half:.2g} {units[one.force]} ({100 * one.relative:.0f} %)"
        for one in fit.predictiveness
        if one.force in units
    }
    return CLEARANCES[label], f"`{terms}`", cells["Y"], cells["N"]


def text() -> str:
    """Every depth, under the paper's terms and under those that predict best."""
    return markdown(HEADER, [row(label, terms) for label in CLEARANCES for terms in ("paper", "crossflow")])


if __name__ == "__main__":
    publish(__file__, "uncertainty.md", text())
