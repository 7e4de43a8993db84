"""Pictures of a watched transit: where it went, what was foretold, the rudder it needed, and when it was alerted."""

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from narrows.report.style import BLACK, BLUE, GREY, ORANGE, PURPLE, Margins, panels
from narrows.warning.alerts.alert import Priority
from narrows.warning.monitoring.watched_transit import NEAR, WatchedTransit

SHADES = {
    Priority.CAUTION: "#F0E442", Priority.WARNING: "#E69F00", Priority.ALARM: ORANGE, Priority.EMERGENCY_ALARM: PURPLE,
}  # fmt: skip
"""Behind the curves, where an alert of that kind held."""


def transit_figure(transit: WatchedTransit) -> Figure:
    """Draw clearance, chances, times and rudder over time, shaded where it was alerted (ours).

    Parameters
    ----------
    transit : WatchedTransit
        What to draw.
    """
    figure, axes = panels(4, 1, 6.6, Margins(bottom=0.85, top=0.2, down=0.18), sharex=True)
    told, t = transit.columns, transit.columns["t"]
    curves: tuple[tuple[str, tuple[tuple[np.ndarray, str, str], ...]], ...] = (
        ("water beside\nthe hull [m]", ((told["clearance"], BLUE, "clearance"),)),
        ("chance of\ncontact [%]", (
            (100 * told["pilot_now"], BLUE, "a pilot takes over now"), (100 * told["soon"], GREY, "in 60 s, as it is"),
        )),
        ("time [s]", (
            (told["contact"], ORANGE, "to contact, as it is"), (told["last_chance"], BLACK, "to the last chance"),
        )),
        ("rudder [deg]", (
            (np.degrees(told["rudder"]), GREY, "rudder"), (np.degrees(told["rudder_needed"]), BLUE, "needed to stay"),
        )),
    )  # fmt: skip
    for panel, (label, lines) in zip(axes[:, 0], curves, strict=True):
        _shade(panel, t, told["level"])
        for values, colour, words in lines:
            panel.plot(t, np.where(np.isfinite(values), values, np.nan), color=colour, lw=1.2, label=words)
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
        panel.legend(frameon=False, fontsize=7, loc="best")
    axes[0, 0].axhline(NEAR, color=BLACK, lw=0.7, ls="--")
    axes[-1, 0].set_xlabel("time since the watch began [s]")
    patches = [Patch(facecolor=colour, alpha=0.35, label=priority.words) for priority, colour in SHADES.items()]
    figure.legend(handles=patches, loc="lower center", ncols=4, frameon=False, fontsize=7)
    return figure


def _shade(panel: Axes, t: np.ndarray, level: np.ndarray) -> None:
    """The times over which a level held."""
    edges = [0, *(np.flatnonzero(np.diff(level)) + 1).tolist(), len(t)]
    for first, last in pairwise(edges):
        if first < len(t) and (colour := SHADES.get(Priority(int(level[first])))):
            panel.axvspan(t[first], t[min(last, len(t) - 1)], color=colour, alpha=0.35, lw=0)
