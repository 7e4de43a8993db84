"""Listening to a ship's network: one thread per connection, and the messages of every second."""

import ipaddress
import socket
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, suppress
from dataclasses import dataclass
from functools import partial
from threading import Event, Thread
from typing import Any, NamedTuple
from urllib.parse import parse_qs, urlsplit

from narrows.base.errors import InputError, needs
from narrows.readers.nmea import Entry, NmeaDecoder, sentences
from narrows.warning import settings
from narrows.warning.alerts.alert import AlertCommand, command_of
from narrows.warning.inputs.bridge_readings import Tick

NO_PEER = "of commands from a place that may give none (--commands-from)"
NO_TIME = "for which there was no time"


class Piece(NamedTuple):
    content: bytes  # Nothing after ``settings.READ_TIMEOUT`` of silence
    sender: str = ""  # Host or device that it is from


@dataclass(frozen=True)
class Connection:
    whole: bool  # True where each piece that is read ends its last line
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
        self.decoder, self._stop, self._lost = NmeaDecoder(mmsi), Event(), 0
        # Lines that wait for their second: when they came [s], and from where; threads only add to them.
        self._lines: deque[tuple[float, bytes, str]] = deque(maxlen=settings.MOST_LINES)
        self._threads = [Thread(target=self._listen, args=(own,), daemon=True) for own in connections]
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
            now = time.monotonic()
            entries, commands = self._decoded([self._lines.popleft() for _ in range(len(self._lines))])
            lost = {NO_TIME: self._lost} if self._lost else {}
            yield Tick(now, entries, {**self.decoder.faults, **lost}, commands)
            due = max(due, now - settings.PERIOD) + settings.PERIOD

    def _decoded(self, lines: Iterable[tuple[float, bytes, str]]) -> tuple[list[Entry], list[AlertCommand]]:
        entries, commands, faults = list[Entry](), list[AlertCommand](), self.decoder.faults
        for t, line, sender in lines:
            for sentence in sentences([line], faults):
                if not sentence.kind.endswith("ACN"):
                    message = self.decoder.decode(sentence)
                    entries += [Entry(t, message)] if message else []
                elif sender in self._peers:
                    command = command_of(sentence.text)
                    commands += [command] if command else []
                else:
                    faults[NO_PEER] += 1
        return entries, commands

    def _listen(self, connection: Connection) -> None:
        rest = b""
        for content, sender in connection.pieces(self._stop):
            lines, rest = split_lines(rest + content, connection.whole)
            for line in lines:
                # Reports of other ships are of no use, and must not crowd out the own sentences.
                if b"VDM," in line and self.decoder.mmsi is None:
                    continue
                self._lost += len(self._lines) == self._lines.maxlen
                self._lines.append((time.monotonic(), line, sender))


def split_lines(text: bytes, whole: bool) -> tuple[list[bytes], bytes]:
    """Return whole lines, and the begun one after them; a datagram ends its last line, so that senders do not mix."""
    *lines, rest = text.replace(b"\r", b"\n").split(b"\n")
    if whole:
        lines, rest = [*lines, rest], b""
    return [line for line in lines if line], rest[-settings.LONGEST_LINE :]


# Sources of sentences while a ship sails: UDP, TCP, serial lines; each is reopened when it breaks.
DATAGRAM = 65_535
BAUD = 4800
SCHEMES = "udp://:10110, tcp://192.168.1.20:10110 or serial:///dev/ttyUSB0?baud=38400"


def connection_of(address: str) -> Connection:
    parts = urlsplit(address)
    try:
        host, port = parts.hostname or "", parts.port
    except ValueError:
        raise InputError(f"{address}: the port is no number from 0 to 65535; write it as in {SCHEMES}") from None
    if parts.scheme == "udp" and port is not None:
        return Connection(True, partial(_udp, host, port))
    if parts.scheme == "tcp" and host and port is not None:
        return Connection(False, partial(_tcp, host, port))
    if parts.scheme == "serial" and parts.path:
        baud = parse_qs(parts.query).get("baud", [str(BAUD)])[0]
        if not baud.isdecimal():
            raise InputError(f"{address}: baud = {baud} is no speed of a line; write it as in {SCHEMES}")
        with needs("monitor", "a serial line"):
            from serial import Serial
        return Connection(False, partial(_serial, Serial, parts.path, int(baud)))
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
