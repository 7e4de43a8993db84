"""A record from above: where the ship was, beside where it was foretold."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.logbook.learning.record_answers import RecordAnswer
from narrows.report.log_fit_figures import BY, draw_pieces
from narrows.report.style import GREY, Margins, panels

# Height of the picture [in].
TALLEST, FLATTEST = 5.5, 1.6
# Along over across, up to which both are drawn to one scale.
TRUE_SHAPE = 8.0
# Beside the track, of its extent: what is foretold further off is not shown.
ROOM = 0.08


def log_track_figure(record: RecordAnswer) -> Figure:
    """Draw the measured track and those foretold every 3.5 ship lengths, from above, starboard down."""
    assert record.forecasts is not None
    t, y = record.measured["y"]
    x = np.interp(t, *record.measured["x"])
    along, across = float(np.ptp(x)), float(np.ptp(y))
    to_scale = max(along, across) <= TRUE_SHAPE * min(along, across)
    margins = Margins(left=0.75, bottom=0.75, top=0.3)
    high = 6.3 * (across / along if to_scale else 0.25) + margins.bottom + margins.top
    figure, axes = panels(1, 1, float(np.clip(high, FLATTEST, TALLEST)), margins)
    panel: Axes = axes[0, 0]
    panel.plot(x, y, ".", color=GREY, ms=2.5, label="measured", rasterized=True)
    for (colour, words), foretold in zip(BY, record.forecasts, strict=True):
        draw_pieces(panel, foretold, foretold.states[:, 0], foretold.states[:, 1], label=words, color=colour)
    panel.set(xlim=_about(x), ylim=_about(y)[::-1], xlabel="x [m]", ylabel="y, to starboard [m]")
    shape = "to scale" if to_scale else "not to scale: y is stretched"
    panel.set_title(f"{record.name} from above, {shape}")
    panel.set_aspect("equal" if to_scale else "auto", adjustable="datalim")
    panel.grid(alpha=0.3)
    figure.legend(*panel.get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False, fontsize=7)
    return figure


def _about(values: np.ndarray) -> tuple[float, float]:
    """From where to where a track is shown."""
    room = ROOM * float(np.ptp(values)) + 1.0
    return float(values.min()) - room, float(values.max()) + room
