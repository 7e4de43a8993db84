"""The right column of the page of a safe envelope: a table by offset to pin up, and what the answer rests on."""

import textwrap

import numpy as np
from matplotlib.axes import Axes

from narrows.safety import SafeEnvelope

HEADS = ("offset\n[m]", "safe speeds\n[knots]", "held by one pilot;\none who knew", "rudder of 19\nin 20 [deg]",
         "what limits it")  # fmt: skip
WIDTHS = (0.1, 0.17, 0.25, 0.18, 0.3)
# Heights as shares of the column: the head of the table, a row of it, a line of small print.
HEAD, ROW, LINE = 0.055, 0.03, 0.0225
# Letters of table and notes [pt]: what can be read on paper.
SMALL = 7.2
# In a line of small print.
LETTERS = 72


def draw_column(axes: Axes, envelope: SafeEnvelope) -> None:
    """Lay out the table and the notes below it: as many rows as the notes leave room for, the middle among them."""
    axes.axis("off")
    notes = [line for note in envelope.notes for line in textwrap.wrap(note, LETTERS, subsequent_indent="  ")]
    _draw_table(axes, _cells(envelope, max(1, int((0.97 - HEAD - LINE * len(notes)) / ROW))))
    axes.text(0.0, 0.0, "\n".join(notes), fontsize=SMALL, va="bottom", transform=axes.transAxes)


def _cells(envelope: SafeEnvelope, most: int) -> list[list[str]]:
    rows = envelope.offset_rows()
    stride = -(-len(rows) // most)
    return [
        [f"{row['offset']:+.1f}", _span(row["lowest_speed"], row["highest_speed"]),
         f"{100 * row['held']:.0f} %; {100 * row['known']:.0f} %", _degrees(row["rudder_95"]), row["limited_by"]]
        for row in rows[(len(rows) // 2) % stride :: stride]
    ]  # fmt: skip


def _draw_table(axes: Axes, cells: list[list[str]]) -> None:
    table = axes.table(cells, colLabels=HEADS, loc="upper center", cellLoc="center", colWidths=WIDTHS)
    table.auto_set_font_size(False)
    table.set_fontsize(SMALL)
    for (row, _), cell in table.get_celld().items():
        cell.set_linewidth(0.3)
        cell.set_height(ROW if row else HEAD)


def _span(low: float, high: float) -> str:
    return f"{low:.1f} to {high:.1f}" if np.isfinite(low) and np.isfinite(high) else "-"


def _degrees(angle: float) -> str:
    return f"{angle:.0f}" if np.isfinite(angle) else "none"
