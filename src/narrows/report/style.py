"""Style of figures: panels, titles and notes."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from textwrap import wrap
from typing import Any, cast

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.base.errors import InputError

FORCE_LABELS = {"X": "surge force X [N]", "Y": "sway force Y [N]", "N": "yaw moment N [N m]"}
FONT: dict[Any, Any] = {"font.size": 9.0, "axes.titlesize": 9.0, "legend.fontsize": 8.0, "axes.spines.top": False,
        "axes.spines.right": False, "svg.fonttype": "path", "svg.hashsalt": "narrows"}  # fmt: skip

# Characters in a line of small print across a figure.
CHARACTERS = 125
# Characters per inch of a title.
LETTERS_AN_INCH = 14.2
# Width of a page's figure [in].
WIDTH = 7.2


class Picture(Figure):
    """A figure that notebooks show with or without pyplot (IPython shows Matplotlib's own only with it)."""

    def _repr_png_(self) -> bytes:
        memory = BytesIO()
        self.savefig(memory, format="png")
        return memory.getvalue()

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of its first axes, such as ``set_title``."""
        if name[0] == "_" or not hasattr(Axes, name) or not self.axes:
            raise AttributeError(f"a figure has no {name!r}")
        return getattr(self.axes[0], name)


# Axes of the caller, on which ``panels`` draws.
GIVEN: ContextVar[Axes | None] = ContextVar("given axes", default=None)


@contextmanager
def drawing_on(axes: Axes | None) -> Iterator[None]:
    token = GIVEN.set(axes)
    try:
        yield
    finally:
        GIVEN.reset(token)


def titled(axes: Axes, sentences: Iterable[str]) -> None:
    letters = int(LETTERS_AN_INCH * axes.bbox.width / axes.figure.dpi)
    lines = [line for sentence in sentences for line in wrap(sentence, letters)]
    axes.set_title("\n".join(lines), fontsize=8, loc="left")


def panels(
    rows: int, columns: int, height: float, grid: str = "both", width: float = WIDTH, **options: Any
) -> tuple[Figure, Any]:
    """Make a figure and its axes, (rows, columns), with a grid for values of x, y, both or none."""
    if (given := GIVEN.get()) is not None:
        if rows * columns > 1:
            raise InputError(f"this picture has {rows * columns} panels, which one ax cannot hold; leave ax out")
        figure, axes = cast(Figure, given.figure), np.array([[given]])
    else:
        with rc_context(FONT):
            figure = Picture(figsize=(width, height), layout="constrained")
            axes = figure.subplots(rows, columns, squeeze=False, **options)
    for panel in axes.flat if grid else ():
        panel.grid(alpha=0.3, axis=grid)
    return figure, axes


def legend_below(figure: Figure, handles: Iterable[Any], columns: int = 3) -> None:
    figure.legend(handles=[*handles], loc="outside lower center", ncols=columns, frameon=False, fontsize=7)


def headed(figure: Figure, title: str, lines: Iterable[str] = ()) -> None:
    """Write a bold title at the upper left of a figure, and a subtitle below."""
    look: dict[str, Any] = {"x": 0.01, "ha": "left", "va": "top", "fontsize": 9.0, "linespacing": 1.25}
    letters = int(LETTERS_AN_INCH * figure.get_figwidth())
    bold = wrap(title, int(0.88 * letters))
    words = [part for line in lines for part in wrap(line, letters)]
    figure.suptitle("\n".join([*(" " for _ in bold), *words]), **look)
    layout = figure.get_layout_engine()
    above = layout.get()["h_pad"] if layout else 0.0
    figure.text(y=1 - above / figure.get_figheight(), s="\n".join(bold), weight="bold", **look)


def notes_below(figure: Figure, notes: Iterable[str]) -> None:
    lines = [line for note in notes for line in wrap(note, CHARACTERS)]
    if lines:
        figure.supxlabel("\n".join(lines), fontsize=7, x=0.01, ha="left")
