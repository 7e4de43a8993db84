"""Pictures of a ship's own records: where it went, how rudder, heading and speed went with it, what is wrong."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.logbook import LogFindings, ShipLog, Signal
from narrows.report.style import BLUE, GREEN, GREY, ORANGE, PURPLE, panels

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, GREY)
# Of a curve.
MOST_POINTS = 4000
MOST_RECORDS = 12
LEGEND_RECORDS = 5


def log_figure(log: ShipLog) -> Figure:
    """Draw the records of a ship: tracks; rudder, heading, yaw rate and speeds over time."""
    figure, axes = panels(3, 2, 6.4)
    track, *others = axes.ravel()
    for place, record in enumerate(log.records[:MOST_RECORDS]):
        colour = COLOURS[place % len(COLOURS)]
        if "x" in record and "y" in record:
            x, y = _thinned(record["x"]), record["y"]
            track.plot(x.values, y.at(x.t), color=colour, linewidth=1.0, label=record.name)
        for panel, (names, factor, _) in zip(others, CURVES, strict=True):
            if name := next((name for name in names if name in record), None):
                curve = _thinned(record[name])
                panel.plot(curve.t - record.start, factor * curve.values, color=colour, linewidth=0.8)
    _finish(track, "along x [m]", "to starboard y [m]")
    if len(log) <= LEGEND_RECORDS and track.lines:
        track.legend(frameon=False)
    for panel, (_, _, label) in zip(others, CURVES, strict=True):
        _finish(panel, "time of the record [s]", label)
    return figure


# Signals, the first that a record has, factor and label of each panel beside the track.
CURVES = (
    (("rudder",), 180 / np.pi, "rudder [deg]"),
    (("psi",), 180 / np.pi, "heading [deg]"),
    (("r",), 180 / np.pi, "yaw rate [deg/s]"),
    (("u", "u_ground", "speed_over_ground"), 1.0, "speed ahead [m/s]"),
    (("v", "v_ground"), 1.0, "speed to starboard [m/s]"),
)


def _thinned(signal: Signal) -> Signal:
    step = max(1, len(signal) // MOST_POINTS)
    return Signal(signal.t[::step], signal.values[::step])


def _finish(axes: Axes, below: str, beside: str) -> None:
    axes.set(xlabel=below, ylabel=beside)
    axes.grid(alpha=0.3)


def findings_figure(result: LogFindings) -> Figure:
    """Draw what is wrong with a log: a mark for each finding, by record and by what was looked at."""
    records = list(dict.fromkeys(finding.record for finding in result))
    checks = list(dict.fromkeys(finding.check for finding in result))
    figure, axes = panels(1, 1, 1.4 + 0.22 * max(len(records), 1))
    for wrong, colour, mark, label in ((True, ORANGE, "X", "wrong"), (False, BLUE, "o", "doubtful")):
        marked = [finding for finding in result if finding.wrong is wrong]
        places = [(checks.index(own.check), records.index(own.record)) for own in marked]
        x, y = zip(*places, strict=True) if places else ((), ())
        axes[0, 0].plot(x, y, mark, color=colour, label=label)
    axes[0, 0].set_xticks(range(len(checks)), checks)
    axes[0, 0].set_yticks(range(len(records)), records)
    axes[0, 0].margins(0.2)
    axes[0, 0].set_title("" if len(result) else result.summary())
    if len(result):
        axes[0, 0].legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure
