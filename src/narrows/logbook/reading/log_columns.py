"""What columns a table of a ship's own records may have, beside the signals that come of them."""

import re

import pandas as pd

from narrows.logbook.signals import SIGNALS
from narrows.quantities.constants import KNOT
from narrows.quantities.names import Quantity
from narrows.readers.headers import DEGREE, Vocabulary

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
