"""Tables and results in the terminal."""

import sys
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

from rich.console import Console
from rich.table import Table
from rich.text import Text

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


def table_of(
    heads: Iterable[str], rows: Iterable[Iterable[str | Text]], left: Iterable[str] = ("",), no_wrap: bool = False,
    **options: Any,
) -> Table:  # fmt: skip
    """Return a table without rules: columns under ``left`` are left-aligned, all others right-aligned."""
    table, words = Table(box=None, pad_edge=False, **options), set(left)
    for head in heads:
        table.add_column(head, justify="left" if head in words else "right", no_wrap=no_wrap)
    for row in rows:
        table.add_row(*row)
    return table


def titled_table(title: str, heads: Iterable[str], rows: Iterable[Iterable[str]], left: Iterable[str] = ("",)) -> Table:
    return table_of(heads, rows, left, title=title, title_justify="left", title_style="bold")


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
