"""Sentences of NMEA 0183: found in lines, checked, decoded to the documented SI columns by pynmeagps and pyais."""

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, date, datetime, time
from enum import Enum
from functools import reduce
from operator import xor
from typing import Any, NamedTuple

from narrows.quantities.names import DEGREE, KNOT

# AIS message types with position and motion, all of one sentence (ITU-R M.1371).
AIS_POSITIONS = (1, 2, 3, 18)
NO_SPEED, NO_COURSE = 102.3, 360.0  # AIS values for "not available"; other such values lie beyond ``LARGEST``
# Largest valid numbers in sentences: larger ones are ignored.
LARGEST = {
    "longitude": 180.0, "latitude": 90.0, "heading": 360.0, "course_over_ground": 360.0, "speed_over_ground": 102.3,
    "r": 720.0, "rudder": 90.0, "revolutions": 6000.0, "u": 102.3, "v": 102.3, "u_ground": 102.3, "v_ground": 102.3,
    "wind_from": 360.0, "draft": 25.5, "depth": 1000.0,
}  # fmt: skip

Values = dict[str, float]
# Values by group (``SOURCES``): columns in SI.
GroupedValues = Mapping[str, Values]


class DecodedMessage(NamedTuple):
    values: GroupedValues  # Columns by group; empty if it has no value
    source: str  # Talker and type, as in ``GPGGA``
    clock: time | None = None  # Time of day, UTC
    day: date | None = None  # Date of that time


# Measured groups, and the types of sentences that give them, the best first.
SOURCES = {
    "position": ("GGA", "GNS", "RMC", "GLL", "VDO", "VDM"),
    "speed over ground": ("VTG", "RMC", "VDO", "VDM"),
    "heading": ("HDT", "THS", "HDG", "VDO", "VDM"),
    "yaw rate": ("ROT", "VDO", "VDM"),
    "rudder": ("RSA",),
    "revolutions": ("RPM",),
    "speed through the water": ("VBW", "VHW"),
    "speed over ground in the ship's axes": ("VBW",),
    "wind": ("MWD",),
}
# Groups that are not measured by a navigation sensor: the ship's draft, and the echo sounder's depth.
PARTICULARS, WATER_DEPTH = "particulars", "depth of water"


def decode_text(text: bytes, kind: str, mmsi: int | None = None) -> DecodedMessage | None:
    if kind.endswith(("VDO", "VDM")):
        return _ais(text, kind, mmsi) if text.split(b",", 2)[1] == b"1" else None
    if kind[2:] not in (*FIELDS, *READ, "ZDA"):
        return None
    from pynmeagps import NMEAReader

    message = NMEAReader.parse(text + b"\r\n")
    source = f"{kind} {message.source}{message.engineshaftnum}" if kind.endswith("RPM") else kind
    clock = getattr(message, "time", None)
    values = READ[kind[2:]](message) if kind[2:] in READ else _fields_of(message, kind[2:])
    day = getattr(message, "date", None)
    if kind.endswith("ZDA") and isinstance(message.year, int):
        day = date(message.year, message.month, message.day)
    of_day = clock if isinstance(clock, time) else None
    return DecodedMessage(values, source, of_day, day if isinstance(day, date) else None)


FIXES = (1, 2, 3, 4, 5, 9)  # Valid fix qualities of GGA: not 6 (dead reckoning), 7 (manual), 8 (simulator)
# Invalid mode letters of RMC, GLL, VTG and GNS: dead reckoning, manual, simulator, none.
NO_FIXES = "EMSN"
MOST_HDOP = 5.0  # [1] largest HDOP of a fix that is usable near a bank


def _only(**numbers: Any) -> Values:
    """Return the valid numbers: an empty field is an empty word, and parsers accept NaN."""
    return {
        name: float(value)
        for name, value in numbers.items()
        if isinstance(value, int | float) and abs(value) <= LARGEST.get(name, math.inf)
    }


def _times(factor: float, **numbers: Any) -> Values:
    return {name: factor * value for name, value in _only(**numbers).items()}


def _place(longitude: Any, latitude: Any) -> Values:
    values = _only(longitude=longitude, latitude=latitude)
    return values if len(values) == 2 else {}


PLACE = {"longitude": ("lon", 1.0), "latitude": ("lat", 1.0)}
# Groups by type of sentence: the field that says whether a group is valid, if any, and its columns, each with its field
# and the factor to SI. RSA: the starboard rudder, or the only one; negative if it turns the bow to port.
FIELDS: dict[str, dict[str, tuple[str, dict[str, tuple[str, float]]]]] = {
    "GGA": {"position": ("", PLACE)}, "GNS": {"position": ("", PLACE)}, "GLL": {"position": ("status", PLACE)},
    "RMC": {
        "position": ("status", PLACE),
        "speed over ground": (
            "status", {"speed_over_ground": ("spd", KNOT), "course_over_ground": ("cog", DEGREE)},
        ),
    },
    "VTG": {
        "speed over ground": ("", {"speed_over_ground": ("sogn", KNOT), "course_over_ground": ("cogt", DEGREE)}),
    },
    "HDT": {"heading": ("", {"heading": ("headingT", DEGREE)})},
    "THS": {"heading": ("mi", {"heading": ("headt", DEGREE)})},
    "ROT": {"yaw rate": ("valid", {"r": ("rot", DEGREE / 60)})},
    "RSA": {"rudder": ("stbdstatus", {"rudder": ("stbdangle", DEGREE)})},
    "RPM": {"revolutions": ("status", {"revolutions": ("rpm", 1 / 60)})},
    "VHW": {"speed through the water": ("", {"u": ("spdN", KNOT)})},
    "VBW": {
        "speed through the water": ("waterspdstatus", {"u": ("longwaterspd", KNOT), "v": ("transwaterspd", KNOT)}),
        "speed over ground in the ship's axes": (
            "groundspdstatus", {"u_ground": ("longgroundspd", KNOT), "v_ground": ("transgroundspd", KNOT)},
        ),
    },
}  # fmt: skip


def _fields_of(message: Any, kind: str) -> GroupedValues:
    values: dict[str, Values] = {}
    for group, (status, columns) in FIELDS.get(kind, {}).items() if _is_fix(message) else ():
        if getattr(message, status, "A") == "A":
            known = _only(**{name: getattr(message, field) for name, (field, _) in columns.items()})
            if group != "position" or len(known) == 2:
                values[group] = {name: columns[name][1] * value for name, value in known.items()}
    return values


def _is_fix(message: Any) -> bool:
    """Return whether a position is measured, with a good satellite geometry; true if a sentence does not say."""
    hdop = getattr(message, "HDOP", None)
    is_sharp = not isinstance(hdop, int | float) or hdop <= MOST_HDOP
    is_measured = bool(str(getattr(message, "posMode", None) or "A").strip(NO_FIXES))
    return is_sharp and is_measured and getattr(message, "quality", FIXES[0]) in FIXES


def _hdg(message: Any) -> GroupedValues:
    """Return true heading if the variation is given too."""
    if not isinstance(message.variation, int | float):
        return {}
    parts = ((message.variation, message.variationEW), (message.deviation, message.deviationEW))
    shift = sum(-value if side == "W" else value for value, side in parts if isinstance(value, int | float))
    return {"heading": _times(DEGREE, heading=(message.headingM + shift) % 360)}


def _dpt(message: Any) -> GroupedValues:
    """Depth of water if the transducer's offset refers to the surface, clearance if it refers to the keel."""
    values = _only(depth=message.depth, offset=message.offset)
    if len(values) < 2 or values["depth"] < 0 or not values["offset"]:
        return {}
    of_all = values["offset"] > 0
    return {WATER_DEPTH: {"depth" if of_all else "under_keel_clearance": values["depth"] + values["offset"]}}


def _mwd(message: Any) -> GroupedValues:
    speed = _only(wind_speed=message.speedM) or _times(KNOT, wind_speed=message.speedN)
    return {"wind": speed | _times(DEGREE, wind_from=message.dirT)}


READ = {"HDG": _hdg, "DPT": _dpt, "MWD": _mwd}


def _ais(text: bytes, kind: str, mmsi: int | None) -> DecodedMessage | None:
    """The ship's own reports, or those of one ship received from others."""
    import pyais

    message = pyais.decode(text)
    wanted = kind.endswith("VDO") if mmsi is None else message.mmsi == mmsi
    is_report = wanted and message.msg_type in AIS_POSITIONS
    return DecodedMessage(_position_report(message.asdict()) if is_report else {}, f"{kind} {message.mmsi}")


def _position_report(report: Mapping[str, Any]) -> GroupedValues:
    turn = report.get("turn")
    speed, course = report["speed"], report["course"]
    return {
        "position": _place(report["lon"], report["lat"]),
        "speed over ground": ({} if speed >= NO_SPEED else _times(KNOT, speed_over_ground=speed))
        | ({} if course >= NO_COURSE else _times(DEGREE, course_over_ground=course)),
        "heading": _times(DEGREE, heading=report["heading"]),
        # Codes beyond all numbers give the direction of a turn without its rate.
        "yaw rate": {} if isinstance(turn, Enum) else _times(DEGREE / 60, r=turn),
    }


SENTENCE = re.compile(rb"[$!]([A-Z][A-Z0-9]{4,}),([^*$!\r\n]*)(\*[0-9A-Fa-f]{2})?")
# A block before the sentence with the logger's time [s] or [ms] since 1970.
TAG = re.compile(rb"\\(?:[^\\]*,)?c:(\d{10,13})(?:[,*][^\\]*)?\\")
ISO = re.compile(rb"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d+)?)(Z|[+-]\d\d:?\d\d)?")
EPOCH = re.compile(rb"(?<![\d.])(1\d{9}(?:\.\d+)?)(?![\d.])")
REMARK = b"#"
MILLISECONDS = 1e11  # Larger times since 1970 are in milliseconds


class Sentence(NamedTuple):
    """One sentence with a valid checksum."""

    text: bytes  # Characters from ``$`` or ``!`` to the checksum
    kind: str  # Talker and type, as in ``GPGGA``
    logged: float | None  # Logger's time since 1970, if given [s]


def sentences(lines: Iterable[bytes], faults: Counter[str]) -> Iterator[Sentence]:
    for line in lines:
        if line.startswith(REMARK):
            continue
        begin = 0
        for match in SENTENCE.finditer(line):
            if match[3] is None:
                faults["without a checksum"] += 1
            elif int(match[3][1:], 16) != checksum(match[0][1:-3]):
                faults["with a wrong checksum"] += 1
            else:
                yield Sentence(match[0], match[1].decode("ascii"), _logged(line[begin : match.start()]))
            begin = match.end()
        if not begin and line.strip():
            faults["that are no sentence"] += 1


def checksum(body: bytes) -> int:
    """Return the checksum of the text between ``$`` and ``*`` (IEC 61162-1)."""
    return reduce(xor, body, 0)


def with_checksum(body: str) -> str:
    return f"${body}*{checksum(body.encode('ascii')):02X}\r\n"


def _logged(before: bytes) -> float | None:
    if match := TAG.search(before) or EPOCH.search(before):
        time = float(match[1])
        return time / 1e3 if time > MILLISECONDS else time
    if match := ISO.search(before):
        when = datetime.fromisoformat(match[1].decode().replace(",", ".") + (match[2] or b"Z").decode())
        return when.astimezone(UTC).timestamp()
    return None
