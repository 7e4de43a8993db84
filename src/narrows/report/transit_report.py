"""A monitored transit as one self-contained page, for training and for investigation."""

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from narrows.report.colours import BLACK, BLUE, GREY, ORANGE, PURPLE
from narrows.report.fit_page import figure, write_page
from narrows.report.style import legend_below, panels
from narrows.ship.particulars import half_swept
from narrows.warning.alerts.alert import Priority
from narrows.warning.monitoring.watched_transit import WatchedTransit
from narrows.warning.settings import NEAR_MISS


def write_transit_report(transit: WatchedTransit, path: str | Path) -> None:
    margin = transit.to_dict()["least_rudder_margin"]
    track = (
        "Plan view along the unrolled centreline, starboard down: banks at keel depth, the track of midship, and the "
        "area that the hull swept, coloured by alert level."
    )
    history = (
        "Clearance of the hull, probabilities of contact, times to contact and to the last chance to act, and the "
        "rudder with the angle that keeps the ship on its offset; shading shows alerts."
    )
    write_page(
        path, "transit.html.j2", title=": a transit of ".join(transit.names), transit=transit,
        margin=None if margin is None or not math.isfinite(margin) else f"{math.degrees(margin):.0f}",
        track=figure(transit_track_figure(transit), track) if transit.located.any() else None,
        figure=figure(transit_figure(transit), history),
    )  # fmt: skip


# Background of the curves during an alert, by level.
SHADES = {
    Priority.CAUTION: "#F0E442", Priority.WARNING: "#E69F00", Priority.ALARM: ORANGE, Priority.EMERGENCY_ALARM: PURPLE,
}  # fmt: skip
BANK_POINTS = 400  # Points of each drawn bank


# Panels of a transit: label, and curves by column with factor, colour and words.
CURVES = (
    ("water beside\nthe hull [m]", (("clearance", 1.0, BLUE, "clearance"),)),
    ("chance [%]", (
        ("nobody", 100.0, BLUE, "contact: nobody acts in time"), ("unattended", 100.0, GREY, "nobody at the helm"),
    )),
    ("time [s]", (
        ("contact", 1.0, ORANGE, "to contact, as it is"), ("last_chance", 1.0, BLACK, "to the last chance"),
    )),
    ("rudder [deg]", (
        ("rudder", math.degrees(1), GREY, "rudder"), ("rudder_needed", math.degrees(1), BLUE, "needed to stay"),
    )),
)  # fmt: skip


def transit_figure(transit: WatchedTransit) -> Figure:
    figure, axes = panels(4, 1, 6.6, sharex=True)
    columns, t = transit.columns, transit.columns["t"]
    for panel, (label, curves) in zip(axes[:, 0], CURVES, strict=True):
        for part, level in _levels(columns["level"]):
            if shade := SHADES.get(level):
                panel.axvspan(t[part][0], t[part][-1], color=shade, alpha=0.35, lw=0)
        for name, factor, colour, words in curves:
            values = np.where(np.isfinite(columns[name]), factor * columns[name], np.nan)
            panel.plot(t, values, color=colour, lw=1.2, label=words)
        panel.set_ylabel(label)
        panel.legend(frameon=False, fontsize=7, loc="best")
    axes[0, 0].axhline(NEAR_MISS, color=BLACK, lw=0.7, ls="--")
    axes[-1, 0].set_xlabel("time since the watch began [s]")
    legend_below(figure, _patches(0.35), 4)
    return figure


def transit_track_figure(transit: WatchedTransit) -> Figure:
    figure, ((panel,),) = panels(1, 1, 2.6)
    columns, ship = transit.columns, transit.ship
    x, y, reach = columns["x"], columns["y"], half_swept(ship, columns["psi"])
    for part, level in _levels(columns["level"]):
        colour = SHADES.get(level, GREY)
        panel.fill_between(x[part], (y - reach)[part], (y + reach)[part], color=colour, alpha=0.5, lw=0)
    panel.plot(x, y, color=BLACK, lw=1.0, label="midship")
    first, last = np.nanmin(x) - ship.length, np.nanmax(x) + ship.length
    along = np.linspace(max(float(first), 0.0), min(float(last), transit.waterway.line.length), BANK_POINTS)
    section = transit.waterway.section(along, ship.draft)
    for sign, words in ((-1, "banks"), (1, None)):
        panel.plot(along, section.middle + sign * section.width / 2, color=BLUE, lw=1.8, label=words)
    panel.set(xlim=(first, last), xlabel="along the waterway [m]", ylabel="y, to starboard [m]")
    panel.invert_yaxis()
    panel.set_title("from above, starboard down; not to scale")
    swept = Patch(facecolor=GREY, alpha=0.5, label="hull, no alert")
    lines = panel.get_legend_handles_labels()[0]
    legend_below(figure, [*lines, swept, *_patches(0.5)], 4)
    return figure


def _patches(alpha: float) -> list[Patch]:
    return [Patch(facecolor=colour, alpha=alpha, label=priority.words) for priority, colour in SHADES.items()]


def _levels(level: np.ndarray) -> Iterator[tuple[slice, Priority]]:
    """Yield the samples of each alert level, with the first sample after it."""
    edges = [0, *(np.flatnonzero(np.diff(level)) + 1).tolist(), len(level)]
    for first, last in pairwise(edges):
        if first < last:
            yield slice(first, last + 1), Priority(int(level[first]))
