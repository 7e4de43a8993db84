"""Listening to a ship's network: one thread per connection, and the messages of every second."""

import ipaddress
import json
import math
import re
import socket
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from threading import Event, Lock, Thread
from typing import Any, NamedTuple
from urllib.parse import parse_qs, urlsplit

from narrows.base.errors import InputError, needs, reason
from narrows.readers.nmea import PARTICULARS, DecodedMessage, Entry, NmeaDecoder, Sentence, Values, sentences
from narrows.warning import settings
from narrows.warning.alerts.alert import command_of
from narrows.warning.inputs.bridge_readings import Tick


class Arrival(NamedTuple):
    t: float  # When [s]
    message: Sentence | DecodedMessage  # Decoded already if from Signal K


class Piece(NamedTuple):
    content: bytes  # Nothing after ``settings.READ_TIMEOUT`` of silence
    sender: str = ""  # Host or device that it is from


@dataclass(frozen=True)
class Connection:
    address: str  # As the user wrote it
    whole: bool  # True where each piece that is read ends its last line
    signal_k: bool  # True for Signal K, False for NMEA 0183
    # Opens it and reads it piece by piece; raises an OSError where it breaks, and closes it when nobody reads on
    opened: Callable[[], Generator[Piece]]

    def pieces(self, stop: Event) -> Iterator[Piece]:
        pause = settings.FIRST_PAUSE
        while not stop.is_set():
            try:
                with closing(self.opened()) as pieces:
                    for piece in pieces:
                        if stop.is_set():
                            return
                        if piece.content:
                            pause = settings.FIRST_PAUSE
                            yield piece
            except OSError:
                stop.wait(pause)
                pause = min(2 * pause, settings.LONGEST_PAUSE)


class Listening(AbstractContextManager["Listening"]):
    def __init__(self, connections: Sequence[Connection], mmsi: int | None = None, peers: Iterable[str] = ()) -> None:
        self._peers = frozenset(peers)  # Hosts or devices whose commands (ACN) are taken
        self.inbox, self.decoder, self._stop = Inbox(), NmeaDecoder(mmsi), Event()
        self._faults = [Counter[str]() for _ in connections]
        listened = zip(connections, self._faults, strict=True)
        self._threads = [Thread(target=self._listen, args=own, daemon=True) for own in listened]
        for thread in self._threads:
            thread.start()

    def __exit__(self, *error: object) -> None:
        self._stop.set()
        for thread in self._threads:
            thread.join()

    def ticks(self) -> Iterator[Tick]:
        """Yield the messages of every second, if any; times count from an arbitrary origin."""
        due = time.monotonic() + settings.PERIOD
        while not self._stop.wait(max(0.0, due - time.monotonic())):
            # All messages of the own ship, and those of others as far as time allows.
            now, arrivals = time.monotonic(), self.inbox.own()
            while time.monotonic() < now + settings.AIS_TIME_SHARE * settings.PERIOD and (other := self.inbox.other()):
                arrivals.append(other)
            decoded = ((t, self.decoder.decode(one) if isinstance(one, Sentence) else one) for t, one in arrivals)
            entries = [Entry(t, one) for t, one in decoded if one is not None]
            commands = (command_of(one.text) for _, one in arrivals if isinstance(one, Sentence))
            yield Tick(now, entries, self.faults(), [one for one in commands if one])
            due = max(due, now - settings.PERIOD) + settings.PERIOD

    def faults(self) -> dict[str, int]:
        total = sum((Counter(faults) for faults in self._faults), Counter(self.decoder.faults))
        total["for which there was no time"] = self.inbox.lost
        return dict(+total)

    def _listen(self, connection: Connection, faults: Counter[str]) -> None:
        # A datagram ends its last line, so that those of several senders do not mix.
        splitter, signal_k = LineSplitter(faults), SignalK(faults)
        for content, sender in connection.pieces(self._stop):
            now, messages = time.monotonic(), list[Sentence | DecodedMessage]()
            if connection.signal_k:
                messages += signal_k.deltas(content, time.time())
            else:
                messages += sentences(splitter.lines(content, connection.whole), faults)
            for message in messages:
                if isinstance(message, Sentence) and message.kind.endswith("ACN") and sender not in self._peers:
                    faults[NO_PEER] += 1
                else:
                    self.inbox.put(Arrival(now, message))


NO_PEER = "of commands from a place that may give none (--commands-from)"


class Inbox:
    def __init__(self) -> None:
        self.lost = 0
        self._own: deque[Arrival] = deque(maxlen=settings.OWN_QUEUE)
        self._others: deque[Arrival] = deque(maxlen=settings.OTHERS_QUEUE)
        self._lock = Lock()

    def put(self, arrival: Arrival) -> None:
        message = arrival.message
        queue = self._others if isinstance(message, Sentence) and message.kind.endswith("VDM") else self._own
        with self._lock:
            self.lost += len(queue) == queue.maxlen
            queue.append(arrival)

    def own(self) -> list[Arrival]:
        with self._lock:
            taken = list(self._own)
            self._own.clear()
        return taken

    def other(self) -> Arrival | None:
        with self._lock:
            return self._others.popleft() if self._others else None


class LineSplitter:
    def __init__(self, faults: Counter[str]) -> None:
        self.faults = faults
        self._rest = b""

    def lines(self, piece: bytes, whole: bool = False) -> list[bytes]:
        *lines, rest = (self._rest + piece).replace(b"\r", b"\n").split(b"\n")
        if whole:
            lines, rest = [*lines, rest], b""
        if len(rest) > settings.LONGEST_LINE:
            self.faults["that never ended"] += 1
            rest = b""
        self._rest = rest
        return [line for line in lines if line]


# Signal K deltas (specification 1.7): JSON with paths, in SI already.
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
OTHER_VESSEL, OUT_OF_DATE = "of Signal K about other vessels", "of Signal K that are out of date, or by another clock"


class SignalK:
    """Deltas of one server: of the own vessel, whatever the server calls it, and of now."""

    def __init__(self, faults: Counter[str]) -> None:
        self.faults, self._own = faults, {SELF}

    def deltas(self, text: bytes, since_1970: float) -> Iterator[DecodedMessage]:
        try:
            message = json.loads(text)
            if isinstance(own := message.get("self"), str):  # The server's first words.
                self._own = {SELF, own, f"vessels.{own}"}
            if message.get("context", SELF) not in self._own:
                self.faults[OTHER_VESSEL] += 1
                return
            for update in message.get("updates", ()):
                if stamp := update.get("timestamp"):  # A message without a time is of now.
                    at = datetime.fromisoformat(stamp)
                    at = at if at.tzinfo else at.replace(tzinfo=UTC)
                    if abs(since_1970 - at.timestamp()) > settings.SIGNAL_K_AGE:
                        self.faults[OUT_OF_DATE] += 1
                        continue
                values = _grouped(update.get("values", ()))
                if any(values.values()):
                    yield DecodedMessage(values, f"{SOURCE} {update.get('$source', '')}".strip())
        except (ValueError, TypeError, AttributeError, KeyError, RecursionError, OverflowError):
            self.faults["of Signal K that cannot be understood"] += 1


def _grouped(pairs: Any) -> dict[str, Values]:
    values: dict[str, Values] = {}
    for each in pairs:
        path, value = ENGINE.sub("propulsion.", each["path"]), each["value"]
        if path == POSITION:
            known = isinstance(value, dict) and all(_can_be(value.get(name), most) for name, most in PLACES.items())
            values["position"] = {name: float(value[name]) for name in PLACES} if known else {}
        elif path in PATHS and _can_be(value, PATHS[path][2]):
            about, column, _ = PATHS[path]
            values.setdefault(about, {})[column] = float(value)
    return values


def _can_be(value: Any, largest: float) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= largest


# Sources of sentences while a ship sails: UDP, TCP, serial lines, Signal K; each is reopened when it breaks.
DATAGRAM = 65_535
BAUD = 4800
SCHEMES = "udp://:10110, tcp://192.168.1.20:10110, serial:///dev/ttyUSB0?baud=38400 or ws://192.168.1.20:3000"
SIGNAL_K = "/signalk/v1/stream?subscribe=self"


def connection_of(address: str) -> Connection:
    parts = urlsplit(address)
    try:
        host, port = parts.hostname or "", parts.port
    except ValueError:
        raise InputError(f"{address}: the port is no number from 0 to 65535; write it as in {SCHEMES}") from None
    if parts.scheme == "udp" and port is not None:
        return Connection(address, True, False, partial(_udp, host, port))
    if parts.scheme == "tcp" and host and port is not None:
        return Connection(address, False, False, partial(_tcp, host, port))
    if parts.scheme == "serial" and parts.path:
        baud = parse_qs(parts.query).get("baud", [str(BAUD)])[0]
        if not baud.isdecimal():
            raise InputError(f"{address}: baud = {baud} is no speed of a line; write it as in {SCHEMES}")
        with needs("monitor", "a serial line"):
            from serial import Serial
        return Connection(address, False, False, partial(_serial, Serial, parts.path, int(baud)))
    if parts.scheme in ("ws", "wss") and host:
        stream = address if parts.path.strip("/") else address.rstrip("/") + SIGNAL_K
        with needs("monitor", "Signal K"):
            from websockets.sync.client import connect
        return Connection(address, True, True, partial(_signal_k, connect, stream))
    raise InputError(f"{address}: is no address to listen to; write {SCHEMES}, or the name of a recording")


def _udp(host: str, port: int) -> Generator[Piece]:
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as udp:
        udp.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, True)
        udp.settimeout(settings.READ_TIMEOUT)
        udp.bind((host, port))
        with suppress(ValueError):  # A name, or no host at all.
            if ipaddress.ip_address(host).is_multicast:  # As networks of IEC 61162-450 speak.
                group = socket.inet_aton(host) + socket.inet_aton("0.0.0.0")
                udp.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
        while True:
            yield _received(udp)


def _tcp(host: str, port: int) -> Generator[Piece]:
    with closing(socket.create_connection((host, port), settings.OPEN_TIMEOUT)) as tcp:
        tcp.settimeout(settings.READ_TIMEOUT)
        while True:
            yield _received(tcp, host)


def _received(line: socket.socket, host: str = "") -> Piece:
    """Return what a socket receives: from one host, or datagrams of any."""
    try:
        content, sender = line.recvfrom(DATAGRAM)
    except TimeoutError:
        return Piece(b"")
    if host and not content:
        raise ConnectionError("the other side closed it")
    return Piece(content, host or sender[0])


def _serial(opened: Callable[..., Any], device: str, baud: int) -> Generator[Piece]:
    with closing(opened(device, baud, timeout=settings.READ_TIMEOUT)) as port:
        while True:
            yield Piece(bytes(port.read(max(1, port.in_waiting))), device)


def _signal_k(connect: Callable[..., Any], stream: str) -> Generator[Piece]:
    from websockets.exceptions import WebSocketException

    try:
        with connect(stream, open_timeout=settings.OPEN_TIMEOUT, max_size=1 << 20) as websocket:
            while True:
                content = b""
                with suppress(TimeoutError):
                    content = bytes(websocket.recv(settings.READ_TIMEOUT, decode=False))
                yield Piece(content)
    except WebSocketException as error:
        raise ConnectionError(reason(error)) from None
