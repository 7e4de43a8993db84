"""What sentences of NMEA 0183 tell, by the kept parsers pynmeagps and pyais, in SI and the documented columns."""

from collections.abc import Callable, Mapping
from datetime import date, time
from enum import Enum
from typing import Any, NamedTuple

from narrows.quantities.constants import KNOT
from narrows.readers.headers import DEGREE

SPEEDS = {"N": KNOT, "K": 1 / 3.6, "M": 1.0, "S": 1609.344 / 3600}
"""Of the wind, by the letter of its unit."""
AIS_POSITIONS = (1, 2, 3, 18)
"""Types of AIS messages that say where a ship is and how it moves (ITU-R M.1371)."""
NO_LONGITUDE, NO_LATITUDE, NO_SPEED, NO_COURSE, NO_HEADING = 181.0, 91.0, 102.3, 360.0, 511
"""By which AIS says that it has none."""

Values = dict[str, float]
Tellings = Mapping[str, Values]
"""By what it is about (``SOURCES``): columns in SI."""


class Telling(NamedTuple):
    """What one sentence tells.

    Parameters
    ----------
    values : dict of str to dict of str to float
        By what it is about: columns, none where it has nothing to tell.
    source : str
        Who tells it, as in ``GPGGA``.
    clock : time, optional
        Of the day, UTC.
    day : date, optional
        Of that.
    """

    values: Tellings
    source: str
    clock: time | None = None
    day: date | None = None


SOURCES = {
    "position": ("GGA", "GNS", "RMC", "GLL", "VDO", "VDM"),
    "speed over ground": ("VTG", "RMC", "VDO", "VDM"),
    "heading": ("HDT", "THS", "HDG", "VDO", "VDM"),
    "yaw rate": ("ROT", "VDO", "VDM"),
    "rudder": ("RSA",),
    "revolutions": ("RPM",),
    "speed through the water": ("VBW", "VHW"),
    "speed over ground in the ship's axes": ("VBW",),
    "wind as felt on board": ("MWV",),
    "wind": ("MWD",),
}
"""What is told, and by which types of sentences, the best first."""


def told_by(text: bytes, kind: str, mmsi: int | None = None) -> Telling | None:
    """Return what a sentence tells; None where it is of a type that tells nothing here (ours).

    Parameters
    ----------
    text : bytes
        The sentence.
    kind : str
        Its talker and type.
    mmsi : int, optional
        Whose AIS reports to read; those of the ship itself unless given.
    """
    if kind.endswith(("VDO", "VDM")):
        return _ais(text, kind, mmsi)
    read = READ.get(kind[2:])
    if read is None:
        return None
    from pynmeagps import NMEAReader

    message = NMEAReader.parse(text + b"\r\n")
    source = f"{kind} {message.source}{message.engineshaftnum}" if kind.endswith("RPM") else kind
    clock = getattr(message, "time", None)
    return Telling(read(message), source, clock if isinstance(clock, time) else None, _day(message, kind))


def _day(message: Any, kind: str) -> date | None:
    if kind.endswith("ZDA") and isinstance(message.year, int):
        return date(message.year, message.month, message.day)
    day = getattr(message, "date", None)
    return day if isinstance(day, date) else None


Reader = Callable[[Any], Tellings]


def _only(**numbers: Any) -> Values:
    """Those that are numbers: an empty field is a word without letters."""
    return {name: float(value) for name, value in numbers.items() if isinstance(value, int | float)}


def _scaled(values: Values, factor: float) -> Values:
    return {name: factor * value for name, value in values.items()}


def _fix(message: Any) -> Values:
    return _only(longitude=message.lon, latitude=message.lat)


def _gga(message: Any) -> Tellings:
    return {"position": _fix(message)} if message.quality else {}


def _gns(message: Any) -> Tellings:
    return {"position": _fix(message)} if message.posMode.strip("N") else {}


def _gll(message: Any) -> Tellings:
    return {"position": _fix(message)} if message.status == "A" else {}


def _rmc(message: Any) -> Tellings:
    if message.status != "A":
        return {}
    ground = _scaled(_only(speed_over_ground=message.spd), KNOT)
    return {"position": _fix(message), "speed over ground": ground | _course(message.cog)}


def _course(degrees: Any) -> Values:
    return _scaled(_only(course_over_ground=degrees), DEGREE)


def _vtg(message: Any) -> Tellings:
    ground = _scaled(_only(speed_over_ground=message.sogn), KNOT)
    return {"speed over ground": ground | _course(message.cogt)}


def _hdt(message: Any) -> Tellings:
    return {"heading": _scaled(_only(heading=message.headingT), DEGREE)}


def _ths(message: Any) -> Tellings:
    return {"heading": _scaled(_only(heading=message.headt), DEGREE)} if message.mi == "A" else {}


def _hdg(message: Any) -> Tellings:
    """True where the variation is told too."""
    if not isinstance(message.variation, int | float):
        return {}
    parts = ((message.variation, message.variationEW), (message.deviation, message.deviationEW))
    shift = sum(-value if side == "W" else value for value, side in parts if isinstance(value, int | float))
    return {"heading": _scaled(_only(heading=message.headingM + shift), DEGREE)}


def _rot(message: Any) -> Tellings:
    return {"yaw rate": _scaled(_only(r=message.rot), DEGREE / 60)} if message.valid == "A" else {}


def _rsa(message: Any) -> Tellings:
    """Of the starboard rudder, or the only one; negative where the bow turns to port, as here."""
    told = message.stbdstatus == "A"
    return {"rudder": _scaled(_only(rudder=message.stbdangle), DEGREE)} if told else {}


def _rpm(message: Any) -> Tellings:
    return {"revolutions": _scaled(_only(revolutions=message.rpm), 1 / 60)} if message.status == "A" else {}


def _vhw(message: Any) -> Tellings:
    return {"speed through the water": _scaled(_only(u=message.spdN), KNOT)}


def _vbw(message: Any) -> Tellings:
    water = _scaled(_only(u=message.longwaterspd, v=message.transwaterspd), KNOT)
    ground = _scaled(_only(u_ground=message.longgroundspd, v_ground=message.transgroundspd), KNOT)
    return {
        "speed through the water": water if message.waterspdstatus == "A" else {},
        "speed over ground in the ship's axes": ground if message.groundspdstatus == "A" else {},
    }


def _mwv(message: Any) -> Tellings:
    if message.status != "A" or message.reference != "R" or message.speedu not in SPEEDS:
        return {}
    speed = _scaled(_only(apparent_wind_speed=message.speed), SPEEDS[message.speedu])
    return {"wind as felt on board": speed | _scaled(_only(apparent_wind_angle=message.angle), DEGREE)}


def _mwd(message: Any) -> Tellings:
    speed = _only(wind_speed=message.speedM) or _scaled(_only(wind_speed=message.speedN), KNOT)
    return {"wind": speed | _scaled(_only(wind_from=message.dirT), DEGREE)}


READ: Mapping[str, Reader] = {
    "GGA": _gga, "GNS": _gns, "GLL": _gll, "RMC": _rmc, "VTG": _vtg, "HDT": _hdt, "THS": _ths, "HDG": _hdg,
    "ROT": _rot, "RSA": _rsa, "RPM": _rpm, "VHW": _vhw, "VBW": _vbw, "MWV": _mwv, "MWD": _mwd,
    "ZDA": lambda message: {},
}  # fmt: skip
"""By type."""


def _ais(text: bytes, kind: str, mmsi: int | None) -> Telling | None:
    """The ship's own reports, or those of one ship that others heard."""
    if text.split(b",", 2)[1] != b"1":  # Positions take one sentence.
        return None
    import pyais

    message = pyais.decode(text)
    wanted = kind.endswith("VDO") if mmsi is None else message.mmsi == mmsi
    told = _of_ais(message.asdict()) if wanted and message.msg_type in AIS_POSITIONS else {}
    return Telling(told, f"{kind} {message.mmsi}")


def _of_ais(report: Mapping[str, Any]) -> Tellings:
    longitude, latitude, turn = report["lon"], report["lat"], report.get("turn")
    fixed = longitude != NO_LONGITUDE and latitude != NO_LATITUDE
    speed = {} if report["speed"] >= NO_SPEED else {"speed_over_ground": report["speed"] * KNOT}
    return {
        "position": _only(longitude=longitude, latitude=latitude) if fixed else {},
        "speed over ground": speed | ({} if report["course"] >= NO_COURSE else _course(report["course"])),
        "heading": {} if report["heading"] == NO_HEADING else {"heading": report["heading"] * DEGREE},
        # Codes beyond all numbers say that it turns, not how fast.
        "yaw rate": {} if turn is None or isinstance(turn, Enum) else {"r": turn * DEGREE / 60},
    }
