"""A monitored transit as one self-contained page, for training and for investigation."""

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from narrows.report.fit_page import figure, write_page
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, PURPLE, legend_below, panels
from narrows.ship.particulars import half_swept
from narrows.warning.alerts.alert import Priority
from narrows.warning.monitoring.watched_transit import WatchedTransit
from narrows.warning.settings import NEAR_MISS

TRACK = (
    "Plan view along the unrolled centreline, starboard down: banks at keel depth, the track of midship, and the area "
    "that the hull swept, coloured by alert level."
)
HISTORY = (
    "Clearance of the hull, probabilities of contact, times to contact and to the last chance to act, "
    "and the rudder with the angle that keeps the ship on its offset; shading shows alerts."
)


def write_transit_report(transit: WatchedTransit, path: str | Path) -> None:
    margin = transit.to_dict()["least_rudder_margin"]
    write_page(
        path,
        "transit.html.j2",
        title=": a transit of ".join(transit.names),
        said=transit.summary().splitlines(),
        margin=None if margin is None or not math.isfinite(margin) else f"{math.degrees(margin):.0f}",
        track=figure(transit_track_figure(transit), TRACK) if transit.located.any() else None,
        figure=figure(transit_figure(transit), HISTORY),
        alerts=[(f"{sent.t:.0f}", sent.alert) for sent in transit.alerts],
        notes=transit.notes,
    )


# Background of the curves during an alert, by level.
SHADES = {
    Priority.CAUTION: "#F0E442", Priority.WARNING: "#E69F00", Priority.ALARM: ORANGE, Priority.EMERGENCY_ALARM: PURPLE,
}  # fmt: skip
BANK_POINTS = 400  # Points of each drawn bank


def transit_figure(transit: WatchedTransit) -> Figure:
    figure, axes = panels(4, 1, 6.6, sharex=True)
    columns, t = transit.columns, transit.columns["t"]
    curves: tuple[tuple[str, tuple[tuple[np.ndarray, str, str], ...]], ...] = (
        ("water beside\nthe hull [m]", ((columns["clearance"], BLUE, "clearance"),)),
        ("chance [%]", (
            (100 * columns["nobody"], BLUE, "contact: nobody acts in time"),
            (100 * columns["unattended"], GREY, "nobody at the helm"),
        )),
        ("time [s]", (
            (columns["contact"], ORANGE, "to contact, as it is"), (columns["last_chance"], BLACK, "to the last chance"),
        )),
        ("rudder [deg]", (
            (np.degrees(columns["rudder"]), GREY, "rudder"),
            (np.degrees(columns["rudder_needed"]), BLUE, "needed to stay"),
        )),
    )  # fmt: skip
    for panel, (label, lines) in zip(axes[:, 0], curves, strict=True):
        for part, level in _levels(columns["level"]):
            if shade := SHADES.get(level):
                panel.axvspan(t[part][0], t[part][-1], color=shade, alpha=0.35, lw=0)
        for values, colour, words in lines:
            panel.plot(t, np.where(np.isfinite(values), values, np.nan), color=colour, lw=1.2, label=words)
        panel.set_ylabel(label)
        panel.legend(frameon=False, fontsize=7, loc="best")
    axes[0, 0].axhline(NEAR_MISS, color=BLACK, lw=0.7, ls="--")
    axes[-1, 0].set_xlabel("time since the watch began [s]")
    legend_below(figure, _patches(0.35), 4)
    return figure


def transit_track_figure(transit: WatchedTransit) -> Figure:
    figure, axes = panels(1, 1, 2.6)
    panel: Axes = axes[0, 0]
    columns, ship = transit.columns, transit.ship
    x, y, reach = columns["x"], columns["y"], half_swept(ship, columns["psi"])
    for part, level in _levels(columns["level"]):
        colour = SHADES.get(level, GREY)
        panel.fill_between(x[part], (y - reach)[part], (y + reach)[part], color=colour, alpha=0.5, lw=0)
    panel.plot(x, y, color=BLACK, lw=1.0, label="midship")
    first, last = np.nanmin(x) - ship.length, np.nanmax(x) + ship.length
    along = np.linspace(max(float(first), 0.0), min(float(last), transit.waterway.line.length), BANK_POINTS)
    section = transit.waterway.keel_section(along, ship.draft)
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
