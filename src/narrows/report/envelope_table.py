"""The safe envelope in the terminal, as JSON and as rows."""

import math
from typing import Any

from rich.console import Console
from rich.table import Table

from narrows.quantities.constants import KNOT
from narrows.safety import MEDIAN, SafeEnvelope


def offset_rows(envelope: SafeEnvelope) -> list[dict[str, Any]]:
    """Return a row an offset: rudder, highest safe speed, what limits it (ours).

    Parameters
    ----------
    envelope : SafeEnvelope
        The answer.
    """
    data, top, likely = envelope.data, envelope.highest_speed(), envelope.highest_speed(MEDIAN)
    bottom = envelope.lowest_speed()
    rows = []
    for place, (y, why) in enumerate(zip(data["y"].to_numpy().tolist(), envelope.limited_by(), strict=True)):
        best, even = float(top[place]), float(likely[place])
        at = best if math.isfinite(best) else even if math.isfinite(even) else float(data["u"][0])
        here = data.isel(y=place).sel(u=at)
        rows.append(
            {
                "offset": y,
                "rudder": math.degrees(here["rudder"]),
                "rudder_95": math.degrees(here["rudder_95"]),
                "held": float(here["held"]),
                "lowest_speed": float(bottom[place]) / KNOT,
                "highest_speed": best / KNOT,
                "highest_speed_median": even / KNOT,
                "limited_by": why,
            }
        )
    return rows


def speed_rows(envelope: SafeEnvelope) -> list[dict[str, Any]]:
    """Return a row a speed: clearance under the keel, and the safest offset (ours).

    Parameters
    ----------
    envelope : SafeEnvelope
        The answer.
    """
    data, best = envelope.data, envelope.safest_offset()
    return [
        {
            "speed": float(u) / KNOT,
            "keel_clearance": float(data["clearance"][place]),
            "keel_clear": bool(data["clear"][place]),
            "safest_offset": float(best[place]),
        }
        for place, u in enumerate(data["u"].to_numpy())
    ]


def envelope_summary(envelope: SafeEnvelope) -> dict[str, Any]:
    """Return the whole answer as plain values: metres, knots, degrees (ours).

    Parameters
    ----------
    envelope : SafeEnvelope
        The answer.
    """
    return {
        "setting": envelope.description,
        "offsets": offset_rows(envelope),
        "speeds": speed_rows(envelope),
        "notes": list(envelope.notes),
        "summary": envelope.says,
    }


def print_envelope(envelope: SafeEnvelope) -> None:
    """Print the tables that a pilot reads: by offset, and by speed.

    Parameters
    ----------
    envelope : SafeEnvelope
        The answer.
    """
    console = Console(highlight=False)
    console.width = max(console.width, 110)
    console.print(envelope.description)
    console.print(_by_offset(envelope))
    console.print()
    console.print(_by_speed(envelope))
    for note in envelope.notes:
        console.print(f"- {note}", style="dim")
    console.print(envelope.says)


def _by_offset(envelope: SafeEnvelope) -> Table:
    table = Table(box=None, pad_edge=False)
    for head in (
        "offset \\[m]",
        "rudder \\[deg]",
        "95 % within \\[deg]",
        "held",
        "safe to \\[kn]",
        "at even odds \\[kn]",
    ):
        table.add_column(head, justify="right")
    table.add_column("limited by")
    for row in offset_rows(envelope):
        table.add_row(
            f"{row['offset']:+.1f}", _cell(row["rudder"], "+.1f"), _cell(row["rudder_95"], ".1f"),
            f"{100 * row['held']:.0f} %", _span(row["lowest_speed"], row["highest_speed"]),
            _cell(row["highest_speed_median"], ".1f"), row["limited_by"],
        )  # fmt: skip
    return table


def _by_speed(envelope: SafeEnvelope) -> Table:
    table = Table(box=None, pad_edge=False)
    for head in ("speed \\[kn]", "under the keel \\[m]", "safest offset \\[m]"):
        table.add_column(head, justify="right")
    for row in speed_rows(envelope):
        under = _cell(row["keel_clearance"], ".2f") + ("" if row["keel_clear"] else " !")
        table.add_row(f"{row['speed']:.1f}", under, _cell(row["safest_offset"], "+.1f"))
    return table


def _span(low: float, high: float) -> str:
    return f"{low:.1f} to {high:.1f}" if math.isfinite(low) and math.isfinite(high) else "-"


def _cell(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else "-"
