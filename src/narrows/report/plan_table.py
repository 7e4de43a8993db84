"""A plan of tests in the terminal."""

from typing import Any

from rich.console import Console
from rich.table import Table

from narrows.experiment_design.plan import UNITS, Plan

# Characters; a narrow terminal wraps lines rather than losing digits.
COLUMN = 14
SHOWN = ("kind", "offset", "amplitude", "period", "speed", "drift_deg", "depth")


def print_plan(plan: Plan) -> None:
    """Print a plan: a row a run, and the gain."""
    rows = plan.rows()
    names = [name for name in SHOWN if any(row.get(name) is not None for row in rows)]
    console = Console(highlight=False, markup=False)
    console.width = max(console.width, COLUMN * (1 + len(names) + len(plan.targets)))
    table = Table(box=None, pad_edge=False)
    for name in ("run", *names, *(f"std {target}" for target in plan.targets)):
        unit = f" [{UNITS[name]}]" if name in UNITS else ""
        table.add_column(name.removesuffix("_deg") + unit, justify="right")
    for number, row in enumerate(rows, start=1):
        errors = [f"{row[f'std {target}']:.2g}" for target in plan.targets]
        table.add_row(str(number), *(_cell(row.get(name)) for name in names), *errors)
    console.print(table)
    console.print(f"Chosen of {plan.considered} runs; the standard errors are those after each run.")
    for sentence in (*plan.summary().splitlines(), *plan.notes):
        console.print(f"- {sentence}")


def _cell(value: Any) -> str:
    return "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
