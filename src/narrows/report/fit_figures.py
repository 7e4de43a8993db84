"""Pictures of a fit: forces measured and estimated, coefficients with their intervals, Shapley shares."""

import numpy as np
from matplotlib.figure import Figure

from narrows.captive.tests import CaptiveTests
from narrows.identification import Fit
from narrows.identification.identifiability.verdict import IDENTIFIED
from narrows.identification.shapley import KINDS
from narrows.report.motion_figures import boundaries
from narrows.report.style import BLACK, BLUE, FORCE_LABELS, GREEN, GREY, HATCHES, ORANGE, Margins, panels


def estimate(fit: Fit, tests: CaptiveTests, names: tuple[str, ...]) -> np.ndarray:
    """Evaluate some terms of a fit over the rows of tests."""
    values = {**tests.configuration.values(), **tests.columns}
    parts = [fit.coefficients[name] * fit.terms[name].column(values) for name in names]
    return np.asarray(sum(parts, np.zeros(tests.rows)))


def forces_figure(fit: Fit, tests: CaptiveTests) -> Figure:
    """Draw forces measured and estimated, with the bank's part (the paper's fig. result)."""
    figure, axes = panels(3, 1, 6.2, Margins(), sharex=True)
    for panel, (force, label) in zip(axes[:, 0], FORCE_LABELS.items(), strict=True):
        terms = fit.terms.forces[force]
        names = tuple(term.name for term in terms)
        bank = tuple(term.name for term in terms if term.from_bank)
        panel.plot(tests.columns[force], color=GREY, linewidth=1.6, alpha=0.7, label="measured")
        panel.plot(estimate(fit, tests, names), color=BLUE, linewidth=0.8, label="estimated")
        if bank:
            panel.plot(estimate(fit, tests, bank), color=ORANGE, linestyle="--", linewidth=0.9, label="bank's part")
        boundaries(panel, tests)
        panel.set_ylabel(label)
    axes[1, 0].legend(frameon=False, ncols=3, loc="upper right")
    axes[-1, 0].set_xlabel("row of the table [1]; dashed: test boundaries")
    return figure


def intervals_figure(fit: Fit) -> Figure:
    """Draw each coefficient's 95 % interval over the size of its value; open where it is not well identified."""
    names = tuple(n for n in fit.terms.names if fit.verdicts[n].determined and fit.coefficients[n])
    figure, axes = panels(1, 1, 0.9 + 0.22 * len(names), Margins(left=1.0))
    panel = axes[0, 0]
    for i, name in enumerate(names):
        size, sure = abs(fit.coefficients[name]), fit.verdicts[name].status == IDENTIFIED
        low, high = (end / size for end in fit.intervals[name])
        panel.plot([low, high], [i, i], color=BLUE if sure else ORANGE, linestyle="-" if sure else "--")
        face, edge = (BLUE, BLUE) if sure else ("white", ORANGE)
        panel.plot(fit.coefficients[name] / size, i, "o", markerfacecolor=face, markeredgecolor=edge)
    panel.axvline(0, color=BLACK, linewidth=0.7)
    panel.set_yticks(range(len(names)), names)
    panel.set(xlim=(-3.5, 3.5), ylim=(max(len(names), 1) - 0.5, -0.5), ylabel="coefficient [-]")
    panel.set_xlabel("value and 95 % interval over the size of the value [1]; filled: identified, open: not")
    panel.grid(alpha=0.3, axis="x")
    return figure


def shapley_figure(fit: Fit) -> Figure:
    """Draw the Shapley shares of each force's terms, of all three kinds."""
    shares = {kind: fit.shapley(kind) for kind in KINDS}
    forces = list(shares[KINDS[0]])
    sizes = [len(shares["mse"][f]) for f in forces]
    figure, axes = panels(
        1, len(forces), 2.9, Margins(bottom=0.85, top=0.3, across=0.15), sharey=True, width_ratios=sizes
    )
    for panel, force in zip(axes[0], forces, strict=True):
        names = tuple(shares["mse"][force])
        for i, (kind, colour) in enumerate(zip(KINDS, (BLUE, ORANGE, GREEN), strict=True)):
            height = np.arange(len(names)) + 0.27 * (i - 1)
            bars = {"width": 0.26, "color": colour, "hatch": HATCHES[i], "edgecolor": "white", "label": kind}
            panel.bar(height, list(shares[kind][force].values()), **bars)
        panel.axhline(0, color=BLACK, linewidth=0.7)
        panel.set_xticks(range(len(names)), names, rotation=90)
        panel.set_title(force, y=1.0)
        panel.set_xlabel("coefficient [-]")
        panel.grid(alpha=0.3, axis="y")
    axes[0, 0].set_ylabel("Shapley share [1]")
    axes[0, -1].legend(frameon=False)
    return figure
