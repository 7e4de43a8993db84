"""Sentences of NMEA 0183: found in lines, checked, decoded to the documented SI columns by pynmeagps and pyais."""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import UTC, date, datetime, time
from enum import Enum
from functools import reduce
from operator import xor
from typing import Any, NamedTuple

from narrows.quantities.names import KNOT
from narrows.readers.headers import DEGREE

# AIS message types with position and motion, and with the ship's loading (ITU-R M.1371).
AIS_POSITIONS, AIS_VOYAGE = (1, 2, 3, 18), 5
# AIS values for "not available"; other such values lie beyond ``LARGEST``.
NO_SPEED, NO_COURSE = 102.3, 360.0
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


def decode_parts(parts: Sequence[bytes], kind: str, mmsi: int | None = None) -> DecodedMessage | None:
    if kind.endswith(("VDO", "VDM")):
        return _ais(parts, kind, mmsi)
    read = READ.get(kind[2:])
    if read is None:
        return None
    from pynmeagps import NMEAReader

    message = NMEAReader.parse(parts[0] + b"\r\n")
    source = f"{kind} {message.source}{message.engineshaftnum}" if kind.endswith("RPM") else kind
    clock = getattr(message, "time", None)
    return DecodedMessage(read(message), source, clock if isinstance(clock, time) else None, _day(message, kind))


def _day(message: Any, kind: str) -> date | None:
    if kind.endswith("ZDA") and isinstance(message.year, int):
        return date(message.year, message.month, message.day)
    day = getattr(message, "date", None)
    return day if isinstance(day, date) else None


Reader = Callable[[Any], GroupedValues]

# Valid fix qualities of GGA: not 6 (dead reckoning), 7 (manual), 8 (simulator).
FIXES = (1, 2, 3, 4, 5, 9)
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


def _scaled(values: Values, factor: float) -> Values:
    return {name: factor * value for name, value in values.items()}


def _fix(message: Any) -> Values:
    return _place(message.lon, message.lat)


def _place(longitude: Any, latitude: Any) -> Values:
    values = _only(longitude=longitude, latitude=latitude)
    return values if len(values) == 2 else {}


def _gga(message: Any) -> GroupedValues:
    return {"position": _fix(message)} if message.quality in FIXES and _is_sharp(message) else {}


def _is_sharp(message: Any) -> bool:
    """Return whether the satellite geometry is good; true if unknown."""
    hdop = getattr(message, "HDOP", None)
    return not isinstance(hdop, int | float) or hdop <= MOST_HDOP


def _is_fix(message: Any) -> bool:
    return bool(str(getattr(message, "posMode", None) or "A").strip(NO_FIXES))


def _gns(message: Any) -> GroupedValues:
    return {"position": _fix(message)} if _is_fix(message) and _is_sharp(message) else {}


def _gll(message: Any) -> GroupedValues:
    return {"position": _fix(message)} if message.status == "A" and _is_fix(message) else {}


def _rmc(message: Any) -> GroupedValues:
    if message.status != "A" or not _is_fix(message):
        return {}
    ground = _scaled(_only(speed_over_ground=message.spd), KNOT)
    return {"position": _fix(message), "speed over ground": ground | _course(message.cog)}


def _course(degrees: Any) -> Values:
    return _scaled(_only(course_over_ground=degrees), DEGREE)


def _vtg(message: Any) -> GroupedValues:
    if not _is_fix(message):
        return {}
    ground = _scaled(_only(speed_over_ground=message.sogn), KNOT)
    return {"speed over ground": ground | _course(message.cogt)}


def _hdt(message: Any) -> GroupedValues:
    return {"heading": _scaled(_only(heading=message.headingT), DEGREE)}


def _ths(message: Any) -> GroupedValues:
    return {"heading": _scaled(_only(heading=message.headt), DEGREE)} if message.mi == "A" else {}


def _hdg(message: Any) -> GroupedValues:
    """Return true heading if the variation is given too."""
    if not isinstance(message.variation, int | float):
        return {}
    parts = ((message.variation, message.variationEW), (message.deviation, message.deviationEW))
    shift = sum(-value if side == "W" else value for value, side in parts if isinstance(value, int | float))
    return {"heading": _scaled(_only(heading=(message.headingM + shift) % 360), DEGREE)}


def _rot(message: Any) -> GroupedValues:
    return {"yaw rate": _scaled(_only(r=message.rot), DEGREE / 60)} if message.valid == "A" else {}


def _rsa(message: Any) -> GroupedValues:
    """Angle of the starboard rudder, or the only one; negative if it turns the bow to port, as here."""
    valid = message.stbdstatus == "A"
    return {"rudder": _scaled(_only(rudder=message.stbdangle), DEGREE)} if valid else {}


def _rpm(message: Any) -> GroupedValues:
    return {"revolutions": _scaled(_only(revolutions=message.rpm), 1 / 60)} if message.status == "A" else {}


def _vhw(message: Any) -> GroupedValues:
    return {"speed through the water": _scaled(_only(u=message.spdN), KNOT)}


def _vbw(message: Any) -> GroupedValues:
    water = _scaled(_only(u=message.longwaterspd, v=message.transwaterspd), KNOT)
    ground = _scaled(_only(u_ground=message.longgroundspd, v_ground=message.transgroundspd), KNOT)
    return {
        "speed through the water": water if message.waterspdstatus == "A" else {},
        "speed over ground in the ship's axes": ground if message.groundspdstatus == "A" else {},
    }


def _dpt(message: Any) -> GroupedValues:
    """Depth of water if the transducer's offset refers to the surface, clearance if it refers to the keel."""
    values = _only(depth=message.depth, offset=message.offset)
    if len(values) < 2 or values["depth"] < 0 or not values["offset"]:
        return {}
    of_all = values["offset"] > 0
    return {WATER_DEPTH: {"depth" if of_all else "under_keel_clearance": values["depth"] + values["offset"]}}


def _mwd(message: Any) -> GroupedValues:
    speed = _only(wind_speed=message.speedM) or _scaled(_only(wind_speed=message.speedN), KNOT)
    return {"wind": speed | _scaled(_only(wind_from=message.dirT), DEGREE)}


# By type.
READ: Mapping[str, Reader] = {
    "GGA": _gga, "GNS": _gns, "GLL": _gll, "RMC": _rmc, "VTG": _vtg, "HDT": _hdt, "THS": _ths, "HDG": _hdg,
    "ROT": _rot, "RSA": _rsa, "RPM": _rpm, "VHW": _vhw, "VBW": _vbw, "DPT": _dpt, "MWD": _mwd,
    "ZDA": lambda message: {},
}  # fmt: skip


def _ais(parts: Sequence[bytes], kind: str, mmsi: int | None) -> DecodedMessage | None:
    """The ship's own reports, or those of one ship received from others."""
    import pyais

    message = pyais.decode(*parts)
    wanted = kind.endswith("VDO") if mmsi is None else message.mmsi == mmsi
    values = _of_ais(message.msg_type, message.asdict()) if wanted else {}
    return DecodedMessage(values, f"{kind} {message.mmsi}")


def _of_ais(kind: int, report: Mapping[str, Any]) -> GroupedValues:
    if kind == AIS_VOYAGE:
        return {PARTICULARS: _only(draft=report["draught"] or None)}  # 0 means not available
    return _position_report(report) if kind in AIS_POSITIONS else {}


def _position_report(report: Mapping[str, Any]) -> GroupedValues:
    turn = report.get("turn")
    speed, course = report["speed"], report["course"]
    return {
        "position": _place(report["lon"], report["lat"]),
        "speed over ground": ({} if speed >= NO_SPEED else _scaled(_only(speed_over_ground=speed), KNOT))
        | ({} if course >= NO_COURSE else _course(course)),
        "heading": _scaled(_only(heading=report["heading"]), DEGREE),
        # Codes beyond all numbers give the direction of a turn without its rate.
        "yaw rate": {} if isinstance(turn, Enum) else _scaled(_only(r=turn), DEGREE / 60),
    }


SENTENCE = re.compile(rb"[$!]([A-Z][A-Z0-9]{4,}),([^*$!\r\n]*)(\*[0-9A-Fa-f]{2})?")
# A block before the sentence with the logger's time [s] or [ms] since 1970.
TAG = re.compile(rb"\\(?:[^\\]*,)?c:(\d{10,13})(?:[,*][^\\]*)?\\")
ISO = re.compile(rb"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d+)?)(Z|[+-]\d\d:?\d\d)?")
EPOCH = re.compile(rb"(?<![\d.])(1\d{9}(?:\.\d+)?)(?![\d.])")
REMARK = b"#"
# Larger times since 1970 are in milliseconds.
MILLISECONDS = 1e11


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
