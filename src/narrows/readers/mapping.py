"""A laboratory's own names, units and signs, converted to the documented columns."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import pandas as pd

from narrows.base.errors import InputError, did_you_mean, shown
from narrows.readers import cells
from narrows.readers.cells import Vocabulary, quantity_of, split_header
from narrows.ship.ship_file import check_table, load_toml

# Positive direction of a quantity here, and the opposite.
WAYS = {"forward": "aft", "starboard": "port", "down": "up", "clockwise": "counter-clockwise"}
# Positive direction of each quantity here; a rudder by the side to which it turns the bow.
COUNTED = {
    **dict.fromkeys(("x", "u", "udot", "X", "u_ground", "x_rate"), ("forward",)),
    **dict.fromkeys(("y", "v", "vdot", "Y", "v_ground", "y_rate"), ("starboard",)),
    **dict.fromkeys(("psi", "r", "rdot", "N", "course"), ("starboard", "clockwise")),
    "rudder": ("starboard",),
    "heave": ("down",),
}

CONFIRMED = "confirmed"  # Key of a drafted file, true once its lines are checked


@dataclass(frozen=True)
class ColumnMapping:
    # Headers of the table by the documented names; empty to ignore a column of that name
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)  # Units of columns whose headers lack them
    # Positive direction of a column: ``port``, ``aft``, ``up``, ``counter-clockwise`` reverse its sign
    positive: Mapping[str, str] = field(default_factory=dict)
    name: str = "the mapping"  # Name of the file

    def __post_init__(self) -> None:
        for section in fields(self)[:3]:
            values = getattr(self, section.name)
            check_table(section.name, values, self.name)
            for name, word in values.items():
                if not isinstance(word, str):
                    raise InputError(f"{self.name}: [{section.name}] {name} = {shown(word)} is no word; quote it")
        for name, way in self.positive.items():
            _sign(name, way, self.name)

    def applied(self, frame: pd.DataFrame, table: str, vocabulary: Vocabulary) -> tuple[pd.DataFrame, tuple[str, ...]]:
        headers = {str(header): quantity_of(str(header), vocabulary) for header in frame.columns}
        sources = self._sources(headers, table, vocabulary)
        notes: list[str] = []
        new: dict[str, Any] = {}
        for name, header in sources.items():
            unit, way = self.units.get(name) or split_header(header)[1], self.positive.get(name)
            head = f"{name} [{unit}]" if unit and name not in vocabulary.labels else name
            new[head] = frame[header]
            notes.append(f"{name} is {header!r}")
            if way and _sign(name, way, self.name) < 0:
                new[head] = -cells.numbers(frame, header, table, vocabulary.blanks)
                notes[-1] += f", its sign turned as it counts {'to ' * (way in ('port', 'starboard'))}{way}"
        others = [
            header for header, quantity in headers.items()
            # An ignored column must not be read under its own name.
            if header not in sources.values() and quantity not in sources and self.columns.get(quantity) != ""
        ]  # fmt: skip
        note = (f"by {self.name}: {'; '.join(notes)}",) if notes else ()
        return pd.concat([frame[others], pd.DataFrame(new, index=frame.index)], axis="columns"), note

    def _sources(self, headers: Mapping[str, str], table: str, vocabulary: Vocabulary) -> dict[str, str]:
        known = (*vocabulary.quantities, *vocabulary.labels)
        sources = {}
        for name in dict.fromkeys([*self.columns, *self.units, *self.positive]):
            if name not in known:
                raise InputError(f"{self.name}: {name!r} is no documented column{did_you_mean(name, known)}")
            if self.columns.get(name) != "":
                sources[name] = self._header(name, headers, table)
        twice = [header for header in sources.values() if list(sources.values()).count(header) > 1]
        if twice:
            names = " and ".join(name for name, header in sources.items() if header == twice[0])
            raise InputError(f"{self.name}: {twice[0]!r} is read as {names}; give it one name")
        return sources

    def _header(self, name: str, headers: Mapping[str, str], table: str) -> str:
        asked = self.columns.get(name)
        # A row of units may have been appended to the name.
        matching = [
            header for header, quantity in headers.items()
            if (quantity == name if asked is None else asked.strip() in (header, split_header(header)[0]))
        ]  # fmt: skip
        if not matching:
            raise InputError(
                f"{table}: no column is headed {asked or name!r}, which {self.name} reads as {name}"
                f"{did_you_mean(asked or name, headers)}"
            )
        return min(matching, key=len)


def read_mapping(mapping: str | Path | Mapping[str, Any] | ColumnMapping | None) -> ColumnMapping | None:
    if mapping is None or isinstance(mapping, ColumnMapping):
        return mapping
    tables = mapping if isinstance(mapping, Mapping) else load_toml(mapping)
    name = "the mapping" if isinstance(mapping, Mapping) else Path(mapping).name
    sections = [section.name for section in fields(ColumnMapping)][:3]
    for section in tables:
        if section not in (*sections, CONFIRMED):
            raise InputError(f"{name}: unknown section [{section}]{did_you_mean(str(section), sections)}")
    return ColumnMapping(**{section: tables[section] for section in sections if section in tables}, name=name)


def _sign(name: str, way: str, table: str) -> float:
    straight = COUNTED.get(name, ())
    signs = dict.fromkeys(straight, 1.0) | {WAYS[one]: -1.0 for one in straight}
    if way not in signs:
        raise InputError(
            f"{table}: [positive] {name} = {way!r} is no direction of it; it has {', '.join(sorted(signs)) or 'none'}"
        )
    return signs[way]
