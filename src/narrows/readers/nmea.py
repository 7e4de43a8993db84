"""Sentences of NMEA 0183: found in lines, checked, decoded to the documented SI columns by pynmeagps and pyais, timed.

Invalid sentences and other ships are counted; of several sources of one quantity, one is chosen.
"""

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, date, datetime, time
from enum import Enum
from functools import reduce
from itertools import islice
from operator import xor
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from narrows.base.errors import InputError, needs
from narrows.base.progress import opened
from narrows.quantities.names import DEGREE, KNOT
from narrows.readers import settings

# AIS message types with position and motion, all of one sentence (ITU-R M.1371).
AIS_POSITIONS = (1, 2, 3, 18)
# Largest valid numbers in sentences: larger ones are ignored, as those of AIS for "not available" (102.3, 360, 511).
LARGEST = {
    "longitude": 180.0, "latitude": 90.0, "heading": 360.0, "course_over_ground": 359.99, "speed_over_ground": 102.2,
    "r": 720.0, "rudder": 90.0, "revolutions": 6000.0, "u": 102.3, "v": 102.3, "u_ground": 102.3, "v_ground": 102.3,
    "wind_from": 360.0, "draft": 25.5, "depth": 1000.0,
}  # fmt: skip

Values = dict[str, float]
# Values by group (``SOURCES``): columns in SI.
GroupedValues = Mapping[str, Values]


class DecodedMessage(NamedTuple):
    values: GroupedValues  # Columns by group; empty if there are none
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
WATER_DEPTH = "depth of water"  # Group of the echo sounder


def decode_text(text: bytes, kind: str, mmsi: int | None = None) -> DecodedMessage | None:
    if kind.endswith(("VDO", "VDM")):
        if text.split(b",", 2)[1] != b"1":
            return None
        import pyais

        # The ship's own reports, or those of one ship received from others
        report = pyais.decode(text)
        wanted = kind.endswith("VDO") if mmsi is None else report.mmsi == mmsi
        is_report = wanted and report.msg_type in AIS_POSITIONS
        return DecodedMessage(_fields_of(report, "VDM") if is_report else {}, f"{kind} {report.mmsi}")
    if kind[2:] not in (*FIELDS, *READ, "ZDA"):
        return None
    from pynmeagps import NMEAReader

    message = NMEAReader.parse(text + b"\r\n")
    source = f"{kind} {message.source}{message.engineshaftnum}" if kind.endswith("RPM") else kind
    values = READ[kind[2:]](message) if kind[2:] in READ else _fields_of(message, kind[2:])
    clock, day = getattr(message, "time", None), getattr(message, "date", None)
    if kind.endswith("ZDA") and isinstance(message.year, int):
        day = date(message.year, message.month, message.day)
    return DecodedMessage(
        values, source, clock if isinstance(clock, time) else None, day if isinstance(day, date) else None
    )


FIXES = (1, 2, 3, 4, 5, 9)  # Valid fix qualities of GGA: not 6 (dead reckoning), 7 (manual), 8 (simulator)
# Invalid mode letters of RMC, GLL, VTG and GNS: dead reckoning, manual, simulator, none.
NO_FIXES = "EMSN"
MOST_HDOP = 5.0  # [1] largest HDOP of a fix that is usable near a bank


def _valid(**numbers: tuple[Any, float]) -> Values:
    """Return the valid numbers in SI, each given with its factor; of a place both or none."""
    # An empty field is an empty word, parsers accept NaN, and AIS has words among its rates of turn.
    values = {
        name: factor * value
        for name, (value, factor) in numbers.items()
        if isinstance(value, int | float) and not isinstance(value, Enum) and abs(value) <= LARGEST.get(name, math.inf)
    }
    return {} if len(values.keys() & PLACE.keys()) == 1 else values


PLACE = {"longitude": ("lon", 1.0), "latitude": ("lat", 1.0)}


def _over_ground(speed: str, course: str) -> dict[str, tuple[str, float]]:
    return {"speed_over_ground": (speed, KNOT), "course_over_ground": (course, DEGREE)}


# Groups by type of sentence: the field that says whether a group is valid, if any, and its columns, each with its field
# and the factor to SI. RSA: the starboard rudder, or the only one; negative if it turns the bow to port.
FIELDS: dict[str, dict[str, tuple[str, dict[str, tuple[str, float]]]]] = {
    "GGA": {"position": ("", PLACE)}, "GNS": {"position": ("", PLACE)}, "GLL": {"position": ("status", PLACE)},
    "RMC": {"position": ("status", PLACE), "speed over ground": ("status", _over_ground("spd", "cog"))},
    "VTG": {"speed over ground": ("", _over_ground("sogn", "cogt"))},
    "VDM": {
        "position": ("", PLACE), "speed over ground": ("", _over_ground("speed", "course")),
        "heading": ("", {"heading": ("heading", DEGREE)}), "yaw rate": ("", {"r": ("turn", DEGREE / 60)}),
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
    groups: dict[str, Values] = {}
    for group, (status, columns) in FIELDS.get(kind, {}).items() if _is_fix(message) else ():
        known = _valid(**{name: (getattr(message, key, None), factor) for name, (key, factor) in columns.items()})
        if known and getattr(message, status, "A") == "A":
            groups[group] = known
    return groups


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
    return {"heading": _valid(heading=((message.headingM + shift) % 360, DEGREE))}


def _dpt(message: Any) -> GroupedValues:
    """Depth of water if the transducer's offset refers to the surface, clearance if it refers to the keel."""
    values = _valid(depth=(message.depth, 1.0), offset=(message.offset, 1.0))
    if len(values) < 2 or values["depth"] < 0 or not values["offset"]:
        return {}
    of_all = values["offset"] > 0
    return {WATER_DEPTH: {"depth" if of_all else "under_keel_clearance": values["depth"] + values["offset"]}}


def _mwd(message: Any) -> GroupedValues:
    speed = _valid(wind_speed=(message.speedM, 1.0)) or _valid(wind_speed=(message.speedN, KNOT))
    return {"wind": speed | _valid(wind_from=(message.dirT, DEGREE))}


READ = {"HDG": _hdg, "DPT": _dpt, "MWD": _mwd}


SENTENCE = re.compile(rb"[$!]([A-Z][A-Z0-9]{4,}),([^*$!\r\n]*)(\*[0-9A-Fa-f]{2})?")
# A block before the sentence with the logger's time [s] or [ms] since 1970.
TAG = re.compile(rb"\\(?:[^\\]*,)?c:(\d{10,13})(?:[,*][^\\]*)?\\")
ISO = re.compile(rb"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d+)?)(Z|[+-]\d\d:?\d\d)?")
EPOCH = re.compile(rb"(?<![\d.])(1\d{9}(?:\.\d+)?)(?![\d.])")
MILLISECONDS = 1e11  # Larger times since 1970 are in milliseconds


class Sentence(NamedTuple):
    """One sentence with a valid checksum."""

    text: bytes  # Characters from ``$`` or ``!`` to the checksum
    kind: str  # Talker and type, as in ``GPGGA``
    logged: float | None  # Logger's time since 1970, if given [s]


def sentences(lines: Iterable[bytes], faults: Counter[str]) -> Iterator[Sentence]:
    for line in lines:
        if line.startswith(b"#"):  # A remark
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
    return reduce(xor, body, 0)  # IEC 61162-1


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


class NmeaDecoder:
    def __init__(self, mmsi: int | None = None) -> None:
        with needs("nmea", "NMEA 0183"):
            import pyais  # noqa: F401
            import pynmeagps  # noqa: F401
        self.mmsi = mmsi
        self.faults: Counter[str] = Counter()
        self.ships: Counter[str] = Counter()

    def decode(self, sentence: Sentence) -> DecodedMessage | None:
        """Return the values of a sentence; None if it has none for this package, or is invalid."""
        try:
            message = decode_text(sentence.text, sentence.kind, self.mmsi)
        except Exception:  # The parsers raise many kinds of errors on bad fields
            self.faults["that cannot be understood"] += 1
            return None
        if message is not None and sentence.kind.endswith("VDM") and not message.values:
            ship = message.source.split()[-1]
            if ship in self.ships or len(self.ships) < settings.MOST_SHIPS:
                self.ships[ship] += 1
        return message


class Entry(NamedTuple):
    t: float  # Time since the start of the recording [s]
    message: DecodedMessage


DAY = 86400.0


def _midnight(day: date) -> float:
    return datetime.combine(day, time(), UTC).timestamp()


class Clock:
    def __init__(self, logged: bool, day: date | None = None) -> None:
        self.logged, self.day = logged, day
        self.begin: float | None = None
        self.lost = 0
        self._midnight = _midnight(day) if day else 0.0
        self._last = -DAY

    def entries(self, messages: Iterable[tuple[Sentence, DecodedMessage]]) -> Iterator[Entry]:
        waiting: list[DecodedMessage] = []
        before: float | None = None
        for sentence, one in messages:
            clock = sentence.logged if self.logged else self._by_clock(one)
            if clock is None:
                waiting.append(one)
                continue
            self.begin = clock if self.begin is None else self.begin
            now = clock - self.begin
            if before is None:
                self.lost += len(waiting)
            else:  # Those without a clock, evenly between those with one
                step = max(now - before, 0.0) / (len(waiting) + 1)
                yield from (Entry(before + step * place, other) for place, other in enumerate(waiting, 1))
            waiting, before = [], now
            yield Entry(now, one)
        if before is not None:
            yield from (Entry(before, one) for one in waiting)

    def _by_clock(self, message: DecodedMessage) -> float | None:
        """Seconds since 1970, or since midnight of an unknown day, from the clock inside a sentence."""
        if message.clock is None:
            return None
        seconds = (datetime.combine(date.min, message.clock) - datetime.min).total_seconds()
        if message.day is not None:
            self._midnight = _midnight(message.day)
        elif seconds < self._last - DAY / 2:
            self._midnight += DAY
        self._last = seconds
        return self._midnight + seconds


def is_nmea(path: Path) -> bool:
    with path.open("rb") as file:
        lines = [line for line in file.read(settings.SNIFFED).splitlines() if line.strip()]
    found = sum(bool((match := SENTENCE.search(line)) and match[3]) for line in lines)
    return bool(lines) and found > settings.NMEA_SHARE * len(lines)


class Recording:
    def __init__(self, path: Path, mmsi: int | None = None) -> None:
        if not path.is_file():
            raise InputError(f"{path}: there is no such file; check the path")
        self.path, self.decoder = path, NmeaDecoder(mmsi)
        self.sources, self.clock = Sources(), Clock(logged=False)

    def entries(self) -> Iterator[Entry]:
        with self.path.open("rb") as file:
            sample = list(islice(self._decoded(file), settings.SOURCE_SENTENCES))
        self.decoder = NmeaDecoder(self.decoder.mmsi)
        logged = sum(sentence.logged is not None for sentence, _ in sample)
        day = next((message.day for _, message in sample if message.day), None)
        self.sources = Sources(one for _, one in sample)
        self.clock = Clock(logged > settings.NMEA_SHARE * len(sample), day)
        with opened(self.path) as file:
            yield from self.clock.entries(self._decoded(file))

    def _decoded(self, lines: Iterable[bytes]) -> Iterator[tuple[Sentence, DecodedMessage]]:
        for sentence in sentences(lines, self.decoder.faults):
            if (message := self.decoder.decode(sentence)) is not None:
                yield sentence, message

    def frames(self, rows: int) -> Iterator[pd.DataFrame]:
        entries, first = self.entries(), 0
        while piece := list(islice(entries, rows)):
            read = []  # One per sentence; values of sources that were not chosen are skipped
            for t, message in piece:
                known = [own for about, own in message.values.items() if self.sources.accepts(about, message.source, t)]
                read.append({"t": t, **{name: value for own in known for name, value in own.items()}})
            frame = pd.DataFrame(read, index=pd.RangeIndex(first, first + len(read)))
            first += len(read)
            if len(frame.columns) > 1:
                yield frame
        if not self.sources.chosen:
            ships = ", ".join(name for name, _ in self.decoder.ships.most_common(3))
            others = f"; AIS reports are of the ships {ships}: choose one by mmsi=" if ships else ""
            raise InputError(f"{self.path}: no sentence gives the position or motion of this ship{others}")

    def notes(self) -> tuple[str, ...]:
        clock = self.clock
        used = ", ".join(f"{about} by {' and '.join(sources)}" for about, sources in self.sources.used.items())
        by = "the logger's times" if clock.logged else "the clocks in the sentences, evenly between them"
        dated = clock.begin is not None and (clock.logged or clock.day is not None)
        start = f", from {datetime.fromtimestamp(clock.begin or 0.0, UTC).isoformat()}" if dated else ""
        left = [f"{count} sentences {what} were left out" for what, count in self.decoder.faults.items()]
        lost = [f"{clock.lost} sentences before the first time were left out"] if clock.lost else []
        return (f"{used}; timed by {by}{start}", *left, *lost)


class Sources:
    def __init__(self, sample: Iterable[DecodedMessage] = ()) -> None:
        counts: dict[str, Counter[str]] = {about: Counter() for about in SOURCES}
        for message in sample:
            for about, values in message.values.items():
                if values and about in counts:
                    counts[about][message.source] += 1
        self.chosen = {  # The best type, and of these the most frequent
            about: min(found, key=lambda source: (SOURCES[about].index(source.split()[0][-3:]), -found[source]))
            for about, found in counts.items() if found
        }  # fmt: skip
        self.used = {about: {source: None} for about, source in self.chosen.items()}  # In the order of their use
        self._last: dict[str, float] = {}

    def accepts(self, about: str, source: str, t: float) -> bool:
        if about not in SOURCES:
            return False
        chosen = self.chosen.setdefault(about, source)
        if source != chosen:
            # The talker stands first: a source of the same type and detail may replace it.
            if source[2:] != chosen[2:] or t - self._last.get(about, 0.0) < settings.TALKER_SILENCE:
                return False
            self.chosen[about] = source
        self.used.setdefault(about, {})[source] = None
        self._last[about] = t
        return True
