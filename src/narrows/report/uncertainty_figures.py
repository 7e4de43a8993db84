"""Pictures of how far coefficients can be trusted: profiles of the likelihood, and which test tells of which."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from narrows.identification import Comparison, Fit
from narrows.identification.uncertainty.interval import t_quantile
from narrows.report.collinearity_figures import COLOURS, MARKERS
from narrows.report.style import BLUE, GREY, ORANGE, Margins, panels

PANELS_A_ROW, ROW_HEIGHT = 4, 1.45
MOST_TESTS = 60


def profiles_figure(fit: Fit) -> Figure | None:
    """Draw the profile likelihood of each coefficient; None where none is identifiable."""
    profiles = [profiles for name in fit.terms.names if (profiles := fit.profile(name))]
    if not profiles:
        return None
    rows = -(-len(profiles) // PANELS_A_ROW)
    figure, axes = panels(
        rows, PANELS_A_ROW, ROW_HEIGHT * rows + 0.4, Margins(bottom=0.3, top=0.3, across=0.35, down=0.5)
    )
    for panel in axes.flat[len(profiles) :]:
        panel.set_visible(False)
    for panel, curve in zip(axes.flat, profiles, strict=False):
        index = fit.terms.names.index(curve.name)
        limit = float(t_quantile(fit.unbounded.counts[index])) ** 2
        panel.plot(curve.values, curve.deviance, color=BLUE, linewidth=1.2)
        panel.axhline(limit, color=GREY, linestyle=":", linewidth=0.9)
        panel.axvline(fit.coefficients[curve.name], color=ORANGE, linestyle="--", linewidth=0.9)
        panel.set_ylim(0, max(3 * limit, 1.0))
        panel.set_title(f"{curve.name} [{fit.terms[curve.name].dimension.unit}]", fontsize=8, y=1.0)
        panel.tick_params(labelsize=6)
        panel.xaxis.set_major_locator(MaxNLocator(2))
        panel.yaxis.set_major_locator(MaxNLocator(3))
    figure.supylabel("deviance [1]", fontsize=8)
    return figure


def influence_figure(fit: Fit) -> Figure:
    """Draw what share of what is known of each coefficient goes with each test."""
    told = fit.influence
    shown = np.argsort(-told.information.max(axis=1))[:MOST_TESTS]
    shown = np.sort(shown)
    left = 0.5 + 0.05 * max(len(told.tests[i]) for i in shown)
    figure, axes = panels(1, 1, 1.6 + 0.13 * len(shown), Margins(left=min(left, 3.0), right=0.1, bottom=0.85))
    panel = axes[0, 0]
    image = panel.imshow(told.information[shown], cmap="Blues", vmin=0, vmax=1, aspect="auto")
    panel.set_xticks(range(len(told.names)), told.names, rotation=90)
    panel.set_yticks(range(len(shown)), [told.tests[i] for i in shown], fontsize=5.5)
    panel.set(xlabel="coefficient [-]", ylabel="test [-]")
    figure.colorbar(image, ax=panel, label="share of what is known that goes with the test [1]", shrink=0.8)
    return figure


def comparison_figure(rows: list[dict], forces: tuple[str, ...] = ("Y", "N")) -> Figure:  # type: ignore[type-arg]
    """Draw the error of each table of terms on what was left out, and of the fit."""
    names = list(dict.fromkeys(row["table"] for row in rows))
    figure, axes = panels(1, len(forces), 0.9 + 0.22 * len(names), sharey=True)
    for panel, force in zip(axes[0], forces, strict=True):
        by_table = {row["table"]: row for row in rows if row["force"] == force}
        for kind, marker, colour, label in (
            ("rmse", "|", GREY, "of the fit"),
            ("rmse_left_out", "o", BLUE, "on tests left out"),
            ("rmse_other_speeds", "x", ORANGE, "on speeds left out"),
        ):
            known = [
                (by_table[n][kind], i) for i, n in enumerate(names) if n in by_table and np.isfinite(by_table[n][kind])
            ]
            if known:
                panel.plot(*zip(*known, strict=True), marker, color=colour, label=label, markersize=5)
        panel.set_xscale("log")
        panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        panel.xaxis.set_major_formatter("{x:g}")
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.set(xlabel=f"RMSE of {force} [{'N m' if force == 'N' else 'N'}]")
        panel.set_yticks(range(len(names)), names)
        panel.grid(alpha=0.3)
    axes[0, 0].invert_yaxis()
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, fontsize=7, loc="outside upper center", ncols=3)
    return figure


def forms_figure(comparisons: Mapping[str, Comparison]) -> Figure:
    """Draw the error of each form of the bank term on what was left out, over that of the best, for sets of tests."""
    names = [name.removeprefix("bank only: ") for name in next(iter(comparisons.values())).fits]
    figure, axes = panels(2, 1, 5.6, sharex=True)
    for panel, force in zip(axes[:, 0], ("Y", "N"), strict=True):
        for i, (label, comparison) in enumerate(comparisons.items()):
            errors = np.array([fit.left_out[force].rmse for fit in comparison.fits.values()])
            style = {"marker": MARKERS[i % 6], "color": COLOURS[i % 6], "linestyle": "none", "markersize": 5}
            panel.plot(np.arange(len(names)) + 0.09 * (i - 2.5), errors / errors.min(), label=label, **style)
        panel.set(yscale="log", ylabel=f"RMSE of {force} left out,\nover the best form's [1]")
        panel.grid(alpha=0.3, axis="y")
    axes[1, 0].set_xticks(range(len(names)), names)
    axes[1, 0].set_xlabel("form of the bank term [-]")
    axes[0, 0].legend(frameon=False, fontsize=6.5, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=1)
    return figure
