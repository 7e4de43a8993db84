"""Alerts on their way out: into the log first, then to the bridge; lists and heartbeats in between."""

import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from itertools import count
from threading import Condition, Event, Thread
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from narrows.errors import InputError, needs
from narrows.results import to_json
from narrows.warning import settings
from narrows.warning.alerts.alert import Alert, AlertDesk
from narrows.warning.alerts.alert_log import AlertLog
from narrows.warning.alerts.alert_sentences import AlertCommand, alc, alf, arc, ended, hbt, notifications

if TYPE_CHECKING:
    from websockets.sync.client import ClientConnection

Send = Callable[[str], None]


class AlertPublisher:
    def __init__(self, log: AlertLog | None = None, send: Send | None = None) -> None:
        self.log, self.send = log, send or (lambda sentence: None)
        self.late = ""
        self._numbers = {name: count() for name in ("alf", "alc", "hbt")}
        self._listed = self._beaten = -settings.HEARTBEAT

    def publish(self, changed: Sequence[Alert], since_1970: float) -> None:
        for alert in changed:
            if self.log is not None:
                written = self.log.alert(alert)
                self.late = "" if written else f"alerts are not on disk: {self.log.trouble or 'it does not answer'}"
            for sentence in alf(alert, since_1970, next(self._numbers["alf"])):
                self.send(sentence)

    def refuse(self, command: AlertCommand, since_1970: float) -> None:
        self.send(arc(command, since_1970))

    def beat(self, t: float, alerts: Sequence[Alert], sound: bool) -> None:
        if t - self._listed >= settings.LIST_INTERVAL:
            self._listed = t
            for sentence in alc(alerts, next(self._numbers["alc"])):
                self.send(sentence)
        if t - self._beaten >= settings.HEARTBEAT:
            self._beaten = t
            self.send(hbt(sound, next(self._numbers["hbt"])))


@contextmanager
def sender_to(address: str) -> Iterator[Send]:
    host, _, port = address.removeprefix("udp://").rpartition(":")
    if not address.startswith("udp://") or not host or not port.isdecimal() or int(port) > 65_535:
        raise InputError(f"{address}: alerts go out by UDP; write the address as in udp://239.192.0.1:60001")
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as udp:

        def send(sentence: str) -> None:
            with suppress(OSError):  # Nobody listens, or there is no network: the log and the screen have it.
                udp.sendto(sentence.encode("ascii"), (host, int(port)))

        yield send


# Alerts to a Signal K server: a connection that is opened anew when it breaks, and that nobody waits for.
STREAM = "/signalk/v1/stream?subscribe=none"


class SignalKSender:
    """Sends the newest of all alerts, each time that they change; all of them after every new connection."""

    # When it ends it sends that nothing is alerted any more: a server keeps the last message.

    def __init__(self, address: str) -> None:
        with needs("monitor", "Signal K"):
            from websockets.sync.client import connect
        parts = urlsplit(address)
        if parts.scheme not in ("ws", "wss") or not parts.netloc:
            raise InputError(f"{address}: is no address of Signal K; write it as in ws://192.168.1.20:3000")
        self.address = address if parts.path.strip("/") else f"{parts.scheme}://{parts.netloc}{STREAM}"
        self._connect = connect
        self._newest: dict[str, Any] | None = None
        self._changed, self._stop = Condition(), Event()
        self._thread = Thread(target=self._run, daemon=True)

    def __enter__(self) -> "SignalKSender":
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        with self._changed:
            self._newest = self._newest and ended(time.time())
            self._stop.set()
            self._changed.notify_all()
        self._thread.join(settings.LAST_MESSAGE_TIMEOUT)

    def send(self, desk: AlertDesk, since_1970: float) -> None:
        """Leave the alerts as they are, without waiting for anything."""
        with self._changed:
            self._newest = notifications(desk, since_1970)
            self._changed.notify_all()

    def _run(self) -> None:
        from websockets.exceptions import WebSocketException

        pause = settings.FIRST_PAUSE
        while not self._stop.is_set():
            try:
                with self._connect(self.address, open_timeout=settings.OPEN_TIMEOUT) as server:
                    for message in self._changes():
                        _exchange(server, message)
                        pause = settings.FIRST_PAUSE
            except (OSError, WebSocketException):
                self._stop.wait(pause)
                pause = min(2 * pause, settings.LONGEST_PAUSE)

    def _changes(self) -> Iterator[str]:
        """Return the messages for a new connection: one now, and one whenever something changes."""
        sent: list[Any] = []
        while not self._stop.is_set() or self._values() != sent:
            with self._changed:
                if self._values() == sent:
                    self._changed.wait(settings.READ_TIMEOUT)
                newest, values = self._newest, self._values()
            yield to_json(newest) if values != sent else ""
            sent = values

    def _values(self) -> list[Any]:
        return list(self._newest["updates"][0]["values"]) if self._newest else []


def _exchange(server: "ClientConnection", message: str) -> None:
    """Send pending data and discard replies: a connection that is never read breaks unnoticed."""
    if message:
        server.send(message)
    try:
        while True:
            server.recv(0.0)
    except TimeoutError:
        return
