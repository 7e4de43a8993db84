"""What a log taught, in the terminal."""

from collections.abc import Mapping

from rich.console import Console
from rich.table import Table

from narrows.logbook import LogFit
from narrows.report.learned_table import LEARNED_HEADS, learned_rows, with_truth


def print_log_fit(fit: LogFit, truth: Mapping[str, float] | None = None) -> None:
    """Print what a log taught."""
    console = Console(highlight=False, markup=False)
    console.width = max(console.width, 110)
    console.print(fit.summary())
    table = Table(box=None, pad_edge=False)
    for head in (*LEARNED_HEADS, "what the log says", *(("truth",) if truth else ())):
        table.add_column(head, justify="right" if head in (*LEARNED_HEADS[1:4], "truth") else "left")
    for row in with_truth(learned_rows(fit.coefficients), truth):
        table.add_row(*row)
    console.print(table)
    for note in fit.notes:
        console.print(f"- {note}", style="dim")
