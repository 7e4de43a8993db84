"""Pictures of what a log taught: coefficients before and after, what each record did, forecasts beside the record."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.logbook import LogFit
from narrows.logbook.learned_coefficient import WIDE, LearnedCoefficient
from narrows.logbook.learning.forecasts import Forecast
from narrows.logbook.learning.record_answers import RecordAnswer
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, Margins, panels

# Coefficients and records that are named.
MOST_ROWS = 24
BY = ((ORANGE, "by the model before"), (BLUE, "by one that learned from the other records"))


def log_fit_figure(fit: LogFit) -> Figure:
    """Draw the coefficients after a log in standard deviations before it, and forecasts of each record."""
    known = sorted((c for c in fit.coefficients.values() if c.prior_std > 0), key=lambda c: c.left)[:MOST_ROWS]
    height = max(2.8, 0.9 + 0.2 * len(known))
    figure, axes = panels(1, 2, height, Margins(left=0.9, bottom=0.75, top=0.2, across=0.9))
    _draw_coefficients(axes[0, 0], known[::-1])
    _draw_missed(axes[0, 1], fit.records)
    figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="lower right", ncols=2, frameon=False, fontsize=7)
    for panel in axes[0]:
        panel.grid(alpha=0.3)
    return figure


def _draw_coefficients(axes: Axes, known: list[LearnedCoefficient]) -> None:
    axes.axvspan(-WIDE, WIDE, color=GREY, alpha=0.15, lw=0)
    axes.axvline(0, color=BLACK, lw=0.6)
    for place, c in enumerate(known):
        moved = (c.value - c.prior) / c.prior_std
        axes.errorbar([moved], [place], xerr=[WIDE * c.left], fmt="o", color=BLUE, capsize=3, ms=4)
    axes.set(yticks=np.arange(len(known)), xlabel="moved, in standard deviations before (grey: 95 % before)")
    axes.set_yticklabels([c.name for c in known])


def _draw_missed(axes: Axes, records: tuple[RecordAnswer, ...]) -> None:
    missed, places = np.degrees([record.missed["psi"] for record in records]), np.arange(len(records))
    for column, (colour, words) in enumerate(BY):
        axes.plot(missed[:, column], places, "o", color=colour, label=words, ms=4)
    axes.set(yticks=places, xlabel="heading missed over 3.5 lengths [deg]")
    axes.set_yticklabels([record.name if len(records) <= MOST_ROWS else "" for record in records], fontsize=7)
    axes.set_xlim(left=0)


def forecast_figure(record: RecordAnswer) -> Figure:
    """Draw rudder, yaw rate, heading and offset of a record beside what was foretold every 3.5 ship lengths."""
    figure, axes = panels(4, 1, 6.0, Margins(left=0.75, bottom=0.7, top=0.25, down=0.12))
    assert record.forecasts is not None
    rows = (("r", 5, 180 / np.pi, "yaw rate [deg/s]"), ("psi", 2, 180 / np.pi, "heading [deg]"), ("y", 1, 1.0, "y [m]"))
    axes[0, 0].plot(record.forecasts[1].t, np.degrees(record.forecasts[1].rudder), color=BLACK, lw=0.8)
    axes[0, 0].set(ylabel="rudder [deg]", title=record.name)
    for panel, (name, place, factor, label) in zip(axes[1:, 0], rows, strict=True):
        if name in record.measured:
            t, values = record.measured[name]
            panel.plot(t, factor * values, ".", color=GREY, ms=1.5, label="measured", rasterized=True)
        for (colour, words), foretold in zip(BY, record.forecasts, strict=True):
            draw_pieces(panel, foretold, foretold.t, factor * foretold.states[:, place], color=colour, label=words)
        panel.set(ylabel=label)
    _within(axes[1:, 0], record)
    for panel in axes[:, 0]:
        panel.grid(alpha=0.3)
        panel.set_xlim(record.forecasts[1].t[0], record.forecasts[1].t[-1])
        panel.tick_params(labelbottom=panel is axes[-1, 0])
    axes[-1, 0].set_xlabel("time [s]")
    figure.legend(*axes[-1, 0].get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False, fontsize=7)
    return figure


def draw_pieces(axes: Axes, foretold: Forecast, across: np.ndarray, up: np.ndarray, label: str, color: str) -> None:
    """Draw the pieces of a forecast, each a line of its own."""
    # across, up (n,)
    begins = np.append(0, foretold.ends[:-1] + 1)
    for number, (begin, end) in enumerate(zip(begins, foretold.ends, strict=True)):
        piece = slice(begin, end + 1)
        axes.plot(across[piece], up[piece], color=color, lw=1.0, label=None if number else label)


def _within(axes: np.ndarray, record: RecordAnswer) -> None:
    """What runs away does not hide the rest."""
    for panel, (name, factor) in zip(axes, (("r", 180 / np.pi), ("psi", 180 / np.pi), ("y", 1.0)), strict=True):
        if name in record.measured:
            values = factor * record.measured[name][1]
            room = 0.6 * float(np.ptp(values)) + 1e-9
            panel.set_ylim(values.min() - room, values.max() + room)
