"""Tables and results in the terminal."""

from collections.abc import Iterable
from typing import Any

from rich.console import Console
from rich.table import Table

# Characters: a narrower terminal wraps lines rather than losing digits.
WIDTH = 110


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
    for note in notes:
        console.print(f"- {note}", style="dim")
