"""Turning circles and zigzags: tables and tracks."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.report.printed_tables import console_of, print_notes, table_of
from narrows.report.style import BLUE, DASHES, GREEN, ORANGE, PURPLE, notes_below, panels
from narrows.simulation.manoeuvring_trials import Trials, Turning, ZigzagTest

COLOURS = (BLUE, ORANGE, GREEN, PURPLE)
LEGEND: dict[str, Any] = {
    "frameon": False, "loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2, "fontsize": 7,
}  # fmt: skip


CIRCLE_COLUMNS = {
    "rudder [deg]": "{order}", "advance/L": "{advance_over_length:.2f}", "transfer/L": "{transfer_over_length:.2f}",
    "tactical diameter/L": "{tactical_diameter_over_length:.2f}", "speed/approach": "{speed_over_approach:.2f}",
}  # fmt: skip
ZIGZAG_COLUMNS = {"zigzag [deg]": "{order}", "overshoots [deg]": "{overshoots_deg:.1f}"}


def print_manoeuvres(trials: Trials) -> None:
    console, results = console_of(), trials.to_dict()
    console.print(f"{trials.model.configuration.ship.name}, approach at {trials.speed:.4g} m/s, in open water")
    for columns, measured in ((CIRCLE_COLUMNS, results["turning"]), (ZIGZAG_COLUMNS, results["zigzags"])):
        console.print(table_of(columns, [{"order": order, **measures} for order, measures in measured.items()]))
    print_notes(console, trials.notes)


def manoeuvres_figure(trials: Trials) -> Figure:
    figure, axes = panels(1, 2, 3.6)
    _circles_on(axes[0, 0], {f"rudder {order} deg": circle for order, circle in trials.turning.items()})
    _zigzags_on(axes[0, 1], {order: test for order, test in trials.zigzags.items() if order.startswith("+")})
    return figure


def turning_figure(circle: Turning) -> Figure:
    figure, axes = panels(1, 1, 4.2)
    _circles_on(axes[0, 0], {circle.summary().partition(":")[0].lower(): circle})
    notes_below(figure, circle.notes)
    return figure


def zigzag_figure(test: ZigzagTest) -> Figure:
    figure, axes = panels(1, 1, 3.2)
    _zigzags_on(axes[0, 0], {"": test})
    notes_below(figure, test.notes)
    return figure


def _circles_on(axes: Axes, circles: Mapping[str, Turning]) -> None:
    for (label, circle), colour, dash in zip(circles.items(), COLOURS, DASHES, strict=False):
        voyage, length = circle.voyage, circle.voyage.configuration.ship.length
        axes.plot(voyage.y / length, voyage.x / length, color=colour, ls=dash, label=label)
    axes.set_aspect("equal")
    axes.set_xlabel("transfer [ship lengths], starboard positive")
    axes.set_ylabel("advance [ship lengths]")
    axes.legend(**LEGEND)


def _zigzags_on(axes: Axes, tests: Mapping[str, ZigzagTest]) -> None:
    for (order, test), colour in zip(tests.items(), COLOURS, strict=False):
        voyage = test.voyage
        time = voyage.t * voyage.u[0] / voyage.configuration.ship.length
        axes.plot(time, np.degrees(voyage.psi), color=colour, label=f"heading, zigzag {order}" if order else "heading")
        axes.plot(time, np.degrees(voyage.rudder), color=colour, ls=":", label="its rudder" if order else "rudder")
    axes.set_xlabel("time [ship lengths at the approach speed]")
    axes.set_ylabel("heading, rudder [deg], starboard positive")
    axes.legend(**LEGEND)
