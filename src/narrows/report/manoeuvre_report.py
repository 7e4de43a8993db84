"""Turning circles and zigzags: tables and tracks."""

import numpy as np
from matplotlib.figure import Figure

from narrows.manoeuvres.manoeuvring_trials import Trials
from narrows.report.style import BLUE, DASHES, GREEN, ORANGE, PURPLE, panels
from narrows.report.terminal import console_of, print_notes, table_of

COLOURS = (BLUE, ORANGE, GREEN, PURPLE)


def print_manoeuvres(trials: Trials) -> None:
    console, results = console_of(), trials.to_dict()
    circles = (
        (order, *(f"{value:.2f}" for value in measures.values())) for order, measures in results["turning"].items()
    )
    zigzags = (
        (order, ", ".join(f"{angle:.1f}" for angle in measures["overshoots_deg"]))
        for order, measures in results["zigzags"].items()
    )
    console.print(f"{trials.model.configuration.ship.name}, approach at {trials.speed:.4g} m/s, in open water")
    heads = ("rudder [deg]", "advance/L", "transfer/L", "tactical diameter/L", "speed/approach")
    console.print(table_of(heads, circles))
    console.print(table_of(("zigzag [deg]", "overshoots [deg]"), zigzags))
    print_notes(console, trials.notes)


def manoeuvres_figure(trials: Trials) -> Figure:
    figure, axes = panels(1, 2, 3.6)
    circles, zigzags = axes[0]
    length = trials.model.configuration.ship.length
    for (order, (voyage, _)), colour, dash in zip(trials.turning.items(), COLOURS, DASHES, strict=False):
        circles.plot(voyage.y / length, voyage.x / length, color=colour, ls=dash, label=f"rudder {order} deg")
    circles.set_aspect("equal")
    circles.set_xlabel("transfer [ship lengths], starboard positive")
    circles.set_ylabel("advance [ship lengths]")
    shown = [(order, voyage) for order, (voyage, _) in trials.zigzags.items() if order.startswith("+")]
    for (order, voyage), colour in zip(shown, COLOURS, strict=False):
        time = voyage.t * trials.speed / length
        zigzags.plot(time, np.degrees(voyage.psi), color=colour, label=f"heading, zigzag {order}")
        zigzags.plot(time, np.degrees(voyage.rudder), color=colour, ls=":", label="its rudder")
    zigzags.set_xlabel("time [ship lengths at the approach speed]")
    zigzags.set_ylabel("heading, rudder [deg], starboard positive")
    for panel in (circles, zigzags):
        panel.grid(alpha=0.3)
        panel.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, fontsize=7)
    return figure
