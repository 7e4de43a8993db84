"""The safe envelope in the terminal."""

import math

from rich.console import Console
from rich.table import Table

from narrows.report.rules_view import rules_table
from narrows.safety import SafeEnvelope


def print_envelope(envelope: SafeEnvelope) -> None:
    """Print the tables that a pilot reads: by offset, and by speed."""
    console = Console(highlight=False, markup=False)
    console.width = max(console.width, 130)
    console.print(envelope.summary())
    console.print(f"{envelope.description}; {envelope.weather}; {envelope.samples} cases tried at each place.")
    console.print(_by_offset(envelope))
    console.print()
    console.print(_by_speed(envelope))
    console.print("\nRules from outside, for comparison (* not all of its numbers were read by us):")
    console.print(rules_table(envelope.rules))
    for note in (*envelope.notes, *envelope.rules.notes):
        console.print(f"- {note}", style="dim")


def _by_offset(envelope: SafeEnvelope) -> Table:
    table = Table(box=None, pad_edge=False)
    for head in (
        "offset [m]",
        "rudder [deg]",
        "19 of 20 within [deg]",
        "held",
        "by one who knows it",
        "safe [kn]",
        "if it were known [kn]",
        "in half the cases [kn]",
    ):
        table.add_column(head, justify="right")
    table.add_column("limited by", no_wrap=True)
    for row in envelope.offset_rows():
        table.add_row(
            f"{row['offset']:+.1f}", _cell(row["rudder"], "+.1f"), _cell(row["rudder_95"], ".1f"),
            f"{100 * row['held']:.0f} %", f"{100 * row['known']:.0f} %",
            _span(row["lowest_speed"], row["highest_speed"]), _cell(row["highest_speed_known"], ".1f"),
            _cell(row["highest_speed_median"], ".1f"), row["limited_by"],
        )  # fmt: skip
    return table


def _by_speed(envelope: SafeEnvelope) -> Table:
    table = Table(box=None, pad_edge=False)
    for head in ("speed [kn]", "under the keel [m]", "safest offset [m]"):
        table.add_column(head, justify="right")
    for row in envelope.speed_rows():
        under = _cell(row["keel_clearance"], ".2f") + ("" if row["keel_clear"] else " !")
        table.add_row(f"{row['speed']:.1f}", under, _cell(row["safest_offset"], "+.1f"))
    return table


def _span(low: float, high: float) -> str:
    return f"{low:.1f} to {high:.1f}" if math.isfinite(low) and math.isfinite(high) else "-"


def _cell(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else "-"
