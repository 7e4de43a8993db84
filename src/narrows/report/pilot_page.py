"""One page for the crew of a leg: where, how fast, what to expect, what to write, when to break off."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from narrows.errors import InputError
from narrows.files import write_whole
from narrows.logbook import InformationForecast, SteadyPlan
from narrows.logbook.learned_coefficient import ON_TWINS, PRIOR, LearnedCoefficient
from narrows.quantities.names import KNOT
from narrows.report.fit_page import figure as captioned
from narrows.report.fit_page import render
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, Margins, panels
from narrows.report.terminal import print_result, table_of
from narrows.results.base_results import interval, with_error

# Distance off its line at which a leg is broken off [beams].
STRAYED = 0.25


def write_pilot_page(plan: SteadyPlan, path: str | Path) -> None:
    ship = plan.model.configuration.ship
    run = max(leg.speed for leg in plan.legs) * (plan.settling + plan.conditions.leg_time)
    legs = [
        (f"{abs(leg.offset):g} m {leg.side}", f"{leg.speed / KNOT:g} kn", _turned(leg.rudder), _turned(leg.drift, 1))
        for leg in plan.legs
    ]
    page = render(
        "pilot.html.j2", title="Holding the ship to either side: what the bank does", plan=plan, legs=legs,
        picture_of_legs=captioned(legs_figure(plan), "The legs from above, the ship going up the page."),
        miles=run / 1852, minutes=np.ceil(plan.settling / 60), most_rudder=np.degrees(plan.most_rudder),
        strayed=STRAYED * ship.beam, foot=[plan.summary().partition("\n")[0], ON_TWINS],
    )  # fmt: skip
    write_whole(path, page)


def _turned(angles: tuple[float, ...], digits: int = 0) -> str:
    """A range of angles by side: P to port, S to starboard."""
    low, _, high = np.degrees(angles)
    return " to ".join(f"{'P' if angle < 0 else 'S'} {abs(angle):.{digits}f}°" for angle in (low, high))


def legs_figure(plan: SteadyPlan) -> Figure:
    """Draw the canal from above, with ahead up: each leg's hull at its offset."""
    if not plan.legs:
        raise InputError("a plan without legs has no picture; its summary gives the reason")
    ship, half = plan.model.configuration.ship, plan.model.configuration.canal.width / 2
    figure, panes = panels(1, 1, 2.6, grid="")
    axes: Axes = panes[0, 0]
    for sign, side in ((-1, "port bank"), (1, "starboard bank")):
        axes.axvline(sign * half, color=BLACK, lw=4)
        ends = "right" if sign > 0 else "left"
        axes.text(sign * 0.97 * half, 0.06, side, rotation=90, va="bottom", ha=ends, fontsize=8)
    axes.axvline(0, color=GREY, lw=0.8, ls="-.")
    places = sorted({leg.offset for leg in plan.legs})
    rows = _rows(places, ship.beam)
    for offset, row in zip(places, rows, strict=True):
        colour = BLUE if offset > 0 else ORANGE
        hull = [(offset + across * ship.beam, row + 0.05 + 0.9 * along) for across, along in HULL]
        axes.add_patch(Polygon(hull, closed=True, facecolor=colour, edgecolor=BLACK, lw=0.8, alpha=0.85))
        numbers = ", ".join(str(i) for i, leg in enumerate(plan.legs, start=1) if leg.offset == offset)
        look: dict[str, Any] = {"ha": "center", "va": "center", "color": "white", "weight": "bold", "fontsize": 8}
        axes.text(offset, row + 0.5, numbers, **look)
    axes.set(xlim=(-1.05 * half, 1.05 * half), ylim=(-0.1, max(rows) + 1.25), yticks=[])
    axes.set_xticks([-half, *places, 0, half], [f"{x:+.3g}" if x else "0" for x in (-half, *places, 0, half)])
    axes.spines["left"].set_visible(False)
    axes.set_xlabel("metres from the middle, the ship going up the page: port left, starboard right")
    return figure


# Outline of a hull: beams to starboard, and rows ahead.
HULL = ((-0.5, 0.0), (0.5, 0.0), (0.5, 0.75), (0.0, 1.0), (-0.5, 0.75))


def _rows(places: list[float], beam: float) -> list[float]:
    """Row in which each hull is drawn, so that neighbours do not overlap."""
    rows: list[float] = []
    for i, place in enumerate(places):
        taken = {row for other, row in zip(places[:i], rows, strict=True) if abs(other - place) < 1.1 * beam}
        rows.append(next(float(row) for row in range(len(places)) if row not in taken))
    return rows


def print_information(information: InformationForecast) -> None:
    columns = {"transits": "{transits}"} | {f"std {name}": f"{{std {name}:.2g}}" for name in information.std}
    print_result(information, table_of(columns, information.rows()) if information.std else None)


def information_figure(information: InformationForecast) -> Figure:
    targets = information.targets
    figure, axes = panels(1, len(targets), 3.6, Margins(bottom=1.0, top=0.25, across=0.75))
    for panel, name in zip(axes[0], targets, strict=True):
        panel.axhline(information.prior_std[name], color=GREY, ls="--", label="now")
        if name in information.std:
            panel.plot(information.transits, information.std[name], color=BLUE, marker="o", ms=3, label="after them")
        panel.set(xscale="log", xlabel="transits", ylabel=f"standard error of {name}")
        panel.set_xticks(information.transits, [str(count) for count in information.transits])
        panel.minorticks_off()
        panel.set_ylim(bottom=0)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=2, frameon=False, fontsize=7)
    return figure


# Coefficients before and after a record, in a table.
LEARNED = {
    "": "{name}", "before": "{before}", "after": "{after}", "95 % interval": "{interval}", "unit": "{unit}",
}  # fmt: skip


def learned_rows(
    coefficients: Mapping[str, LearnedCoefficient], truth: Mapping[str, float] | None = None
) -> list[dict[str, Any]]:
    learned = sorted((c for c in coefficients.values() if c.word != PRIOR), key=lambda c: c.left)
    return [
        {
            "name": c.name, "before": with_error(c.prior, c.prior_std), "after": with_error(c.value, c.std),
            "interval": interval(c.interval, c.std), "unit": c.unit, "verdict": c.verdict,
            "truth": truth[c.name] if truth else None,
        }
        for c in learned
    ]  # fmt: skip
