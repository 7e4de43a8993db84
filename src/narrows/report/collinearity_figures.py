"""Pictures of the columns: correlations, and variance inflation over all rows and within each speed."""

import numpy as np
from matplotlib.figure import Figure

from narrows.identification import Fit
from narrows.identification.identifiability.diagnosis import Diagnosis
from narrows.identification.identifiability.verdict import CONFOUNDED_VIF, VIF_LIMIT
from narrows.report.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, panels
from narrows.terms.term import TermTable

MARKERS = ("o", "^", "s", "D", "v", "P")
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, GREY, BLACK)


def symbols(terms: TermTable, names: tuple[str, ...]) -> list[str]:
    """Return coefficients in mathematical letters (ours).

    Parameters
    ----------
    terms : TermTable
        The terms.
    names : tuple of str
        Coefficients.
    """
    return [f"${terms[name].symbol}$" for name in names]


def correlation_figure(fit: Fit) -> Figure:
    """Draw the correlations between the columns of each force, with rank and condition (the paper's fig. corr).

    Parameters
    ----------
    fit : Fit
        Whose columns.
    """
    found = fit.diagnostics.overall
    figure, axes = panels(1, len(found), 3.3, width_ratios=[max(4, len(d.names)) for d in found.values()])
    image = None
    for panel, (force, diagnosis) in zip(axes[0], found.items(), strict=True):
        image = _matrix(panel, diagnosis, fit.terms)
        condition = f"{diagnosis.condition:.0f}" if np.isfinite(diagnosis.condition) else "∞"
        panel.set_title(f"{force}: rank {diagnosis.rank} of {len(diagnosis.names)},\ncondition {condition}", fontsize=8)
    if image is not None:
        figure.colorbar(image, ax=axes[0, -1], label="correlation [1]", shrink=0.7)
    return figure


def _matrix(panel, diagnosis: Diagnosis, terms: TermTable):  # type: ignore[no-untyped-def]
    values = diagnosis.correlation
    panel.set_facecolor("#DDDDDD")
    image = panel.imshow(values, cmap="PuOr", vmin=-1, vmax=1)
    for i, row in enumerate(values):
        for j, value in enumerate(row):
            text = f"{value:.2f}".replace("0.", ".") if np.isfinite(value) else "const."
            panel.text(j, i, text, ha="center", va="center", fontsize=5.5, color=_ink(value))
    labels = symbols(terms, diagnosis.names)
    panel.set_xticks(range(len(labels)), labels, rotation=90)
    panel.set_yticks(range(len(labels)), labels)
    return image


def _ink(value: float) -> str:
    return "white" if abs(value) > 0.7 else "black"


def inflation_figure(fit: Fit) -> Figure:
    """Draw the variance inflation of each coefficient, over all rows and within each speed.

    Parameters
    ----------
    fit : Fit
        Whose columns.
    """
    names = tuple(term.name for term in (*fit.terms.sway, *fit.terms.yaw))
    figure, axes = panels(1, 1, 3.2)
    panel = axes[0, 0]
    everywhere = {n: d.vif[n] for d in fit.diagnostics.overall.values() for n in d.names}
    panel.plot(range(len(names)), [_finite(everywhere[n]) for n in names], "k_", markersize=14, label="all rows")
    for i, (speed, found) in enumerate(fit.diagnostics.by_speed.items()):
        own = {n: d.vif[n] for d in found.values() for n in d.names}
        style = {"color": COLOURS[i % 6], "marker": MARKERS[i % 6], "linestyle": "none", "markersize": 5}
        panel.plot(range(len(names)), [_finite(own[n]) for n in names], label=f"{speed:.2f} m/s alone", **style)
    for limit, dashes in ((VIF_LIMIT, "--"), (CONFOUNDED_VIF, ":")):
        panel.axhline(limit, color=GREY, linestyle=dashes, linewidth=0.9)
    panel.set(yscale="log", ylabel="variance inflation [1]", xlabel="coefficient [-]")
    panel.set_xticks(range(len(names)), symbols(fit.terms, names))
    panel.grid(alpha=0.3, axis="y")
    panel.legend(frameon=False, ncols=4, loc="upper center", bbox_to_anchor=(0.5, 1.15))
    return figure


def _finite(value: float) -> float:
    return value if np.isfinite(value) else np.nan
