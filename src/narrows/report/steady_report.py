"""What steady legs taught, as one self-contained page."""

from pathlib import Path

from narrows.files import write_whole
from narrows.logbook import EnvelopeChange, SteadyFit
from narrows.logbook.standing import ON_TWINS
from narrows.logbook.steady_legs.steady_fit import SHARED
from narrows.report.fit_page import figure, render
from narrows.report.learned_table import learned_rows
from narrows.report.steady_figures import steady_figure
from narrows.report.steady_table import CHANGE_HEADS, change_rows


def write_steady_report(fit: SteadyFit, change: EnvelopeChange, path: str | Path) -> None:
    """Write one HTML file with what steady legs taught and what that changes."""
    caption = (
        "Rudder that holds the ship by offset, before the legs and after; the bank's coefficients with 95 % intervals."
    )
    found = fit.to_dict()
    page = render(
        "steady.html.j2",
        title=f"{fit.prior.configuration.ship.name or 'A ship'}: what {len(fit.readings)} steady legs taught",
        standing=ON_TWINS,
        said=[line for line in fit.summary().splitlines() if line != ON_TWINS],
        learned=learned_rows(fit.coefficients),
        figure=figure(steady_figure(fit), caption),
        change_heads=CHANGE_HEADS,
        change=change_rows(change),
        changed=[*change.summary().splitlines(), change.notes[0]],
        direction=fit.readings.directions[0],
        legs=found["legs"],
        shared=[row | {"words": SHARED[row["name"]][0]} for row in found["shared"]],
        notes=fit.notes,
    )
    write_whole(path, page)
