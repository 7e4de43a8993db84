"""Axes and signs, drawn: from above, and across the canal."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon, Rectangle

from narrows.report.colours import BLACK, BLUE, GREEN, GREY, ORANGE
from narrows.report.style import panels

LENGTH, BEAM, HEADING, RUDDER = 4.0, 0.62, math.radians(14.0), math.radians(25.0)
MIDSHIP, WALL = (0.0, 0.55), 2.3
WATER, BANK = "#E3EFF7", "#CFC8BD"


def _at(forward: float, starboard: float) -> tuple[float, float]:
    """A point of the ship, in the canal."""
    cosine, sine = math.cos(HEADING), math.sin(HEADING)
    return MIDSHIP[0] + forward * cosine - starboard * sine, MIDSHIP[1] + forward * sine + starboard * cosine


def _arrow(panel: Axes, start: tuple[float, float], end: tuple[float, float], colour: str, both: bool = False) -> None:
    style = "<|-|>" if both else "-|>"
    panel.annotate("", end, start, arrowprops={"arrowstyle": style, "color": colour, "shrinkA": 0, "shrinkB": 0})


def _bare(height: float) -> tuple[Figure, Axes]:
    figure, axes = panels(1, 1, height)
    axes[0, 0].set_axis_off()
    axes[0, 0].set_aspect("equal")
    return figure, axes[0, 0]


def from_above() -> Figure:
    """A ship in a canal, seen from above: x ahead, y to starboard, angles clockwise."""
    figure, panel = _bare(4.2)
    panel.set(xlim=(-4.2, 4.6), ylim=(WALL + 0.35, -WALL - 0.35))
    panel.axhspan(-WALL, WALL, color=WATER, zorder=0)
    for inner, outer, name in ((-WALL, -WALL - 0.35, "port bank"), (WALL, WALL + 0.35, "starboard bank")):
        panel.axhspan(inner, outer, color=BANK, zorder=0)
        panel.text(4.5, (inner + outer) / 2, name, ha="right", va="center")
    panel.axhline(0.0, color=GREY, linestyle="-.", linewidth=0.8)
    panel.text(3.8, -0.08, "centreline", ha="right", color=GREY)
    _hull(panel)
    _places(panel)
    _velocities(panel)
    return figure


def _hull(panel: Axes) -> None:
    half, side = LENGTH / 2, BEAM / 2
    outline = [(-half, -side), (half - 0.6, -side), (half, 0.0), (half - 0.6, side), (-half, side)]
    panel.add_patch(Polygon([_at(*point) for point in outline], facecolor="white", edgecolor=BLACK, zorder=2))
    tip = (-half - 0.5 * math.cos(RUDDER), 0.5 * math.sin(RUDDER))
    panel.plot(*zip(_at(-half, 0.0), _at(*tip), strict=True), color=ORANGE, linewidth=3, zorder=3)
    panel.annotate("rudder, positive: the bow\nturns to starboard", _at(*tip), (-4.1, 1.45), color=ORANGE, va="center",
                   arrowprops={"arrowstyle": "-", "color": ORANGE, "linewidth": 0.6})  # fmt: skip


def _places(panel: Axes) -> None:
    _arrow(panel, (-4.1, 0.0), (-3.2, 0.0), BLACK)
    panel.text(-3.65, -0.1, "$x$", ha="center")
    _arrow(panel, (-4.1, 0.0), (-4.1, 0.9), BLACK)
    panel.text(-4.02, 0.75, "$y$")
    _arrow(panel, (MIDSHIP[0], 0.0), MIDSHIP, BLACK)
    panel.text(-0.12, 0.3, "$y$", ha="right", va="center", zorder=4)
    panel.plot(*zip(MIDSHIP, (3.4, MIDSHIP[1]), strict=True), color=GREY, linewidth=0.8, zorder=4)
    panel.add_patch(Arc(MIDSHIP, 5.6, 5.6, theta1=0.0, theta2=math.degrees(HEADING), color=BLACK, zorder=4))
    panel.text(2.9, 0.95, r"$\psi$", va="center")
    _arrow(panel, (3.9, -WALL), (3.9, WALL), GREY, both=True)
    panel.text(3.98, -1.2, "$W$", color=GREY)
    for sign, name in ((1.0, "s"), (-1.0, "p")):
        reach = (WALL - sign * MIDSHIP[1]) / math.cos(HEADING)
        _arrow(panel, _at(0.0, sign * BEAM / 2), _at(0.0, sign * reach), GREEN, both=True)
        panel.text(*_at(-0.1, sign * 0.65 * reach), f"$y_{name}$", color=GREEN, ha="right", va="center")


def _velocities(panel: Axes) -> None:
    _arrow(panel, _at(LENGTH / 2, 0.0), _at(LENGTH / 2 + 0.95, 0.0), BLUE)
    panel.text(*_at(LENGTH / 2 + 1.0, 0.1), "$u$, $X$", color=BLUE, va="center")
    _arrow(panel, _at(0.5, 0.0), _at(0.5, 0.9), BLUE)
    panel.text(*_at(0.58, 0.85), "$v$, $Y$", color=BLUE, va="center")
    turn = np.radians(np.linspace(-65.0, 5.0, 40)) + HEADING
    x, y = MIDSHIP[0] + 1.25 * np.cos(turn), MIDSHIP[1] + 1.25 * np.sin(turn)
    panel.plot(x, y, color=BLUE, zorder=4)
    _arrow(panel, (x[-3], y[-3]), (x[-1], y[-1]), BLUE)
    panel.text(x[8] + 0.1, y[8] - 0.12, "$r$, $N$", color=BLUE)


def section() -> Figure:
    """The canal across, seen from astern: width, depth, draft, sinkage, clearances."""
    figure, panel = _bare(2.6)
    depth, draft, half, middle = 1.35, 0.75, 0.62, 0.85
    panel.set(xlim=(-3.4, 3.4), ylim=(depth + 0.3, -0.75))
    panel.add_patch(Rectangle((-3.4, 0.0), 6.8, depth + 0.3, color=BANK))
    panel.add_patch(Rectangle((-3.0, 0.0), 6.0, depth, color=WATER))
    panel.plot((-3.0, 3.0), (0.0, 0.0), color=BLUE, linewidth=0.8)
    panel.add_patch(
        Rectangle((middle - half, -0.4), 2 * half, 0.4 + draft, facecolor="white", edgecolor=BLACK, zorder=2)
    )
    panel.axvline(0.0, color=GREY, linestyle="-.", linewidth=0.8)
    _span(panel, (0.0, -0.6), (middle, -0.6), "$y$", BLACK)
    panel.plot((middle, middle), (-0.6, draft), color=GREY, linewidth=0.6, zorder=3)
    _span(panel, (middle - half, -0.2), (middle + half, -0.2), "$B$", BLACK)
    _span(panel, (middle - 0.4, 0.0), (middle - 0.4, draft), "$T_0 + z$", BLACK)
    _span(panel, (-2.6, 0.0), (-2.6, depth), "$h$", BLACK)
    _span(panel, (-3.0, depth + 0.16), (3.0, depth + 0.16), "$W$", BLACK)
    _span(panel, (middle + half, 0.2), (3.0, 0.2), "$y_s$ (at $\\psi = 0$)", GREEN)
    _span(panel, (-3.0, 0.2), (middle - half, 0.2), "$y_p$", GREEN)
    _arrow(panel, (2.2, 0.55), (2.2, 0.95), BLUE)
    panel.text(2.28, 0.8, "sinkage $z$", color=BLUE, va="center")
    return figure


def _span(panel: Axes, start: tuple[float, float], end: tuple[float, float], name: str, colour: str) -> None:
    _arrow(panel, start, end, colour, both=True)
    x, y = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    upright = start[0] == end[0]
    panel.text(x + (0.06 if upright else 0.0), y - (0.0 if upright else 0.05), name, color=colour, zorder=4,
               ha="left" if upright else "center", va="center" if upright else "bottom")  # fmt: skip
