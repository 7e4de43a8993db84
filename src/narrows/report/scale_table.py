"""A model at two scales, side by side."""

from rich.console import Console
from rich.table import Table

from narrows.model.froude import Scaled


def print_scaled(scaled: Scaled) -> None:
    """Print a model at two scales and what does not go with it."""
    console, shown = Console(highlight=False, markup=False), scaled.to_dict()
    table = Table(box=None, pad_edge=False)
    for header in ("", "was", "is", "unit", "bis [1]"):
        table.add_column(header, justify="left" if header in ("", "unit") else "right", no_wrap=True)
    for name, row in shown["coefficients"].items():
        table.add_row(name, f"{row['old']:.4g}", f"{row['new']:.4g}", row["unit"], f"{shown['bis'][name]:.4g}")
    console.print(table)
    console.print(shown["summary"])
    for note in scaled.notes:
        console.print(f"- {note}")
