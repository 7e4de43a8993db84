"""How pictures look: colours that the colour-blind tell apart, lines that survive a grey print."""

from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, PURPLE, BLACK, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#6B6B6B"
"""Okabe and Ito's."""
DASHES = ("-", "--", ":", "-.")
HATCHES = ("", "///", "...")
FORCE_LABELS = {"X": "surge force X [N]", "Y": "sway force Y [N]", "N": "yaw moment N [N m]"}
FONT: dict[Any, Any] = {"font.size": 9.0, "axes.titlesize": 9.0, "legend.fontsize": 8.0, "axes.spines.top": False,
        "axes.spines.right": False, "svg.fonttype": "path", "svg.hashsalt": "narrows"}  # fmt: skip
WIDTH = 7.2
"""Of a page's picture [in]."""


def panels(rows: int, columns: int, height: float, **options: Any) -> tuple[Figure, Any]:
    """Make a figure of the page's width and its axes, (rows, columns) (ours).

    Parameters
    ----------
    rows, columns : int
        Of panels.
    height : float [in]
        Of the figure.
    **options : Any
        As for Matplotlib's ``subplots``.
    """
    with rc_context(FONT):
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        return figure, figure.subplots(rows, columns, squeeze=False, **options)


def svg(figure: Figure) -> str:
    """Return a figure as SVG to set into a page (ours).

    Parameters
    ----------
    figure : Figure
        The picture.
    """
    from io import StringIO

    memory = StringIO()
    with rc_context(FONT):
        figure.savefig(memory, format="svg", metadata={"Date": None})
    text = memory.getvalue()
    return text[text.index("<svg") :]
