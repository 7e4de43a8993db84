"""Pictures of captive tests: where the ship was towed, and what the gauges said."""

import numpy as np
from matplotlib.figure import Figure

from narrows.captive.tests import CaptiveTests
from narrows.report.style import BLUE, DASHES, FORCE_LABELS, GREY, ORANGE, Margins, panels

# Up to so many tests are drawn against time, each with a line of its own; more are drawn row by row.
FEW = 4


def motions_figure(tests: CaptiveTests) -> Figure:
    """Draw path, heading, forces and moment of each test (the paper's fig. traj_forces)."""
    figure, axes = panels(5, 1, 7.6, Margins(), sharex=True)
    shown = [("y", "offset y [m]", 1.0), ("psi", "heading [deg]", 180 / np.pi)]
    shown += [(force, label, 1.0) for force, label in FORCE_LABELS.items()]
    for panel, (name, label, scale) in zip(axes[:, 0], shown, strict=True):
        _draw(panel, tests, name, scale)
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
    if _timed(tests):
        axes[0, 0].legend(ncols=len(tests.names), frameon=False, loc="upper right")
    axes[-1, 0].set_xlabel("time [s]" if _timed(tests) else "row of the table [1]; dashed: test boundaries")
    return figure


def _timed(tests: CaptiveTests) -> bool:
    return "t" in tests.columns and len(tests.names) <= FEW


def _draw(panel, tests: CaptiveTests, name: str, scale: float) -> None:  # type: ignore[no-untyped-def]
    column = tests.columns.get(name)
    if column is None:
        panel.text(0.5, 0.5, f"no column {name}", ha="center", transform=panel.transAxes)
        return
    if not _timed(tests):
        panel.plot(column * scale, color=BLUE, linewidth=0.8)
        boundaries(panel, tests)
        return
    for i, (test, start, stop) in enumerate(zip(tests.names, tests.starts, tests.starts[1:], strict=False)):
        rows = slice(int(start), int(stop))
        style = {"color": (BLUE, ORANGE, GREY)[i % 3], "linestyle": DASHES[i % 4], "linewidth": 0.9}
        panel.plot(tests.columns["t"][rows], column[rows] * scale, label=test, **style)


def boundaries(panel, tests: CaptiveTests) -> None:  # type: ignore[no-untyped-def]
    """Draw where one test ends and the next begins."""
    across = {"transform": panel.get_xaxis_transform(), "color": GREY, "linestyles": "--", "linewidth": 0.4}
    panel.vlines(tests.starts[1:-1], 0, 1, **across)
