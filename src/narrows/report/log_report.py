"""Results learned from a log, as one self-contained page."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from narrows.logbook.learned_coefficients import ON_TWINS, QUANTILE_95
from narrows.logbook.learning.log_fit import LogFit, RecordAnswer
from narrows.logbook.ship_log import ShipLog, Signal
from narrows.report.fit_page import figure, write_page
from narrows.report.pilot_page import LEARNED, learned_rows
from narrows.report.printed_tables import print_result, table_of
from narrows.report.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, legend_below, panels

# Margin around measured values, relative to their extent.
ROOM_ACROSS = 0.6
# Errors of forecasts: state, words, factor.
MISSED = (("y", "offset [m]", 1.0), ("psi", "heading [deg]", 180 / np.pi), ("r", "yaw rate [deg/s]", 180 / np.pi))
BESIDE = "Measured, and predicted every 3.5 ship lengths with the recorded rudder."


def write_log_report(fit: LogFit, path: str | Path, truth: Mapping[str, float] | None = None) -> None:
    caption = (
        "Left: coefficients after the log, in standard deviations before it, with 95 % intervals. Right: what "
        "forecasts over 3.5 ship lengths miss of each record, by the model before and by one that learned from all "
        "other records."
    )
    write_page(
        path,
        "log_fit.html.j2",
        title=f"{fit.prior.configuration.ship.name or 'A ship'}: learned from its own log",
        said=fit.summary().splitlines(),
        learned=learned_rows(fit.coefficients, truth),
        twin=truth is not None,
        figure=figure(log_fit_figure(fit), caption),
        missed_heads=[words for _, words, _ in MISSED],
        records=[_row(fit, number) for number in range(len(fit.records))],
        informed=list(_informed(fit)),
        forecasts=[figure(forecast_figure(record), BESIDE) for record in fit.records if record.forecasts],
        notes=[note for note in fit.notes if note != ON_TWINS],
    )


def _informed(fit: LogFit) -> tuple[str, ...]:
    """Coefficients whose records are compared: those of the bank, or those with the best information."""
    known = [c for c in fit.coefficients.values() if c.name in fit.records[0].information]
    bank = [c.name for c in known if c.from_bank]
    return tuple(bank or [c.name for c in sorted(known, key=lambda c: c.std_ratio)[:3]])


def _row(fit: LogFit, number: int) -> dict[str, object]:
    record = fit.records[number]
    return {
        "name": record.name,
        "minutes": f"{record.duration / 60:.3g}",
        "missed": [f"{factor * old:.2g} to {factor * new:.2g}" for name, _, factor in MISSED
                   for old, new in (record.forecast_rmse[name],)],
        "information": [f"{100 * record.information[name]:.0f} %" for name in _informed(fit)],
    }  # fmt: skip


# Largest number of listed coefficients and records.
MOST_ROWS = 24
BY = ((ORANGE, "by the model before"), (BLUE, "by one that learned from the other records"))


def log_fit_figure(fit: LogFit) -> Figure:
    known = sorted((c for c in fit.coefficients.values() if c.prior_std > 0), key=lambda c: c.std_ratio)[:MOST_ROWS]
    height = max(2.8, 0.9 + 0.2 * len(known))
    figure, axes = panels(1, 2, height)
    left, right = axes[0]
    left.axvspan(-QUANTILE_95, QUANTILE_95, color=GREY, alpha=0.15, lw=0)
    left.axvline(0, color=BLACK, lw=0.6)
    for place, c in enumerate(known[::-1]):
        moved = (c.value - c.prior) / c.prior_std
        left.errorbar([moved], [place], xerr=[QUANTILE_95 * c.std_ratio], fmt="o", color=BLUE, capsize=3, ms=4)
    left.set(xlabel="change, in prior standard deviations (grey: 95 % before)")
    left.set_yticks(range(len(known)), [c.name for c in known[::-1]])
    missed, places = np.degrees([record.forecast_rmse["psi"] for record in fit.records]), range(len(fit.records))
    for column, (colour, words) in enumerate(BY):
        right.plot(missed[:, column], places, "o", color=colour, label=words, ms=4)
    names = [record.name if len(places) <= MOST_ROWS else "" for record in fit.records]
    right.set_yticks(places, names, fontsize=7)
    right.set(xlabel="heading error over 3.5 lengths [deg]")
    right.set_xlim(left=0)
    legend_below(figure, right.get_legend_handles_labels()[0], 2)
    return figure


def forecast_figure(record: RecordAnswer) -> Figure:
    """Draw rudder, yaw rate, heading and offset of a record with predictions every 3.5 ship lengths."""
    figure, axes = panels(4, 1, 6.0)
    assert record.forecasts is not None
    rows = (("r", 5, 180 / np.pi, "yaw rate [deg/s]"), ("psi", 2, 180 / np.pi, "heading [deg]"), ("y", 1, 1.0, "y [m]"))
    axes[0, 0].plot(record.forecasts[1].t, np.degrees(record.forecasts[1].rudder), color=BLACK, lw=0.8)
    axes[0, 0].set(ylabel="rudder [deg]", title=record.name)
    for panel, (name, place, factor, label) in zip(axes[1:, 0], rows, strict=True):
        if name in record.measured:
            t, values = record.measured[name]
            panel.plot(t, factor * values, ".", color=GREY, ms=1.5, label="measured", rasterized=True)
            room = ROOM_ACROSS * factor * float(np.ptp(values)) + 1e-9  # A prediction that diverges hides no other.
            panel.set_ylim(factor * float(values.min()) - room, factor * float(values.max()) + room)
        for (colour, words), predicted in zip(BY, record.forecasts, strict=True):
            begins = np.append(0, predicted.ends[:-1] + 1)
            for begin, end in zip(begins, predicted.ends, strict=True):
                piece, words_once = slice(begin, end + 1), None if begin else words
                values = factor * predicted.states[piece, place]
                panel.plot(predicted.t[piece], values, color=colour, lw=1.0, label=words_once)
        panel.set(ylabel=label)
    for panel in axes[:, 0]:
        panel.set_xlim(record.forecasts[1].t[0], record.forecasts[1].t[-1])
        panel.tick_params(labelbottom=panel is axes[-1, 0])
    axes[-1, 0].set_xlabel("time [s]")
    legend_below(figure, axes[-1, 0].get_legend_handles_labels()[0])
    return figure


def print_log_fit(fit: LogFit, truth: Mapping[str, float] | None = None) -> None:
    words = "estimate from the log"
    columns = {**LEARNED, words: "{verdict}", **({"truth": "{truth:.3g}"} if truth else {})}
    print_result(fit, table_of(columns, learned_rows(fit.coefficients, truth), left=("", "unit", words)))


COLOURS = (BLUE, ORANGE, GREEN, PURPLE, GREY)
# Largest number of points of a curve.
MOST_POINTS = 4000
MOST_RECORDS = 12
LEGEND_RECORDS = 5


def log_figure(log: ShipLog) -> Figure:
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
    track.set(xlabel="along x [m]", ylabel="to starboard y [m]")
    if len(log) <= LEGEND_RECORDS and track.lines:
        track.legend(frameon=False)
    for panel, (_, _, label) in zip(others, CURVES, strict=True):
        panel.set(xlabel="time of the record [s]", ylabel=label)
    return figure


# Signals of the panels below the track (the first one in the record), factor and label.
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
