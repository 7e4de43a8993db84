"""How a ship's own log is to be understood: names, units and signs of columns, lateness, the antenna, the loading."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from narrows.errors import InputError, did_you_mean, shown
from narrows.logbook.reading.log_columns import QUANTITIES
from narrows.readers.mapping import ColumnMapping
from narrows.ship.ship_file import load_toml

OF_COLUMNS = ("columns", "units", "positive")
ANTENNA = ("forward", "starboard")


@dataclass(frozen=True)
class LogMapping:
    """How a ship's log is to be understood."""

    columns: ColumnMapping = field(default_factory=ColumnMapping)  # Names, units and signs
    # By how much a column was reported later than it was measured [s]
    late: Mapping[str, float] = field(default_factory=dict)
    antenna: tuple[float, float] = (0.0, 0.0)  # Of the position: forward and to starboard of midship [m]
    condition: Mapping[str, float] = field(default_factory=dict)  # Of the loading, as in ``{"draft": 10.2}``

    def __post_init__(self) -> None:
        for name in self.late:
            if name not in QUANTITIES:
                raise InputError(f"late: there is no column {name!r}{did_you_mean(str(name), QUANTITIES)}")
        _check_numbers("late", self.late)
        _check_numbers("condition", self.condition)
        if len(self.antenna) != len(ANTENNA):
            raise InputError(f"an antenna = {shown(self.antenna)} is no place; give metres forward and to starboard")
        _check_numbers("antenna", dict(zip(ANTENNA, self.antenna, strict=True)))


def log_mapping(
    mapping: str | Path | Mapping[str, Any] | None, units: Mapping[str, str] | None = None,
    late: Mapping[str, float] | None = None, antenna: tuple[float, float] | None = None,
    condition: Mapping[str, float] | None = None,
) -> LogMapping:  # fmt: skip
    """Read how a log is to be understood; what is given beside a file goes before what is in it."""
    # mapping [columns]; late [s]; antenna [m]
    tables, name = _tables(mapping)
    parts = {section: tables.get(section, {}) for section in OF_COLUMNS}
    columns = ColumnMapping(**{**parts, "units": {**parts["units"], **(units or {})}}, name=name)
    return LogMapping(
        columns,
        {**tables.get("late", {}), **(late or {})},
        _antenna(tables.get("antenna", {}), name) if antenna is None else antenna,
        {**tables.get("condition", {}), **(condition or {})},
    )


def _tables(mapping: str | Path | Mapping[str, Any] | None) -> tuple[Mapping[str, Any], str]:
    tables = {} if mapping is None else mapping if isinstance(mapping, Mapping) else load_toml(mapping)
    name = Path(mapping).name if isinstance(mapping, str | Path) else "the mapping"
    sections = (*OF_COLUMNS, *(own.name for own in fields(LogMapping)[1:]))
    for section, table in tables.items():
        if section not in sections:
            raise InputError(f"{name}: unknown section [{section}]{did_you_mean(str(section), sections)}")
        if not isinstance(table, Mapping):
            raise InputError(f"{name}: {section} = {shown(table)} is no section; write [{section}] and keys below it")
    return tables, name


def _antenna(table: Mapping[str, float], name: str) -> tuple[float, float]:
    for key in table:
        if key not in ANTENNA:
            raise InputError(f"{name}: [antenna] has no {key!r}{did_you_mean(str(key), ANTENNA)}")
    return table.get("forward", 0.0), table.get("starboard", 0.0)


def _check_numbers(what: str, values: Mapping[str, object]) -> None:
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise InputError(f"{what}: {name} = {shown(value)} is no number; give one")
