"""How well a fit predicts measured motions that it has not seen: a table of the docs.

    python decisions/kcs_left_out.py [--write]

Each distinct motion of the bundled KCS tests is left out in turn, its repeats with it, and predicted by the others.
"""

from pages import markdown, publish

import narrows as nw

CLEARANCES = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}
HEADER = ("clearance", "terms", "force", "motions", "inside the 95 % interval", "half width, median", "of the force")


def rows(label: str, terms: str) -> list[tuple[str, ...]]:
    """One condition under one table of terms: a row a force."""
    fit = nw.identify(nw.measured_tests("kcs").by_condition()[label], terms)
    return [
        (
            CLEARANCES[label], f"`{terms}`", one.force, str(one.motions), f"{one.held:.0%}",
            f"{one.half:.2g} {'N m' if one.force == 'N' else 'N'}", f"{one.relative:.0%}",
        )
        for one in fit.predictiveness
        if one.force != "X"
    ]  # fmt: skip


def text() -> str:
    """Every depth, under the paper's terms and under those that predict best."""
    return markdown(
        HEADER, [row for label in CLEARANCES for terms in ("paper", "crossflow") for row in rows(label, terms)]
    )


if __name__ == "__main__":
    publish(__file__, "uncertainty.md", text())
