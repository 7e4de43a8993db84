"""Hull terms side by side on the KCS at three depths: what they gain, and what becomes unstable.

python decisions/term_tables.py [--write]
"""

from pages import Rows, markdown, part, publish, records

import narrows as nw
from narrows.model.tables import BARE

CLEARANCES = {"C0101A01": "100 %", "C0101A02": "50 %", "C0101A03": "20 %"}
ERRORS = tuple(f"{force}, {where}" for force in ("Y", "N") for where in ("tests out", "speeds out"))
HEADER = ("clearance", "terms", *ERRORS, "b_bank, 95 %", "c_bank, 95 %")


def row(clearance: str, name: str, fit: nw.Fit) -> tuple[str, ...]:
    """One table of terms at one depth."""
    errors = [
        f"{score.rmse:.3g}" for force in ("Y", "N") for score in (fit.left_out[force], fit.left_out_speeds[force])
    ]
    ends = (" to ".join(f"{end:.2f}" for end in fit.intervals[bank]) for bank in ("b_bank", "c_bank"))
    return (clearance, f"`{name}`", *errors, *ends)


def text() -> str:
    """Fit every table of terms at every depth."""
    tests = nw.measured_tests("kcs").by_condition()
    rows = [
        row(clearance, name, fit)
        for label, clearance in CLEARANCES.items()
        for name, fit in nw.compare(tests[label], list(BARE)).fits.items()
    ]
    return markdown(HEADER, rows)


def shown(rows: Rows) -> str:
    """The errors of tables without a mixed hull, and no intervals of the bank."""
    return part([row for row in records(rows, HEADER[0]) if "mixed" not in row[HEADER[1]]], *HEADER[:-2])


if __name__ == "__main__":
    publish(__file__, "uncertainty.md", text(), shown)
