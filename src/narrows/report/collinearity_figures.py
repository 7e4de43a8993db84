"""Pictures of the columns: correlations, and variance inflation over all rows and within each speed."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from narrows.identification import Fit
from narrows.identification.identifiability.diagnosis import Diagnosis
from narrows.identification.identifiability.verdict import CONFOUNDED_VIF, VIF_LIMIT
from narrows.report.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, Margins, panels

MARKERS = ("o", "^", "s", "D", "v", "P")
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, GREY, BLACK)


def correlation_figure(fit: Fit) -> Figure:
    """Draw the correlations between the columns of each force, with rank and condition (the paper's fig. corr)."""
    overall = fit.diagnostics.overall
    sizes = [max(4, len(d.names)) for d in overall.values()]
    margins = Margins(left=0.65, right=0.65, bottom=0.65, top=0.4, across=0.6)
    figure, axes = panels(1, len(overall), 3.3, margins, width_ratios=sizes)
    image = None
    for panel, (force, diagnosis) in zip(axes[0], overall.items(), strict=True):
        image = _matrix(panel, diagnosis)
        condition = f"{diagnosis.condition:.0f}" if np.isfinite(diagnosis.condition) else "∞"
        panel.set_title(
            f"{force}: rank {diagnosis.rank} of {len(diagnosis.names)},\ncondition {condition}", fontsize=8, y=1.0
        )
    if image is not None:
        figure.colorbar(image, cax=figure.add_axes((0.925, 0.25, 0.012, 0.55)), label="correlation [1]")
    return figure


def _matrix(panel, diagnosis: Diagnosis):  # type: ignore[no-untyped-def]
    values = diagnosis.correlation
    panel.set_facecolor("#DDDDDD")
    image = panel.imshow(values, cmap="PuOr", vmin=-1, vmax=1)
    for i, row in enumerate(values):
        for j, value in enumerate(row):
            text = f"{value:.2f}".replace("0.", ".") if np.isfinite(value) else "const."
            panel.text(j, i, text, ha="center", va="center", fontsize=5.5, color=_ink(value))
    panel.set_xticks(range(len(values)), diagnosis.names, rotation=90, fontsize=7)
    panel.set_yticks(range(len(values)), diagnosis.names, fontsize=7)
    return image


def _ink(value: float) -> str:
    return "white" if abs(value) > 0.7 else "black"


def inflation_figure(fit: Fit) -> Figure:
    """Draw the variance inflation of each coefficient, over all rows and within each speed."""
    names = tuple(term.name for term in (*fit.terms.sway, *fit.terms.yaw))
    figure, axes = panels(1, 1, 3.2, Margins(left=0.9, bottom=0.85, top=0.35))
    panel = axes[0, 0]
    everywhere = {n: d.vif[n] for d in fit.diagnostics.overall.values() for n in d.names}
    panel.plot(range(len(names)), [_finite(everywhere[n]) for n in names], "k_", markersize=14, label="all rows")
    for i, (speed, by_force) in enumerate(fit.diagnostics.by_speed.items()):
        inflation = {n: d.vif[n] for d in by_force.values() for n in d.names}
        style = {"color": COLOURS[i % 6], "marker": MARKERS[i % 6], "linestyle": "none", "markersize": 5}
        panel.plot(range(len(names)), [_finite(inflation[n]) for n in names], label=f"{speed:.2f} m/s alone", **style)
    for limit, dashes in ((VIF_LIMIT, "--"), (CONFOUNDED_VIF, ":")):
        panel.axhline(limit, color=GREY, linestyle=dashes, linewidth=0.9)
    panel.set(yscale="log", ylabel="variance inflation [1]", xlabel="coefficient [-]")
    panel.yaxis.set_major_formatter("{x:g}")
    panel.yaxis.set_minor_formatter(NullFormatter())
    panel.set_xticks(range(len(names)), names, rotation=90)
    panel.grid(alpha=0.3, axis="y")
    panel.legend(frameon=False, ncols=4, loc="upper center", bbox_to_anchor=(0.5, 1.15))
    return figure


def _finite(value: float) -> float:
    return value if np.isfinite(value) else np.nan
