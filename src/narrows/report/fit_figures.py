"""Figures of a fit: measured and estimated forces, coefficients with their intervals, correlations."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

import narrows as nw
from narrows.base.errors import check_choice
from narrows.model.data_range import Range
from narrows.physics.clearance import delta, taper
from narrows.quantities.names import FORCES
from narrows.report.colours import BLACK, BLUE, DASHES, GREEN, GREY, ORANGE
from narrows.report.style import FORCE_LABELS, drawing_on, panels

ROWS = "row of the table [1]; dashed: test boundaries"


def forces_figure(fit: nw.Fit, tests: nw.CaptiveTests) -> Figure:
    """Draw forces measured and estimated, with the bank's part (the paper's fig. result)."""
    figure, axes = panels(3, 1, 6.2, "", sharex=True)
    values = {**tests.configuration.values(), **tests.columns}
    for panel, (force, label) in zip(axes[:, 0], FORCE_LABELS.items(), strict=True):
        terms = fit.terms.forces[force]
        parts = {term: fit.coefficients[term.name] * term.column(values) for term in terms}
        banks = [part for term, part in parts.items() if term.from_bank]
        none = np.zeros(tests.rows)
        panel.plot(tests.columns[force], color=GREY, linewidth=1.6, alpha=0.7, label="measured")
        panel.plot(sum(parts.values(), none), color=BLUE, linewidth=0.8, label="estimated")
        if banks:
            panel.plot(sum(banks, none), color=ORANGE, linestyle="--", linewidth=0.9, label="bank's part")
        boundaries(panel, tests)
        panel.set_ylabel(label)
    axes[1, 0].legend(frameon=False, ncols=3, loc="upper right")
    axes[-1, 0].set_xlabel(ROWS)
    return figure


def residuals_figure(fit: nw.Fit, given: Axes | None = None, force: str | None = None) -> Figure:
    forces = [name for name, terms in fit.terms.forces.items() if terms]
    if force is not None:
        check_choice("force", force, forces)
        forces = [force]
    forces = forces if given is None else forces[:1]
    estimates, residuals = fit.predict(), fit.residuals
    with drawing_on(given):
        figure, axes = panels(len(forces), 1, 0.5 + 1.9 * len(forces))
    for panel, force in zip(axes[:, 0], forces, strict=True):
        for test, own in residuals[force].groupby(level="test", sort=False):
            panel.plot(estimates[force].loc[[str(test)]], own, ".", markersize=2, alpha=0.5)
        panel.axhline(0.0, color=BLACK, linewidth=0.7)
        name, _, unit = FORCE_LABELS[force].rpartition(" [")
        panel.set(xlabel=f"estimated {name} [{unit}", ylabel=f"measured less\nestimated {force} [{unit}")
    return figure


def left_out_figure(fit: nw.Fit, tests: nw.CaptiveTests) -> Figure:
    values = {**tests.configuration.values(), **tests.columns}
    without = fit.problem.fits(fit.motions.without)
    motion = {name: i for i, members in enumerate(fit.motions.members) for name in members}
    rows = without[np.repeat([motion[name] for name in tests.names], np.diff(tests.starts))]
    forces = [force for force in ("Y", "N") if fit.terms.forces[force]]
    figure, axes = panels(1, len(forces), 3.2, "")
    for panel, force in zip(axes[0], forces, strict=True):
        terms = fit.terms.forces[force]
        predicted = sum(term.column(values) * rows[:, fit.terms.names.index(term.name)] for term in terms)
        measured, unit = tests.columns[force], FORCES[force].unit
        panel.plot(predicted, measured, ".", color=BLUE, markersize=2, alpha=0.6, rasterized=True)
        panel.plot(*[[measured.min(), measured.max()]] * 2, color=BLACK, linewidth=0.7)
        panel.set(xlabel=f"{force} predicted without the motion [{unit}]", ylabel=f"{force} measured [{unit}]")
        panel.set_title(f"R2 {fit.left_out[force].r2:.3f}", fontsize=9)
    return figure


def intervals_figure(fit: nw.Fit) -> Figure:
    """Draw each coefficient's 95 % interval relative to its value; with an open marker if poorly identified."""
    names = tuple(n for n in fit.terms.names if fit.verdicts[n].determined and fit.coefficients[n])
    figure, ((panel,),) = panels(1, 1, 0.9 + 0.22 * len(names), "x")
    for i, name in enumerate(names):
        value, sure = fit.coefficients[name], fit.verdicts[name] == "identified"
        colour = BLUE if sure else ORANGE
        ends = np.array(fit.intervals[name]) / abs(value)
        panel.plot(ends, [i, i], color=colour, linestyle="-" if sure else "--")
        panel.plot(np.sign(value), i, "o", markerfacecolor=colour if sure else "white", markeredgecolor=colour)
    panel.axvline(0, color=BLACK, linewidth=0.7)
    panel.set_yticks(range(len(names)), names)
    panel.set(xlim=(-3.5, 3.5), ylim=(max(len(names), 1) - 0.5, -0.5), ylabel="coefficient [-]")
    panel.set_xlabel("value and 95 % interval over the size of the value [1]; filled: identified, open: not")
    return figure


# Figures of delta, the pressure difference between the sides near banks.
def delta_figure(configuration: nw.Configuration, covered: Range | None) -> Figure:
    """Draw delta and its taper across the canal (the paper's fig. Delta_fun)."""
    # covered [m]
    width, beam = configuration.canal.width, configuration.ship.beam
    y = np.linspace(-1, 1, 801) * 0.97 * (width - beam) / 2
    figure, ((panel,),) = panels(1, 1, 3.0)
    if covered:
        known = f"tested range, |y| up to {covered[1]:.3g} m"
        panel.axvspan(-covered[1], covered[1], color=GREEN, alpha=0.15, label=known)
    panel.plot(y, delta(y, 1.0, width, beam), color=BLUE, label="delta")
    panel.plot(y, taper(y, width) * delta(y, 1.0, width, beam), color=ORANGE, linestyle="--", label="with taper")
    panel.set(ylim=(-4.5, 4.5), xlabel="offset y [m]", ylabel="delta [1]")
    panel.legend(frameon=False)
    return figure


def delta_surface_figure(configuration: nw.Configuration) -> Figure:
    """Draw delta over offset and heading (the paper's fig. delta_surf), as contours."""
    width, beam = configuration.canal.width, configuration.ship.beam
    y, psi = np.linspace(-1, 1, 301) * 0.93 * (width - beam) / 2, np.linspace(-89, 89, 241)
    values = delta(y[None, :], np.cos(np.radians(psi))[:, None], width, beam)
    figure, ((panel,),) = panels(1, 1, 3.2, "")
    levels = [-4, -2, -1, -0.5, -0.2, -0.1, 0, 0.1, 0.2, 0.5, 1, 2, 4]
    filled = panel.contourf(y, psi, values, levels=levels, cmap="PuOr", extend="both", norm="symlog")
    lines = panel.contour(y, psi, values, levels=levels, colors="black", linewidths=0.5)
    panel.clabel(lines, fontsize=7, fmt="%g")
    figure.colorbar(filled, ax=panel, label="delta [1]")
    panel.set(xlabel="offset y [m]", ylabel="heading [deg]")
    return figure


def correlation_figure(fit: nw.Fit) -> Figure:
    """Draw the correlations between the columns of each force, with rank and condition (the paper's fig. corr)."""
    overall = fit.diagnostics.overall
    figure, axes = panels(1, len(overall), 3.3, "", width_ratios=[max(4, len(d.names)) for d in overall.values()])
    for panel, (force, diagnosis) in zip(axes[0], overall.items(), strict=True):
        values, names = diagnosis.correlation, diagnosis.names
        panel.set_facecolor("#DDDDDD")
        for (i, j), value in np.ndenumerate(values):
            text = f"{value:.2f}".replace("0.", ".") if np.isfinite(value) else "const."
            ink = "white" if abs(value) > 0.7 else "black"
            panel.text(j, i, text, ha="center", va="center", fontsize=6.5, color=ink)
        panel.set_xticks(range(len(names)), names, rotation=90, fontsize=7)
        panel.set_yticks(range(len(names)), names, fontsize=7)
        image = panel.imshow(values, cmap="PuOr", vmin=-1, vmax=1)
        condition = f"{diagnosis.condition:.0f}" if np.isfinite(diagnosis.condition) else "∞"
        rank = f"{force}: rank {diagnosis.rank} of {len(names)}"
        panel.set_title(f"{rank},\ncondition {condition}", fontsize=8, y=1.0)
    figure.colorbar(image, ax=axes[0].tolist(), label="correlation [1]", shrink=0.7, aspect=40)
    return figure


def comparison_figure(result: nw.Comparison | nw.Explanation) -> Figure:
    compared = result.comparison if isinstance(result, nw.Explanation) else result
    rows, names = compared.rows(), [*compared.fits]
    figure, axes = panels(1, len(compared.forces), 0.9 + 0.22 * len(names), sharey=True)
    looks = (
        ("rmse", "|", GREY, "of the fit"), ("rmse_left_out", "o", BLUE, "on left-out tests"),
        ("rmse_other_speeds", "x", ORANGE, "on left-out speeds"),
    )  # fmt: skip
    for panel, force in zip(axes[0], compared.forces, strict=True):
        own = [(row, names.index(row["table"])) for row in rows if row["force"] == force]
        for kind, marker, colour, label in looks:
            known = [(row[kind], place) for row, place in own if np.isfinite(row[kind])]
            if known:
                panel.plot(*zip(*known, strict=True), marker, color=colour, label=label, markersize=5)
        panel.set_xscale("log")
        panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        panel.xaxis.set_major_formatter("{x:g}")
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.set(xlabel=f"RMSE of {force} [{FORCES[force].unit}]")
        panel.set_yticks(range(len(names)), names)
    axes[0, 0].set_ylim(len(names) - 0.5, -0.5)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, fontsize=7, loc="outside upper center", ncols=3)
    return figure


# Figures of captive tests: the towed motions and the measured forces. Up to so many tests are drawn against time, one
# line each; more are drawn row by row.
TIME_SERIES_MAX_TESTS = 4


def motions_figure(tests: nw.CaptiveTests) -> Figure:
    """Draw path, heading, forces and moment of each test (the paper's fig. traj_forces)."""
    figure, axes = panels(5, 1, 7.6, sharex=True)
    timed = "t" in tests.columns and len(tests.names) <= TIME_SERIES_MAX_TESTS
    for panel, (name, label) in zip(
        axes[:, 0], ({"y": "offset y [m]", "psi": "heading [deg]"} | FORCE_LABELS).items(), strict=True
    ):
        panel.set_ylabel(label)
        if name not in tests.columns:
            panel.text(0.5, 0.5, f"no column {name}", ha="center", transform=panel.transAxes)
            continue
        column = np.degrees(tests.columns[name]) if name == "psi" else tests.columns[name]
        if not timed:
            panel.plot(column, color=BLUE, linewidth=0.8)
            boundaries(panel, tests)
            continue
        for i, (test, start, stop) in enumerate(zip(tests.names, tests.starts, tests.starts[1:], strict=False)):
            rows = slice(int(start), int(stop))
            style = {"color": (BLUE, ORANGE, GREY)[i % 3], "linestyle": DASHES[i % 4], "linewidth": 0.9}
            panel.plot(tests.columns["t"][rows], column[rows], label=test, **style)
    if timed:
        axes[0, 0].legend(ncols=len(tests.names), frameon=False, loc="upper right")
    axes[-1, 0].set_xlabel("time [s]" if timed else ROWS)
    return figure


def boundaries(panel: Axes, tests: nw.CaptiveTests) -> None:
    panel.vlines(tests.starts[1:-1], 0, 1, GREY, "--", transform=panel.get_xaxis_transform(), linewidth=0.4)
