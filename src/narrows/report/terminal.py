"""Tables and results in the terminal."""

import sys
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

from rich.console import Console
from rich.table import Table

Row = TypeVar("Row")

# Characters: a narrower terminal wraps lines rather than losing digits.
WIDTH = 110
# Rows of a table and notes that are shown without --verbose.
MOST_ROWS, MOST_NOTES = 9, 6


def console_of(least: int = 0) -> Console:
    """Return a console at least so many characters wide, however narrow the terminal is."""
    console = Console(highlight=False, markup=False)
    if least:
        console.width = max(console.width, least)
    return console


def table_of(
    heads: Iterable[str], rows: Iterable[Iterable[str]], left: Iterable[str] = ("",), no_wrap: bool = False,
    **options: Any,
) -> Table:  # fmt: skip
    """Return a table without rules: the columns under ``left`` begin at the left, all others end at the right."""
    table, words = Table(box=None, pad_edge=False, **options), set(left)
    for head in heads:
        table.add_column(head, justify="left" if head in words else "right", no_wrap=no_wrap)
    for row in rows:
        table.add_row(*row)
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
    """Whether all rows and notes are asked for: ``--verbose``, anywhere on the command line."""
    return "--verbose" in sys.argv


def thinned(rows: Sequence[Row]) -> list[Row]:
    """Return few rows, equally far apart, the first and the last among them where that can be; all with --verbose."""
    if everything() or len(rows) <= MOST_ROWS:
        return list(rows)
    step = next(step for step in range(2, len(rows)) if (len(rows) - 1) // step < MOST_ROWS)
    return list(rows[(len(rows) - 1) % step // 2 :: step])
