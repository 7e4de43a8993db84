"""Draft of ``columns.toml`` for a table whose headers are not all recognised: from words, units and numbers."""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.captive import settings
from narrows.captive.check import RATES, rates_of
from narrows.captive.columns import COLUMNS, begun, meant
from narrows.captive.tests import LABELS
from narrows.quantities.dimensions import unit_named
from narrows.quantities.names import FORCES
from narrows.readers.cells import floats, parse_header, split_header
from narrows.readers.mapping import COUNTED, WAYS

_quoted = partial(json.dumps, ensure_ascii=False)
# Units that headers leave out, besides SI.
UNITS = {"m": ("mm",), "rad": ("deg",), "rad/s": ("deg/s",), "rad/s2": ("deg/s2",), "s": ("ms",), "m/s": ("kn",)}


class DraftEntry(NamedTuple):
    header: str  # Text in the table
    unit: str  # Its unit; empty if it has none
    way: str  # Direction in which it counts, if not the documented one
    reason: str  # Origin of the entry
    sure: bool


@dataclass
class Draft:
    """Entries of a mapping by documented name, and the headers without one."""

    entries: dict[str, DraftEntry] = field(default_factory=dict)
    unread: list[str] = field(default_factory=list)
    columns: dict[str, np.ndarray] = field(default_factory=dict)  # Columns known so far, in SI

    def add(self, name: str, entry: DraftEntry, values: np.ndarray) -> None:
        self.unread.remove(entry.header)
        self.entries[name] = entry
        if name not in LABELS:
            self.columns[name] = values * _scale(name, entry.unit) * (-1.0 if entry.way else 1.0)

    def toml(self, table: str, command: str) -> str:
        lines = [
            f"# Columns of {table}, drafted. Check the lines with GUESSED, then type:",
            f"#   {command}",
            "# With true here, narrows identify reads it for every table of this folder.",
            "confirmed = false",
        ]
        columns = [(name, entry.header, entry) for name, entry in self.entries.items()]
        units = [(name, entry.unit, entry) for name, _, entry in columns if entry.unit != split_header(entry.header)[1]]
        ways = [(name, entry.way, entry) for name, _, entry in columns if entry.way]
        for section, rows in {"columns": columns, "units": units, "positive": ways}.items():
            lines += ["", f"[{section}]"] if rows else []
            lines += [
                f"{name} = {_quoted(word)}  # {'sure' if entry.sure else 'GUESSED'}: {' '.join(entry.reason.split())}"
                for name, word, entry in rows
            ]
            if section == "columns":
                lines += [f"# not used: {_quoted(header)}" for header in self.unread]
        return "\n".join([*lines, ""])


def draft_columns(frame: pd.DataFrame) -> Draft:
    """Return a draft of the columns of a table of tests."""
    draft = Draft(unread=[str(header) for header in frame.columns])
    for header in list(draft.unread):
        unit = split_header(header)[1]
        known = parse_header(header, COLUMNS) if not unit or unit_named(unit) is not None else None
        if known:
            draft.columns[known.quantity] = floats(frame[header]) * known.scale
        if known or header in LABELS:
            draft.unread.remove(header)
    # Angles without a unit last: the other columns may determine it.
    for header, name, unit, sure in sorted(_by_words(draft.unread), key=lambda found: _is_angle(*found[1:3])):
        if name not in draft.columns and name not in draft.entries:
            entry = DraftEntry(header, unit if _scale(name, unit) else "", "", f"{header!r} is {name}", sure)
            values = floats(frame[header])
            draft.add(name, _with_unit(name, entry, values, draft), values)
    while len(frame) >= settings.FEWEST_SCREENED and any(_by_motion(draft, frame, header) for header in draft.unread):
        pass
    return draft


def _by_words(headers: list[str]) -> Iterator[tuple[str, str, str, bool]]:
    """Headers, documented names and units; first synonyms, then guesses: each word begins one of a synonym."""
    for sure in (True, False):
        for header in headers:
            name, unit = meant(header)
            if bool(name) is sure and (name := name or begun(header)):
                yield header, name, unit or _unit_of(header), sure


def _is_angle(name: str, unit: str) -> bool:
    return name not in LABELS and not unit and COLUMNS[name].unit.startswith("rad")


def _with_unit(name: str, entry: DraftEntry, values: np.ndarray, draft: Draft) -> DraftEntry:
    """Return the entry with the unit of an angle that has none, by the other columns or by its size."""
    most = float(np.nanmax(np.abs(values), initial=0.0))
    if not _is_angle(name, entry.unit) or not most:
        return entry
    if np.isfinite(values).all() and (alike := _moving_alike(name, entry.header, values, draft)):
        return alike._replace(reason=f"{entry.reason}; {alike.reason}", sure=entry.sure)
    large, si = most > math.pi / 2, COLUMNS[name].unit
    unit, remark = (UNITS[si][0], "too large for radians") if large else (si, "degrees or radians?")
    return entry._replace(unit=unit, sure=entry.sure and large, reason=f"{entry.reason}; up to {most:.3g}, {remark}")


def _by_motion(draft: Draft, frame: pd.DataFrame, header: str) -> bool:
    """Add a column that agrees with the motion of the others; return whether it does."""
    values = floats(frame[header])
    if not np.isfinite(values).all() or np.ptp(values) == 0:
        return False
    for name in (name for name in COLUMNS if name not in draft.columns):
        if entry := _moving_alike(name, header, values, draft):
            draft.add(name, entry, values)
            return True
    return False


def _moving_alike(name: str, header: str, values: np.ndarray, draft: Draft) -> DraftEntry | None:
    """The unit and direction in which a column agrees with the changes or the rate of others, if any."""
    si, unit = COLUMNS[name].unit, _unit_of(header)
    if "t" not in draft.columns or name in FORCES or (unit and not _scale(name, unit)):
        return None
    found: list[tuple[float, str, float]] = []
    for choice in (unit,) if unit else (si, *UNITS.get(si, ())):
        for sign in (1.0, -1.0) if name in COUNTED else (1.0,):
            trial = draft.columns | {name: sign * _scale(name, choice) * values}
            found += [(away, choice, sign) for away in _disagreements(name, trial)]
    away, choice, sign = min(found, default=(1.0, "", 1.0))
    if away > settings.FAINT_SHARE:
        return None
    way = WAYS[COUNTED[name][0]] if sign < 0 else ""
    return DraftEntry(header, choice, way, f"it agrees with the other columns to {away:.1%}", False)


def _disagreements(name: str, columns: dict[str, np.ndarray]) -> Iterator[float]:
    """Disagreement of a column with each of its relations, relative to its own part in them."""
    steps = np.diff(columns["t"])
    inside = (steps > 0) & (steps <= settings.ROW_GAP * (np.median(steps) if steps.size else 0.0))
    if not inside.any():
        return
    without = rates_of({**columns, name: 0 * columns[name]})
    for column, rate in rates_of(columns).items():
        part = rate if column == name else rate - without[column]
        own = float(np.sqrt(np.mean(part[inside] ** 2)))
        if own > 0 and (column == name or (name in RATES[column] and column != "x")):  # The signs of x are free
            with np.errstate(all="ignore"):
                away = (np.diff(columns[column]) / steps - rate)[inside]
            yield float(np.sqrt(np.mean(away**2))) / own


def _unit_of(header: str) -> str:
    return unit if (unit := split_header(header)[1]) and unit_named(unit) else ""


def _scale(name: str, unit: str) -> float:
    """Factor to SI [1]; 0 for a unit of another quantity."""
    if not unit or name in LABELS:
        return 1.0
    given, wanted = unit_named(unit), unit_named(COLUMNS[name].unit)
    return given.scale if given and wanted and given.powers == wanted.powers else 0.0
