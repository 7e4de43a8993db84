"""Tables and results in the terminal."""

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from string import Formatter
from typing import Any, TypeVar

from rich.console import Console
from rich.table import Table

Row = TypeVar("Row")

# Least width [characters]: a narrower terminal wraps lines rather than losing digits.
WIDTH = 110
# Rows of a table and notes shown without --verbose.
MOST_ROWS, MOST_NOTES = 9, 6


def console_of(least: int = 0) -> Console:
    """Return a console with a least width in characters, however narrow the terminal is."""
    console = Console(highlight=False, markup=False)
    if least:
        console.width = max(console.width, least)
    return console


class _CellFormatter(Formatter):
    def format_field(self, value: Any, form: str) -> str:
        if value is None:
            return ""
        if isinstance(value, list | tuple):
            return ", ".join(self.format_field(one, form) for one in value)
        if isinstance(value, float) and not math.isfinite(value):
            return "-"
        return f"{100 * value:{form[:-1]}f} %" if form.endswith("%") else format(value, form)


def cells_of(columns: Mapping[str, str], rows: Iterable[Mapping[Any, Any]]) -> list[list[str]]:
    """Return the cells of rows; columns give the format of each head, ``{y:+.1f}``: ``-`` where it is not finite."""
    cells = _CellFormatter()
    return [[cells.vformat(form, (), row).replace("- to -", "-") for form in columns.values()] for row in rows]


def table_of(
    columns: Mapping[str, str], rows: Iterable[Mapping[Any, Any]], left: Iterable[str] = ("",), no_wrap: bool = False,
    **options: Any,
) -> Table:  # fmt: skip
    """Return a table without rules: columns under ``left`` are left-aligned, all others right-aligned."""
    table = Table(box=None, pad_edge=False, title_justify="left", title_style="bold", **options)
    for head in columns:
        table.add_column(head, justify="left" if head in left else "right", no_wrap=no_wrap)
    rows = list(rows)
    for row, cells in zip(rows, cells_of(columns, rows), strict=True):
        table.add_row(*cells, style=row.get("style"))
    return table


def print_result(result: Any, *tables: Table | None) -> None:
    """Print the summary of a result, tables, and its notes."""
    console = console_of(WIDTH)
    console.print(result.summary())
    for table in filter(None, tables):
        console.print(table)
    print_notes(console, result.notes)


def print_notes(console: Console, notes: Iterable[str]) -> None:
    every = list(dict.fromkeys(notes))
    shown = every if everything() else every[:MOST_NOTES]
    for note in shown:
        console.print(f"- {note}", style="dim")
    if len(shown) < len(every):
        console.print(f"- {len(every) - len(shown)} more notes: add --verbose", style="dim")


def everything() -> bool:
    """Return whether all rows and notes are requested: ``--verbose``, anywhere on the command line."""
    return "--verbose" in sys.argv


def thinned(rows: Sequence[Row]) -> list[Row]:
    """Return few rows, equally spaced, with the first and the last if possible; all with --verbose."""
    if everything() or len(rows) <= MOST_ROWS:
        return list(rows)
    step = next(step for step in range(2, len(rows)) if (len(rows) - 1) // step < MOST_ROWS)
    return list(rows[(len(rows) - 1) % step // 2 :: step])
