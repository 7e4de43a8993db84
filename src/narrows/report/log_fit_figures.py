"""Pictures of what a log taught: coefficients before and after, and what each record did."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.logbook import LogFit
from narrows.logbook.learned_coefficient import WIDE, LearnedCoefficient
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, Margins, panels

MOST_ROWS = 24
"""Coefficients that are drawn: those that were learned best."""


def log_fit_figure(fit: LogFit) -> Figure:
    """Draw the coefficients after a log in standard deviations before it, and forecasts of each record (ours).

    Parameters
    ----------
    fit : LogFit
        The answer.
    """
    known = sorted((c for c in fit.coefficients.values() if c.prior_std > 0), key=lambda c: c.left)[:MOST_ROWS]
    height = max(2.6, 0.6 + 0.2 * len(known))
    figure, axes = panels(1, 2, height, Margins(left=0.9, bottom=0.55, top=0.3, across=0.9))
    _draw_coefficients(axes[0, 0], known[::-1])
    names = [record.name for record in fit.records]
    missed = np.degrees([record.missed["psi"] for record in fit.records])
    by = (ORANGE, "by the model before"), (BLUE, "by one that learned from the others")
    for place, (colour, words) in enumerate(by):
        axes[0, 1].plot(missed[:, place], np.arange(len(names)), "o", color=colour, label=words, ms=4)
    labelled = len(names) <= MOST_ROWS
    axes[0, 1].set(yticks=np.arange(len(names)) if labelled else [], xlabel="heading missed over 3.5 lengths [deg]")
    if labelled:
        axes[0, 1].set_yticklabels(names)
    axes[0, 1].set_xlim(left=0)
    axes[0, 1].legend(frameon=False, fontsize=7, loc="lower right")
    for panel in axes[0]:
        panel.grid(alpha=0.3)
    return figure


def _draw_coefficients(axes: Axes, known: list[LearnedCoefficient]) -> None:
    axes.axvspan(-WIDE, WIDE, color=GREY, alpha=0.15, lw=0)
    axes.axvline(0, color=BLACK, lw=0.6)
    for place, c in enumerate(known):
        axes.errorbar(
            [(c.value - c.prior) / c.prior_std], [place], xerr=[WIDE * c.left], fmt="o", color=BLUE, capsize=3, ms=4
        )
    axes.set(yticks=np.arange(len(known)), xlabel="moved, in standard deviations before (grey: 95 % before)")
    axes.set_yticklabels([c.name for c in known])
