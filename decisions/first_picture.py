"""The picture of the README: what a bank does to a ship, and three voyages of the published ship to their grounding."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

import narrows as nw
from narrows.report.colours import BLUE, GREY, ORANGE
from narrows.report.voyage_figures import paths_on

WRITTEN = Path(__file__).parents[1] / "docs" / "_static" / "first.png"
OFFSET, SPEED = 1.6, 1.0  # Of the ship that is drawn [m, m/s]
STARTS = (0.4, 1.0, -1.6)  # [m]
HULL = np.array([(-0.5, -0.5), (-0.5, 0.5), (0.35, 0.5), (0.5, 0.0), (0.35, -0.5)])


def figure() -> Figure:
    """Draw both panels by the published model."""
    model = nw.published("mikkelsen2025_dtc")
    drawn = Figure(figsize=(10.0, 3.2), layout="constrained")
    left, right = drawn.subplots(1, 2, width_ratios=[1, 1.7])
    _ship(left, model)
    paths_on(right, [nw.simulate(model, y=y, u=SPEED) for y in STARTS])
    right.set_title(f"Three voyages at {SPEED:g} m/s without a rudder, to the grounding", loc="left")
    return drawn


def _ship(axes: Axes, model: nw.Model) -> None:
    force, half = model.bank_forces(nw.Motion(y=OFFSET, u=SPEED)), model.canal.width / 2
    turn = np.sign(float(force["N"])) * np.radians(8.0)
    size = HULL * [model.ship.length, model.ship.beam]
    turned = size @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    for sign in (-1, 1):
        axes.axhspan(sign * half, sign * (half + 0.7), color=GREY, alpha=0.5, linewidth=0)
    axes.add_patch(Polygon(size + np.array([0, OFFSET]), facecolor=BLUE, edgecolor="black", alpha=0.85))
    axes.add_patch(Polygon(turned + np.array([0, OFFSET]), facecolor="none", edgecolor=ORANGE, linestyle="--"))
    look = {"arrowprops": {"arrowstyle": "-|>", "color": ORANGE, "linewidth": 2.5}}
    towards = OFFSET + 1.3 * np.sign(float(force["Y"]))
    axes.annotate("", (-1.0, towards), (-1.0, OFFSET), **look)
    axes.annotate("", (2.6, OFFSET + 1.6 * np.sin(turn) / np.sin(abs(turn))), (2.2, OFFSET), **look)
    axes.text(-1.4, OFFSET + 1.2, "drawn to\nthe bank", ha="right", va="center")
    axes.text(2.9, OFFSET - 1.0, "bow turned\naway from it", va="center")
    axes.set(xlim=(-5, 6), ylim=(half + 0.7, -half - 0.7), aspect="equal", xticks=[], yticks=[])
    axes.set_title("Seen from above, the ship sails to the right", loc="left")


if __name__ == "__main__":
    figure().savefig(WRITTEN, dpi=110)
