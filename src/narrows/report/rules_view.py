"""Rules from outside: as lines on the chart of a safe envelope, as a picture, and as a table in the terminal."""

import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from rich.table import Table

from narrows.quantities.names import KNOT
from narrows.report.style import BLACK, GREEN, panels
from narrows.safety import OutsideRules
from narrows.safety.channel_rules import READ, REMEMBERED

STYLES = ("-", "--", ":")
LINE: dict[str, Any] = {"color": GREEN, "lw": 1.6, "zorder": 2.8}
# Of the picture [knots].
TOP = 16.0
HEADS = ("rule", "at [kn]", "offsets it leaves [m]", "speed limit [kn]", "of choking", "rudder [deg]")


def draw_widths(axes: Axes, rules: OutsideRules) -> list[Line2D]:
    """Draw how far off the middle each rule of widths lets a ship go, by its speed; return the keys of the legend."""
    # axes [m]
    low, high = axes.get_ylim()
    widths = [row for row in rules.rows() if row["width"] is not None]
    styles = dict(zip(dict.fromkeys(row["rule"] for row in widths), STYLES, strict=False))
    labels: dict[str, str] = {}
    for row in widths:
        slow, fast = max(row["slowest"], low), min(row["fastest"] or math.inf, high)
        if slow >= fast:
            continue
        label = labels.setdefault(row["rule"], row["rule"] + doubt(row))
        if row["starboard"] is None and "; none" not in label:
            labels[row["rule"]] += "; none" + (f" over {row['slowest']:g} knots" if row["slowest"] else "")
        for side in ("port", "starboard") if row["starboard"] is not None else ():
            axes.plot([row[side]] * 2, [slow, fast], ls=styles[row["rule"]], **LINE)
    return [Line2D([], [], label=label, ls=styles[rule], **LINE) for rule, label in labels.items()]


def draw_rudders(axes: Axes, rules: OutsideRules) -> None:
    """Mark the most rudder that a rule lets be kept on."""
    # axes [deg]
    for row in rules.rows():
        for angle in () if row["rudder"] is None else (row["rudder"], -row["rudder"]):
            axes.axhline(angle, ls="--", **LINE)
            words = f" {row['rule'].partition(',')[0]}: at most, for long" if angle > 0 else ""
            axes.text(0.01, angle, words, transform=axes.get_yaxis_transform(), va="bottom", fontsize=7.5)


def doubt(row: dict[str, Any]) -> str:
    """Return what the legend adds to a rule whose numbers were not all read."""
    return {READ: "", REMEMBERED: ", from memory"}.get(row["standing"], ", in part from memory")


def draw_speeds(axes: Axes, rules: OutsideRules) -> None:
    """Mark the speed limits of canals at the right edge."""
    # axes [knots]
    low, high = axes.get_ylim()
    for row in rules.rows():
        if row["speed_limit"] is not None and low <= row["speed_limit"] <= high:
            axes.axhline(row["speed_limit"], xmin=0.97, color=GREEN, lw=1.6, clip_on=False)
            axes.text(
                1.01, row["speed_limit"], row["rule"], transform=axes.get_yaxis_transform(),
                va="center", fontsize=7.2, color=BLACK,
            )  # fmt: skip


def rules_figure(rules: OutsideRules) -> Figure:
    """Draw how far off the middle each rule lets a ship go at each speed, and the speed limits."""
    figure, axes = panels(1, 1, 3.6)
    panel = axes[0, 0]
    panel.set_ylim(0.0, TOP if math.isinf(rules.choke) else rules.choke / KNOT)
    panel.set_xlim(-1.02 * rules.port, 1.02 * rules.starboard)
    keys = draw_widths(panel, rules)
    draw_speeds(panel, rules)
    for wall in (-rules.port, rules.starboard):
        panel.axvline(wall, color=BLACK, lw=3)
    panel.set(xlabel="offset from the middle [m]: port is negative", ylabel="speed through the water [knots]")
    panel.legend(handles=keys, frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    panel.grid(alpha=0.3)
    return figure


def rules_table(rules: OutsideRules) -> Table:
    """Lay the rules out for the terminal."""
    table = Table(box=None, pad_edge=False)
    for head in HEADS:
        table.add_column(head, justify="left" if head == "rule" else "right")
    for row in rules.rows():
        table.add_row(*cells(row))
    return table


def cells(row: dict[str, Any]) -> tuple[str, ...]:
    """Return a row of the rules in words, in the order of ``HEADS``."""
    speeds = left = ""
    if row["width"] is not None:
        speeds = f"{row['slowest']:g} " + (f"to {row['fastest']:g}" if row["fastest"] else "on")
        fits = row["starboard"] is not None
        left = f"{row['port']:+.0f} to {row['starboard']:+.0f}" if fits else f"none (asks for {row['width']:.0f} m)"
    limit = "" if row["speed_limit"] is None else f"{row['speed_limit']:.2f}"
    share = f"{100 * row['of_choking']:.0f} %" if row["of_choking"] else ""
    rudder = "" if row["rudder"] is None else f"{row['rudder']:g}"
    return row["rule"] + ("" if row["standing"] == READ else " *"), speeds, left, limit, share, rudder
