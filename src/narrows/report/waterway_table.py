"""A waterway in the terminal and as JSON: where it is narrow, where it is shallow, where it bends."""

import math
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from narrows.errors import InputError
from narrows.waterway import Waterway

STATIONS, SHOWN = 2001, 11
# Curvature [1/m] of no bend.
STRAIGHT = 1e-9


def waterway_summary(waterway: Waterway, draft: float = 0.0) -> dict[str, Any]:
    """Return what a waterway is like as plain values: metres, degrees."""
    # draft [m]
    s = np.linspace(0, waterway.line.length, STATIONS)
    here = waterway.room(s, draft)
    shut = ~(here.width > 0) | (here.depth <= draft)
    if shut.any():
        index = int(shut.argmax())
        size = f"{here.width[index]:.4g} m wide and {here.depth[index]:.4g} m deep"
        raise InputError(
            f"{waterway.name}: no room for a draft of {draft:g} m at {s[index]:.0f} m along it, {size}; mend its banks "
            "or depths there"
        )
    bend = np.abs(here.curvature)
    narrow, sharp = int(here.width.argmin()), int(bend.argmax())
    deep = bool(np.isfinite(here.depth).all())
    summary = {
        "name": waterway.name,
        "length": waterway.line.length,
        "narrowest": {"width": float(here.width[narrow]), "at": float(s[narrow])},
        "shallowest": {"depth": float(here.depth.min()), "at": float(s[int(here.depth.argmin())])} if deep else None,
        "sharpest": {"radius": float(1 / bend[sharp]), "at": float(s[sharp])} if bend[sharp] > STRAIGHT else None,
        "stations": _stations(waterway, draft),
    }
    return {**summary, "summary": _sentence(summary), "notes": []}


def _stations(waterway: Waterway, draft: float) -> list[dict[str, float]]:
    s = np.linspace(0, waterway.line.length, SHOWN)
    here, heading = waterway.room(s, draft), np.degrees(waterway.line.heading(s)) % 360
    columns = {
        "at": s, "heading": heading, "starboard": here.width / 2 + here.middle, "port": here.width / 2 - here.middle,
        "width": here.width, "depth": here.depth,
    }  # fmt: skip
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def print_waterway(waterway: Waterway, draft: float = 0.0) -> None:
    """Print a waterway: a row a station, and its worst places."""
    # draft [m]
    console, summary = Console(highlight=False, markup=False), waterway_summary(waterway, draft)
    table = Table(box=None, pad_edge=False)
    for head in ("at [m]", "heading [deg]", "to starboard [m]", "to port [m]", "width [m]", "depth [m]"):
        table.add_column(head, justify="right")
    for row in summary["stations"]:
        at, heading, *rest = row.values()
        table.add_row(
            f"{at:.0f}", f"{heading:.1f}", *(f"{value:.1f}" if math.isfinite(value) else "-" for value in rest)
        )
    console.print(table)
    console.print(summary["summary"])


def _sentence(summary: dict[str, Any]) -> str:
    narrowest = summary["narrowest"]
    return (
        f"{summary['name']}: {summary['length']:.0f} m long; narrowest {narrowest['width']:.1f} m at "
        f"{narrowest['at']:.0f} m"
        + _worst(summary["shallowest"], "depth", "shallowest")
        + _worst(summary["sharpest"], "radius", "sharpest bend, radius")
    )


def _worst(extreme: dict[str, float] | None, name: str, word: str) -> str:
    return "" if extreme is None else f"; {word} {extreme[name]:.4g} m at {extreme['at']:.0f} m"
