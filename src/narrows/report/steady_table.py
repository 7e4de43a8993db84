"""Steady legs in the terminal: what they taught, what that changes of the safe envelope, and a plan of them."""

import math

from rich.console import Console
from rich.table import Table

from narrows.logbook import EnvelopeChange, SteadyFit, SteadyPlan
from narrows.report.learned_table import LEARNED_HEADS, learned_rows


def print_steady_fit(fit: SteadyFit, change: EnvelopeChange | None = None) -> None:
    """Print what steady legs taught."""
    console = Console(highlight=False, markup=False)
    console.width = max(console.width, 110)
    console.print(fit.summary())
    table = Table(box=None, pad_edge=False)
    for head in (*LEARNED_HEADS, "what the legs say"):
        table.add_column(head, justify="right" if head in LEARNED_HEADS[1:4] else "left")
    for row in learned_rows(fit.coefficients):
        table.add_row(*row)
    console.print(table)
    if change is not None:
        print_change(change, console)
    for note in fit.notes:
        console.print(f"- {note}", style="dim")


def print_change(change: EnvelopeChange, console: Console | None = None) -> None:
    """Print what a record changes of the safe envelope."""
    console = console or Console(highlight=False, markup=False)
    speed = change.rows()[0]["speed"]
    title = (
        f"The safe envelope: rudder that holds the ship (9 cases of 10 between) and cases held, at {speed:.1f} knots"
    )
    table = Table(box=None, pad_edge=False, title=title, title_justify="left", title_style="bold")
    for head in CHANGE_HEADS:
        table.add_column(head, justify="right")
    for row in change_rows(change):
        table.add_row(*row)
    console.print(table)
    console.print(change.summary())


CHANGE_HEADS = (
    "offset [m]", "rudder before [deg]", "after [deg]", "held before", "after", "safe to, before [kn]", "after [kn]",
)  # fmt: skip


def change_rows(change: EnvelopeChange) -> list[tuple[str, ...]]:
    """Return what a table says of the envelope at each offset, by the model whether it was tested there or not."""
    return [
        (f"{row['offset']:+.3g}", _band(row, "before"), _band(row, "after"), f"{100 * row['held_before']:.0f} %",
         f"{100 * row['held_after']:.0f} %", _knots(row["highest_speed_before"]), _knots(row["highest_speed_after"]))
        for row in change.rows()
    ]  # fmt: skip


def print_steady_plan(plan: SteadyPlan) -> None:
    """Print a plan of steady legs."""
    console = Console(highlight=False, markup=False)
    console.width = max(console.width, 110)
    console.print(plan.summary())
    if plan.legs:
        table = Table(box=None, pad_edge=False)
        heads = ("leg", "offset [m]", "speed [kn]", "rudder to expect [deg]", "drift to expect [deg]")
        for head in (*heads, *(f"std {name} then" for name in plan.targets)):
            table.add_column(head, justify="right")
        for number, row in enumerate(plan.rows(), start=1):
            table.add_row(
                str(number), f"{row['offset']:+g}", f"{row['speed']:g}",
                f"{_degrees(row['rudder_low'])} to {_degrees(row['rudder_high'])}",
                f"{_degrees(row['drift_low'], 1)} to {_degrees(row['drift_high'], 1)}",
                *(f"{row[f'std {name}']:.2g}" for name in plan.targets),
            )  # fmt: skip
        console.print(table)
    for note in plan.notes:
        console.print(f"- {note}", style="dim")


def _band(row: dict[str, float], when: str) -> str:
    low, high = row[f"rudder_low_{when}"], row[f"rudder_high_{when}"]
    return f"{_degrees(low, 1)} to {_degrees(high, 1)}"


def _degrees(angle: float, digits: int = 0) -> str:
    return f"{angle:+.{digits}f}" if math.isfinite(angle) else "none"


def _knots(speed: float) -> str:
    return f"{speed:.1f}" if math.isfinite(speed) else "nowhere"
