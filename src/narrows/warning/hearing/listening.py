"""Listening to a ship's network: a thread a connection, and every second what was told in it."""

import json
import math
import re
import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from threading import Event, Lock, Thread
from typing import Any, NamedTuple

from narrows.readers.nmea.nmea_clock import Entry
from narrows.readers.nmea.nmea_hearing import Hearing
from narrows.readers.nmea.nmea_lines import Sentence, sentences
from narrows.readers.nmea.nmea_sentences import PARTICULARS, Telling, Tellings, Values
from narrows.warning.hearing.bridge_readings import PERIOD, Tick
from narrows.warning.hearing.connections import Connection

# Of a second that the reports of other ships may take.
SHARE = 0.2


class Arrival(NamedTuple):
    """A message that came."""

    t: float  # When [s]
    message: Sentence | Telling  # A sentence that is still to be understood, or what was told


class Listening:
    """Connections that are listened to."""

    def __init__(self, connections: Sequence[Connection], mmsi: int | None = None) -> None:
        self.inbox, self.hearing, self._stop = Inbox(), Hearing(mmsi), Event()
        self.broken: dict[str, str] = {}
        self._faults = [Counter[str]() for _ in connections]
        self._threads = [
            Thread(target=self._listen, args=told, daemon=True) for told in zip(connections, self._faults, strict=True)
        ]

    def __enter__(self) -> "Listening":
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._stop.set()
        for thread in self._threads:
            thread.join()

    def ticks(self) -> Iterator[Tick]:
        """Yield what came, every second, be it nothing; times count from an origin of the machine's own."""
        due = time.monotonic() + PERIOD
        while not self._stop.wait(max(0.0, due - time.monotonic())):
            now = time.monotonic()
            arrivals = self._arrivals(now)
            yield Tick(now, self._entries(arrivals), self.faults(), [*_commands(arrivals)])
            due = max(due, now - PERIOD) + PERIOD

    def faults(self) -> dict[str, int]:
        """Messages that were left out, by what is wrong with them."""
        total = sum((Counter(faults) for faults in self._faults), Counter(self.hearing.faults))
        total["for which there was no time"] = self.inbox.lost
        return dict(+total)

    def _arrivals(self, now: float) -> list[Arrival]:
        """What came: all that the ship told of itself, and of the others as much as there is time for."""
        arrivals = self.inbox.own()
        while time.monotonic() < now + SHARE * PERIOD and (other := self.inbox.other()):
            arrivals.append(other)
        return arrivals

    def _entries(self, arrivals: list[Arrival]) -> list[Entry]:
        told = ((arrival.t, self._understood(arrival)) for arrival in arrivals)
        return [Entry(t, one) for t, one in told if one is not None]

    def _understood(self, arrival: Arrival) -> Telling | None:
        message = arrival.message
        return self.hearing.told(message, arrival.t) if isinstance(message, Sentence) else message

    def _listen(self, connection: Connection, faults: Counter[str]) -> None:
        splitter = LineSplitter(faults)

        def broken(why: str) -> None:
            self.broken[connection.address] = why

        for piece in connection.pieces(self._stop, broken):
            self.broken.pop(connection.address, None)
            now = time.monotonic()
            if connection.signal_k:
                for told in deltas(piece, faults):
                    self.inbox.put(Arrival(now, told))
                continue
            for sentence in sentences(splitter.lines(piece, connection.whole), faults):
                self.inbox.put(Arrival(now, sentence))


def _commands(arrivals: list[Arrival]) -> Iterator[bytes]:
    for _, message in arrivals:
        if isinstance(message, Sentence) and message.kind.endswith("ACN"):
            yield message.text


# What came and waits to be understood: of the ship itself first, of others as far as there is time; bounded.
# Messages that wait at most; of more the oldest are lost.
OWN, OTHERS = 20_000, 5_000


class Inbox:
    """Takes messages from several threads."""

    def __init__(self) -> None:
        self.lost = 0
        self._own: deque[Arrival] = deque(maxlen=OWN)
        self._others: deque[Arrival] = deque(maxlen=OTHERS)
        self._lock = Lock()

    def put(self, arrival: Arrival) -> None:
        """Add a message."""
        message = arrival.message
        queue = self._others if isinstance(message, Sentence) and message.kind.endswith("VDM") else self._own
        with self._lock:
            self.lost += len(queue) == queue.maxlen
            queue.append(arrival)

    def own(self) -> list[Arrival]:
        """Take all that the ship told of itself."""
        with self._lock:
            taken = list(self._own)
            self._own.clear()
        return taken

    def other(self) -> Arrival | None:
        """Take the oldest report of the others; None where there is none."""
        with self._lock:
            return self._others.popleft() if self._others else None


# Bytes as they come, cut into lines; what never ends is given up.
# Bytes of a line; a sentence has 82, and some more before it.
LONGEST = 4096


class LineSplitter:
    """Cuts bytes into lines."""

    def __init__(self, faults: Counter[str]) -> None:
        self.faults = faults
        self._rest = b""

    def lines(self, piece: bytes, whole: bool = False) -> list[bytes]:
        """Return the lines that a piece completes."""
        *lines, rest = (self._rest + piece).replace(b"\r", b"\n").split(b"\n")
        if whole:
            lines, rest = [*lines, rest], b""
        if len(rest) > LONGEST:
            self.faults["that never ended"] += 1
            rest = b""
        self._rest = rest
        return [line for line in lines if line]


# Signal K deltas: JSON with paths, in SI already. References ---------- Signal K specification 1.7: delta format, keys
# of the schema.
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
