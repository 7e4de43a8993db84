"""Where sentences come from while a ship sails: UDP, TCP, serial lines, Signal K; each opened anew when it breaks."""

import ipaddress
import socket
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager, suppress
from dataclasses import dataclass
from threading import Event
from urllib.parse import parse_qs, urlsplit

from narrows.errors import InputError, needs, reason

# To wait for a word [s] before looking whether to go on.
PATIENCE = 0.5
# To wait for a connection [s].
OPENING = 5.0
# Before a connection is tried again [s]; each time twice as long.
FIRST_PAUSE, LONGEST_PAUSE = 0.5, 30.0
DATAGRAM = 65_535
BAUD = 4800
SCHEMES = "udp://:10110, tcp://192.168.1.20:10110, serial:///dev/ttyUSB0?baud=38400 or ws://192.168.1.20:3000"
SIGNAL_K = "/signalk/v1/stream?subscribe=self"
# What came; nothing after ``PATIENCE`` of silence. Raises OSError where the connection broke.
Read = Callable[[], bytes]


@dataclass(frozen=True)
class Connection:
    """A way by which bytes come."""

    address: str  # As the user wrote it
    whole: bool  # Whether each piece that is read ends its last line
    signal_k: bool  # Whether it speaks Signal K, and not NMEA 0183
    opened: Callable[[], AbstractContextManager[Read]]  # Opens it; what that gives reads

    def pieces(self, stop: Event, broken: Callable[[str], None]) -> Iterator[bytes]:
        """Yield what comes until it is to stop; a connection that breaks is opened anew, ever less often."""
        pause = FIRST_PAUSE
        while not stop.is_set():
            try:
                with self.opened() as read:
                    while not stop.is_set():
                        if piece := read():
                            pause = FIRST_PAUSE
                            yield piece
            except OSError as error:
                broken(reason(error))
                stop.wait(pause)
                pause = min(2 * pause, LONGEST_PAUSE)


def connection_of(address: str) -> Connection:
    """Return the connection of an address."""
    parts = urlsplit(address)
    try:
        host, port = parts.hostname or "", parts.port
    except ValueError:
        raise InputError(f"{address}: the port is no number from 0 to 65535; write it as in {SCHEMES}") from None
    if parts.scheme == "udp" and port is not None:
        return Connection(address, True, False, lambda: _udp(host, port))
    if parts.scheme == "tcp" and host and port is not None:
        return Connection(address, False, False, lambda: _tcp(host, port))
    if parts.scheme == "serial" and parts.path:
        return _serial_line(address, parts.path, parse_qs(parts.query).get("baud", [str(BAUD)])[0])
    if parts.scheme in ("ws", "wss") and host:
        return _signal_k(address, address if parts.path.strip("/") else address.rstrip("/") + SIGNAL_K)
    raise InputError(f"{address}: is no address to listen to; write {SCHEMES}, or the name of a recording")


def _quietly(receive: Callable[[int], bytes]) -> Read:
    """Reads from a socket: nothing in silence; an end is a broken connection."""

    def read() -> bytes:
        try:
            piece = receive(DATAGRAM)
        except TimeoutError:
            return b""
        if not piece:
            raise ConnectionError("the other side closed it")
        return piece

    return read


@contextmanager
def _udp(host: str, port: int) -> Iterator[Read]:
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as udp:
        udp.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        udp.settimeout(PATIENCE)
        udp.bind((host, port))
        with suppress(ValueError):  # A name, or no host at all.
            if ipaddress.ip_address(host).is_multicast:  # As networks of IEC 61162-450 speak.
                group = socket.inet_aton(host) + socket.inet_aton("0.0.0.0")
                udp.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)

        def received(most: int) -> bytes:
            return udp.recv(most) or b"\n"  # An empty datagram is no end.

        yield _quietly(received)


@contextmanager
def _tcp(host: str, port: int) -> Iterator[Read]:
    with closing(socket.create_connection((host, port), OPENING)) as tcp:
        tcp.settimeout(PATIENCE)
        yield _quietly(tcp.recv)


def _serial_line(address: str, device: str, baud: str) -> Connection:
    with needs("monitor", "a serial line"):
        import serial
    if not baud.isdecimal():
        raise InputError(f"{address}: baud = {baud} is no speed of a line; write it as in {SCHEMES}")

    @contextmanager
    def line() -> Iterator[Read]:
        with closing(serial.Serial(device, int(baud), timeout=PATIENCE)) as port:
            yield lambda: bytes(port.read(max(1, port.in_waiting)))

    return Connection(address, False, False, line)


def _signal_k(address: str, stream: str) -> Connection:
    with needs("monitor", "Signal K"):
        from websockets.exceptions import WebSocketException
        from websockets.sync.client import connect

    @contextmanager
    def socket_of() -> Iterator[Read]:
        try:
            with connect(stream, open_timeout=OPENING, max_size=1 << 20) as websocket:

                def read() -> bytes:
                    try:
                        return bytes(websocket.recv(PATIENCE, decode=False))
                    except TimeoutError:
                        return b""

                yield read
        except WebSocketException as error:
            raise ConnectionError(reason(error)) from None

    return Connection(address, True, True, socket_of)
