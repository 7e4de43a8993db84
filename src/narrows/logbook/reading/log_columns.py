"""What columns a table of a ship's own records may have, beside the signals that come of them."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import pandas as pd

from narrows.errors import InputError, did_you_mean, shown
from narrows.logbook.ship_record import SIGNALS
from narrows.quantities.names import KNOT, Quantity
from narrows.readers.headers import DEGREE, Vocabulary
from narrows.readers.mapping import ColumnMapping
from narrows.ship.ship_file import load_toml

# What is told by the map, and is brought to the axes of the waterway or of the record.
ON_EARTH = {
    "longitude": Quantity("deg", "longitude of the antenna, WGS84"),
    "latitude": Quantity("deg", "latitude of the antenna, WGS84"),
    "east": Quantity("m", "antenna east of the origin of the map"),
    "north": Quantity("m", "antenna north of the origin of the map"),
    "heading": Quantity("rad", "heading, clockwise from true north"),
    "course_over_ground": Quantity("rad", "course over ground, clockwise from true north"),
    "east_rate": Quantity("m/s", "velocity over ground to the east"),
    "north_rate": Quantity("m/s", "velocity over ground to the north"),
    "wind_from": Quantity("rad", "where the wind comes from, clockwise from true north"),
}

IN_FIXED_AXES = {
    "x_rate": Quantity("m/s", "velocity over ground along the axis of x"),
    "y_rate": Quantity("m/s", "velocity over ground along the axis of y"),
}

FROM_THE_SHIP = {
    "apparent_wind_speed": Quantity("m/s", "speed of the wind as felt on board"),
    "apparent_wind_angle": Quantity("rad", "where it comes from, clockwise from the bow"),
}

QUANTITIES = {"t": Quantity("s", "time"), **SIGNALS, **ON_EARTH, **IN_FIXED_AXES, **FROM_THE_SHIP}

# Columns of words: the manoeuvre or transit; date and time where there is no ``t``.
LABELS = ("record", "time")

VOCABULARY = Vocabulary(QUANTITIES, LABELS, blanks=True)

# What logs often call a column, in any case of letters; units stand in the header as ever.
ALIASES = {
    "test": "record", "run": "record", "timestamp": "time", "datetime": "time", "utc": "time",
    "lat": "latitude", "lon": "longitude", "lng": "longitude", "hdg": "heading", "hdt": "heading",
    "sog": "speed_over_ground", "cog": "course_over_ground", "rot": "r", "stw": "u",
}  # fmt: skip

# Numbers by which AIS says that it has none (ITU-R M.1371), as they stand and in SI.
ABSENT = {
    "longitude": (181.0,), "latitude": (91.0,), "heading": (511.0, 511.0 * DEGREE),
    "course_over_ground": (360.0, 360.0 * DEGREE), "speed_over_ground": (102.3, 102.3 * KNOT),
    "r": (-128.0, -128.0 * DEGREE / 60),
}  # fmt: skip


def renamed(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose columns of usual other names have the documented ones."""
    headers = [str(header) for header in frame.columns]
    return frame.rename(columns={old: new for old in headers if (new := _documented(old)) and new not in headers})


def _documented(header: str) -> str | None:
    match = re.fullmatch(r"([A-Za-z]+)(\s*[\[(].*[\])]|_[a-z]+)?", header.strip())
    name = ALIASES.get(match[1].lower()) if match else None
    return None if match is None or name is None else name + (match[2] or "")


# How a ship's own log is to be understood: names, units and signs of columns, lateness, the antenna, the loading.
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
