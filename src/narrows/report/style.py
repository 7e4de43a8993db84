"""How pictures look: colours that the colour-blind tell apart, lines that survive a grey print."""

from collections.abc import Iterable
from io import BytesIO
from textwrap import fill
from typing import Any, NamedTuple

from matplotlib import rc_context
from matplotlib.figure import Figure

from narrows.model.model import UNSETTLED

BLUE, ORANGE, GREEN, PURPLE, BLACK, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#6B6B6B"
"""Okabe and Ito's."""
DASHES = ("-", "--", ":", "-.")
HATCHES = ("", "///", "...")
FORCE_LABELS = {"X": "surge force X [N]", "Y": "sway force Y [N]", "N": "yaw moment N [N m]"}
FONT: dict[Any, Any] = {"font.size": 9.0, "axes.titlesize": 9.0, "legend.fontsize": 8.0, "axes.spines.top": False,
        "axes.spines.right": False, "svg.fonttype": "path", "svg.hashsalt": "narrows"}  # fmt: skip
CHARACTERS = 125
"""In a line of small print across a picture."""
WIDTH = 7.2
"""Of a page's picture [in]."""


class Picture(Figure):
    """A figure that a notebook shows whether pyplot was loaded or not (IPython draws Matplotlib's own only then)."""

    def _repr_png_(self) -> bytes:
        memory = BytesIO()
        self.savefig(memory, format="png")
        return memory.getvalue()


class Margins(NamedTuple):
    """Room around panels and between them.

    Parameters
    ----------
    left, right, bottom, top : float [in]
        Around all of them.
    across, down : float [in]
        Between neighbours.
    """

    left: float = 0.75
    right: float = 0.15
    bottom: float = 0.5
    top: float = 0.2
    across: float = 0.5
    down: float = 0.15


def panels(
    rows: int, columns: int, height: float, margins: Margins | None = None, **options: Any
) -> tuple[Figure, Any]:
    """Make a figure of the page's width and its axes, (rows, columns) (ours).

    Parameters
    ----------
    rows, columns : int
        Of panels.
    height : float [in]
        Of the figure.
    margins : Margins, optional
        Room for labels; measured by drawing everything once more unless given, which takes as long as drawing.
    **options : Any
        As for Matplotlib's ``subplots``.
    """
    with rc_context(FONT):
        figure = Picture(figsize=(WIDTH, height), layout=None if margins else "constrained")
        axes = figure.subplots(rows, columns, squeeze=False, **options)
    if margins:
        left, right, bottom, top, across, down = margins
        wide, high = WIDTH - left - right, height - bottom - top
        figure.subplots_adjust(
            left / WIDTH, bottom / height, 1 - right / WIDTH, 1 - top / height,
            wspace=across / ((wide - (columns - 1) * across) / columns),
            hspace=down / ((high - (rows - 1) * down) / rows),
        )  # fmt: skip
    return figure, axes


def trust_below(figure: Figure, notes: Iterable[str]) -> None:
    """Write what the model's tests do not settle of the banks below a picture (ours).

    Parameters
    ----------
    figure : Figure
        The picture.
    notes : iterable of str
        Of what it shows.
    """
    for note in notes:
        if note.startswith(UNSETTLED):
            figure.supxlabel(fill(note, CHARACTERS), fontsize=7)


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
