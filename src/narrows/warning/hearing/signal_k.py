"""Signal K deltas: JSON with paths, in SI already.

References
----------
Signal K specification 1.7: delta format, keys of the schema.
"""

import json
import math
import re
from collections import Counter
from collections.abc import Iterator
from typing import Any

from narrows.readers.nmea.nmea_sentences import PARTICULARS, Telling, Tellings, Values

TURN = 2 * math.pi
# More than any ship's speed [m/s].
FASTEST = 60.0
# By path: what it is about, the column, and the largest number that it can be.
PATHS = {
    "navigation.headingTrue": ("heading", "heading", TURN),
    "navigation.rateOfTurn": ("yaw rate", "r", 1.0),
    "navigation.speedThroughWater": ("speed through the water", "u", FASTEST),
    "navigation.speedOverGround": ("speed over ground", "speed_over_ground", FASTEST),
    "navigation.courseOverGroundTrue": ("speed over ground", "course_over_ground", TURN),
    "steering.rudderAngle": ("rudder", "rudder", TURN / 4),
    "propulsion.revolutions": ("revolutions", "revolutions", 100.0),
    "design.draft.current": (PARTICULARS, "draft", 50.0),
}
POSITION = "navigation.position"
PLACES = {"longitude": 180.0, "latitude": 90.0}
ENGINE = re.compile(r"^propulsion\.[^.]+\.")
SELF = "vessels.self"
SOURCE = "signalk"


def deltas(text: bytes, faults: Counter[str]) -> Iterator[Telling]:
    """Yield what a message tells of the ship itself."""
    try:
        message = json.loads(text)
        if message.get("context", SELF) != SELF:
            return
        for update in message.get("updates", ()):  # A server's first words have none.
            told = _told(update.get("values", ()))
            if any(told.values()):
                yield Telling(told, f"{SOURCE} {update.get('$source', '')}".strip())
    except (ValueError, TypeError, AttributeError, KeyError, RecursionError):
        faults["of Signal K that cannot be understood"] += 1


def _told(values: Any) -> Tellings:
    told: dict[str, Values] = {}
    for each in values:
        path, value = ENGINE.sub("propulsion.", each["path"]), each["value"]
        if path == POSITION:
            told["position"] = _position(value)
        elif path in PATHS:
            about, column, largest = PATHS[path]
            if _can_be(value, largest):
                told.setdefault(about, {})[column] = float(value)
    return told


def _position(value: Any) -> Values:
    known = isinstance(value, dict) and all(_can_be(value.get(name), most) for name, most in PLACES.items())
    return {name: float(value[name]) for name in PLACES} if known else {}


def _can_be(value: Any, largest: float) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= largest
