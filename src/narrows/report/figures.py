"""The figure of each kind of result, for its ``plot()``."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import narrows as nw
from narrows.base.errors import InputError, check_choice, reason, shown
from narrows.base.files import PICTURES, save_figure
from narrows.control import LinearSystem
from narrows.estimation import EstimatedTrack
from narrows.estimation.states import described
from narrows.logbook.ship_log import SIGNALS, ShipLog
from narrows.report import envelope_chart, fit_figures, learning_pages, transit_report, voyage_figures
from narrows.report.colours import BLACK, BLUE, GREY, ORANGE
from narrows.report.style import FORCE_LABELS, drawing_on, notes_below, panels


def figure_of(result: Any, axes: Any = None, **style: Any) -> Figure:
    table = getattr(result, "to_dataframe", None)  # A large fleet has no room for one that is not asked for.
    is_name = isinstance(axes, str) and Path(axes).suffix not in PICTURES
    if isinstance(axes, list | tuple) or (is_name and table and axes in table()):
        style, axes = {"y": axes, **style}, None
    if isinstance(axes, str | Path):
        figure = figure_of(result, **style)
        save_figure(figure, axes)
        return figure
    axes = axes.axes[0] if isinstance(axes, Figure) and axes.axes else axes
    if axes is not None and not isinstance(axes, Axes):
        raise InputError(f"ax = {shown(axes)} is no Axes of Matplotlib; give one, as plt.subplots() makes, or a path")
    of_table = {name: style.pop(name) for name in ("x", "y") if name in style}
    own = {name: value for name, value in style.items() if name not in ("title", "figsize")}
    for name in own:
        if not hasattr(Line2D, f"set_{name}"):
            raise InputError(f"plot has no argument {name!r}; {NO_STYLE}")
    known = len(axes.lines) if axes is not None else 0
    with drawing_on(axes):
        kinds = (kind.__name__ for kind in type(result).__mro__)
        draw = next((FIGURES[kind] for kind in kinds if kind in FIGURES), table_figure)
        figure = columns_figure(table(), **of_table) if of_table and table else draw(result)
    panel = figure.axes[0] if axes is None else axes
    try:
        if own and (drawn := panel.lines[known:]):
            max(drawn, key=lambda line: np.size(line.get_xdata())).set(**own)
            if "label" in own:
                panel.legend()
        panel.set_title(style.get("title", panel.get_title()))
        figure.set_size_inches(style.get("figsize", figure.get_size_inches()))
    except (TypeError, ValueError) as error:
        raise InputError(f"plot cannot draw this ({reason(error)}); {NO_STYLE}") from None
    return figure


NO_STYLE = (
    "write ax=..., columns of its table as x=... and y=..., title, figsize, or label and color of its line "
    "(to_dataframe().plot draws other figures; nw.bank_force(model, y, u) has the numbers at a speed)"
)


def columns_figure(frame: Any, y: Any = None, x: str | None = None) -> Figure:
    """Draw columns of a table, a panel for each, over time where it rises."""
    frame = frame.reset_index()
    x = x or ("t" if "t" in frame and frame["t"].is_monotonic_increasing and y != "t" else None)
    names = [y] if isinstance(y, str) else [name for name in y or frame.select_dtypes("number") if name != x]
    for name in (*names, *filter(None, [x])):
        check_choice("column", name, frame.columns)
    figure, axes = panels(len(names), 1, 1.0 + 1.4 * len(names), sharex=True)
    for panel, name in zip(axes[:, 0], names, strict=True):
        panel.plot(frame[x] if x else frame.index, frame[name], color=BLUE)
        panel.set_ylabel(name)
    axes[-1, 0].set_xlabel(x or "row")
    return figure


def track_figure(track: EstimatedTrack) -> Figure:
    names = [name for name in SHOWN if name in track.states]
    figure, axes = panels(len(names), 1, 1.1 + 0.95 * len(names), sharex=True)
    for axis, name in zip(axes[:, 0], names, strict=True):
        place = track.states.index(name)
        unit, factor = IN_DEGREES.get(described(name)[0], (described(name)[0], 1.0))
        mean, wide = factor * track.mean[:, place], NORMAL_95 * factor * track.std[:, place]
        axis.fill_between(track.t, mean - wide, mean + wide, color=BLUE, alpha=0.25, linewidth=0, label="95 % band")
        axis.plot(track.t, mean, color=BLUE, label="estimate")
        axis.set_ylabel(f"{name.replace('_', chr(10))} [{unit}]", fontsize=8)
        for flags, colour, hatch, what in ((track.refused, ORANGE, "", "refused"),
                                           (track.suspected, GREY, "///", "suspected")):  # fmt: skip
            look = {"color": colour, "hatch": hatch, "alpha": 0.25, "linewidth": 0, "step": "mid"}
            for sensor, flag in flags.items():
                if flag.any():
                    height = {"where": flag.tolist(), "transform": axis.get_xaxis_transform()}
                    axis.fill_between(track.t, 0, 1, label=f"{sensor} {what}", **height, **look)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), frameon=False, ncols=4, loc="outside upper left")
    axes[-1, 0].set_xlabel("time [s]")
    notes_below(figure, track.notes)
    return figure


def model_figure(model: nw.Model) -> Figure:
    covered = model.data_range.speed  # Its middle, if the data give one
    speed = float(np.mean(covered)) if covered else SPEED_OF_LENGTH * math.sqrt(9.81 * model.ship.length)
    figure, axes = panels(2, 1, 4.2, sharex=True)
    if model.has_bank:
        place = REACH * (model.configuration.canal.width - model.ship.beam) / 2 * np.linspace(-1, 1, POINTS)
        motion, label = nw.Motion(y=place, u=speed), "offset y to starboard of the centreline [m]"
    else:
        place = np.linspace(-DRIFT, DRIFT, POINTS)
        motion = nw.Motion(u=speed * np.cos(np.radians(place)), v=-speed * np.sin(np.radians(place)))
        label = "drift angle, bow to starboard of the way [deg]"
    parts = [("all terms", model.forces(motion), BLUE, "-")]
    parts += [("bank's part", model.bank_forces(motion), ORANGE, "--")] * model.has_bank
    for panel, force in zip(axes[:, 0], ("Y", "N"), strict=True):
        for words, forces, colour, dash in parts:
            panel.plot(place, np.broadcast_to(forces[force], place.shape), dash, color=colour, label=words)
        panel.set_ylabel(FORCE_LABELS[force])
    axes[0, 0].set_title(f"{model.ship.in_words}; {speed:.3g} m/s", loc="left")
    axes[0, 0].legend(frameon=False)
    axes[-1, 0].set_xlabel(label)
    notes_below(figure, model.notes)
    return figure


def eigenvalues_figure(result: nw.Jacobian | LinearSystem) -> Figure:
    poles = result.poles() if isinstance(result, nw.Jacobian) else result.eigenvalues()
    figure, ((panel,),) = panels(1, 1, 3.2)
    panel.plot(poles.real.ravel(), poles.imag.ravel(), "x", color=BLUE)
    panel.axvline(0, color=BLACK, linewidth=0.7)
    panel.set(xlabel="growth rate [1/s]; right of the line: runs away", ylabel="angular frequency [rad/s]")
    return figure


def precision_figure(result: nw.Plan | nw.InformationForecast | nw.SteadyPlan) -> Figure:
    counts: Sequence[int]
    if isinstance(result, nw.Plan):
        counts, what, usual = range(1, len(result.runs) + 1), "runs", result.usual
        words, names = "as many about the centreline", result.targets
    elif isinstance(result, nw.SteadyPlan):
        if not result.legs:
            raise InputError("a plan without legs has no picture; its summary gives the reason")
        counts, what, usual = range(len(result.legs) + 1), "legs", {name: std[0] for name, std in result.std.items()}
        words, names = "now", tuple(result.std)
    else:
        counts, what, usual, words, names = result.transits, "transits", result.prior_std, "now", result.targets
    figure, axes = panels(1, len(names), 2.9)
    for panel, name in zip(axes[0], names, strict=True):
        panel.plot(counts, result.std[name], color=BLUE, marker="o", markersize=3, label=f"after these {what}")
        panel.axhline(usual[name], color=ORANGE, linestyle="--", label=words)
        panel.set(ylim=(0.0, None), xlabel=f"{what} [1]", ylabel=f"standard error of {name} [1]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), frameon=False, loc="outside upper left", ncols=2)
    return figure


def log_figure(log: ShipLog) -> Figure:
    count = max(len(log.counts), 1)
    figure, axes = panels(count, 1, 1.1 + 0.95 * count, sharex=True)
    for panel, name in zip(axes[:, 0], log.counts, strict=False):
        unit, factor = IN_DEGREES.get(SIGNALS[name].unit, (SIGNALS[name].unit, 1.0))
        for record in log:
            if name in record:
                t, values = record[name].t - record.start, factor * record[name].values
                every = len(t) // MOST_POINTS + 1
                panel.plot(t[::every], values[::every], linewidth=0.8)
        panel.set_ylabel(f"{name.replace('_', chr(10))} [{unit}]", fontsize=8)
    axes[-1, 0].set_xlabel("time of the record [s]")
    return figure


def table_figure(result: Any) -> Figure:
    """Draw the first numbers of a result's table as bars, a panel for each column."""
    frame = result.to_dataframe()
    numbers = frame.select_dtypes("number").dropna(axis=1, how="all").iloc[:, :MOST_COLUMNS]
    if numbers.empty or len(frame) > MOST_BARS:
        raise InputError(f"nothing is drawn of a {type(result).__name__}; take its data frame or dataset")
    labels = frame.index if frame.index.name else frame.iloc[:, 0]
    if "unit" in frame:
        labels = [f"{label} [{unit}]" for label, unit in zip(labels, frame["unit"], strict=True)]
    figure, axes = panels(1, numbers.shape[1], 0.9 + 0.22 * len(frame), grid="x", sharey=True)
    for panel, (name, column) in zip(axes[0], numbers.items(), strict=True):
        panel.barh(range(len(frame)), column, color=BLUE)
        panel.set_xlabel(str(name).replace("_", " "))
    axes[0, 0].set_yticks(range(len(frame)), labels)
    axes[0, 0].invert_yaxis()
    return figure


# Bars and columns of a table, and points of a curve, that a figure holds.
MOST_BARS, MOST_COLUMNS, MOST_POINTS = 60, 3, 4000
IN_DEGREES = {"rad": ("deg", 180.0 / np.pi), "rad/s": ("deg/s", 180.0 / np.pi)}
SHOWN = ("y", "psi", "v", "bank", "current", "current_across", "rudder_bias", "gyro_bias")
NORMAL_95 = 1.959964
REACH, DRIFT, POINTS = 0.9, 20.0, 181
# Froude number of the figure's speed, if the data give none.
SPEED_OF_LENGTH = 0.1


# The figure of each class of results; others draw their table.
FIGURES: dict[str, Callable[[Any], Figure]] = {
    "Fit": fit_figures.intervals_figure,
    "Comparison": fit_figures.comparison_figure,
    "Explanation": fit_figures.comparison_figure,
    "CaptiveTests": fit_figures.motions_figure,
    "Plan": precision_figure,
    "Model": model_figure,
    "Reproduction": voyage_figures.paths_figure,
    "Voyage": voyage_figures.voyage_figure,
    "Waterway": voyage_figures.waterway_figure,
    "Trials": voyage_figures.manoeuvres_figure,
    "Turning": voyage_figures.manoeuvre_figure,
    "ZigzagTest": voyage_figures.manoeuvre_figure,
    "Jacobian": eigenvalues_figure,
    "LinearSystem": eigenvalues_figure,
    "SafeEnvelope": envelope_chart.envelope_chart,
    "EnvelopeAlong": envelope_chart.envelope_along_chart,
    "EstimatedTrack": track_figure,
    "ShipLog": log_figure,
    "InformationForecast": precision_figure,
    "SteadyPlan": precision_figure,
    "SteadyFit": learning_pages.steady_figure,
    "WatchedTransit": transit_report.transit_figure,
}
