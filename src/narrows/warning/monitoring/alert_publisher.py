"""Alerts on their way out: into the log first, then to the bridge as sentences ALF, ALC, HBT and ARC; ACN comes in.

Source: Fields as printed in makers' manuals, after IEC 61162-1: JRC JLN-900 (2018), 3.1, and JFE-680, 4, for ALF, ALC,
HBT, ARC and ACN.
"""

import re
import socket
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, suppress
from datetime import UTC, datetime
from itertools import count
from threading import Event, Thread
from typing import Any
from urllib.parse import urlsplit

from narrows.base.errors import InputError, needs
from narrows.base.files import to_json
from narrows.readers.nmea import with_checksum
from narrows.warning import settings
from narrows.warning.alerts.alert import MAKER, Alert, AlertCommand, AlertDesk, AlertLog, AlertState, Priority

TALKER = "II"  # Integrated instrumentation
# Letters of the second sentence of an alert.
LONGEST_TEXT = 40
# Entries of a list in one sentence.
ENTRIES = 3
RESERVED = re.compile(r"[\r\n$*,!\\^~]|[^\x20-\x7d]")
# Letters of states. Makers' manuals contradict each other, so they can be changed.
LETTERS: Mapping[AlertState, str] = {
    AlertState.NORMAL: "N", AlertState.UNACKNOWLEDGED: "V", AlertState.SILENCED: "S", AlertState.ACKNOWLEDGED: "A",
    AlertState.RECTIFIED: "U", AlertState.TRANSFERRED: "O",
}  # fmt: skip


def alf(alert: Alert, since_1970: float, number: int, letters: Mapping[AlertState, str] = LETTERS) -> list[str]:
    # An alert that is not normal has a priority; one that became normal keeps its last one.
    about = f"{_clock(since_1970)},{alert.category},{alert.priority.letter},{letters[alert.state]}"
    which = f"{MAKER},{alert.identifier},{alert.instance},{alert.revision},{alert.repeats}"
    texts = (about, alert.name), (",,,", alert.text[:LONGEST_TEXT])
    return [
        with_checksum(f"{TALKER}ALF,2,{place},{number % 10},{head},{which},{_escaped(text)}")
        for place, (head, text) in enumerate(texts, 1)
    ]


def alc(alerts: Sequence[Alert], number: int) -> list[str]:
    parts = [alerts[first : first + ENTRIES] for first in range(0, len(alerts), ENTRIES)] or [()]
    lines = []
    for place, part in enumerate(parts, 1):
        listed = [f"{MAKER},{one.identifier},{one.instance},{one.revision}" for one in part]
        head = f"{TALKER}ALC,{len(parts):02d},{place:02d},{number % 100:02d},{len(part)}"
        lines.append(with_checksum(",".join([head, *listed])))
    return lines


def hbt(sound: bool, number: int) -> str:
    return with_checksum(f"{TALKER}HBT,{settings.HEARTBEAT:.1f},{'A' if sound else 'V'},{number % 10}")


def arc(refused: AlertCommand, since_1970: float) -> str:
    which = f"{MAKER},{refused.identifier},{refused.instance}"
    return with_checksum(f"{TALKER}ARC,{_clock(since_1970)},{which},{refused.command.value}")


def _clock(since_1970: float) -> str:
    at = datetime.fromtimestamp(since_1970, UTC)
    return f"{at:%H%M%S}.{at.microsecond // 10_000:02d}"


def _escaped(text: str) -> str:
    """Return a reserved character as a circumflex and two digits."""
    return RESERVED.sub(lambda match: "".join(f"^{byte:02X}" for byte in match[0].encode("latin-1", "replace")), text)


# Notifications of Signal K (specification 1.7): all situations in one delta, so that the newest is complete.
STATES = {
    Priority.CAUTION: "alert", Priority.WARNING: "warn", Priority.ALARM: "alarm",
    Priority.EMERGENCY_ALARM: "emergency",
}  # fmt: skip
SOURCE = "narrows"


def notifications(desk: AlertDesk | None, since_1970: float) -> dict[str, Any]:
    """Return the delta of all alerts; without a desk that of a monitor that has ended: nothing is alerted any more."""
    pairs = []
    for alert in desk or AlertDesk():
        value: dict[str, Any] = {"state": "normal", "method": [], "message": "" if desk else "The monitor has ended."}
        if alert.holds:
            seen = alert.state in (AlertState.UNACKNOWLEDGED, AlertState.SILENCED)
            methods = ["visual"] * seen + ["sound"] * alert.sounds
            value = {"state": STATES[alert.priority], "method": methods, "message": alert.text}
        first, *others = alert.name.lower().split()
        pairs.append({"path": f"notifications.{SOURCE}.{first}{''.join(map(str.title, others))}", "value": value})
    stamp = datetime.fromtimestamp(since_1970, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    return {"context": "vessels.self", "updates": [{"$source": SOURCE, "timestamp": stamp, "values": pairs}]}


Send = Callable[[str], None]


class AlertPublisher:
    def __init__(
        self, log: AlertLog | None = None, send: Send | None = None, servers: Sequence["SignalKSender"] = ()
    ) -> None:
        self.log, self.send, self.servers, self.late = log, send or (lambda sentence: None), servers, ""
        self._numbers = {name: count() for name in ("alf", "alc", "hbt")}
        self._listed = self._beaten = -settings.HEARTBEAT

    def publish(self, changed: Sequence[Alert], since_1970: float) -> None:
        for alert in changed:
            if self.log is not None:
                written = self.log.alert(alert)
                self.late = "" if written else f"alerts are not on disk: {self.log.trouble or 'it does not answer'}"
            for sentence in alf(alert, since_1970, next(self._numbers["alf"])):
                self.send(sentence)

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


class SignalKSender(AbstractContextManager["SignalKSender"]):
    """Sends the newest of all alerts, each time that they change; all of them after every new connection."""

    # When it ends it sends that nothing is alerted any more: a server keeps the last message.

    def __init__(self, address: str) -> None:
        with needs("monitor", "Signal K"):
            from websockets.sync.client import connect
        parts = urlsplit(address)
        if parts.scheme not in ("ws", "wss") or not parts.netloc:
            raise InputError(f"{address}: is no address of Signal K; write it as in ws://192.168.1.20:3000")
        self.address = address if parts.path.strip("/") else f"{parts.scheme}://{parts.netloc}{STREAM}"
        self._connect, self._newest = connect, dict[str, Any]()
        self._changed, self._stop = Event(), Event()
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def __exit__(self, *error: object) -> None:
        self._newest = self._newest and notifications(None, time.time())
        self._stop.set()
        self._changed.set()
        self._thread.join(settings.LAST_MESSAGE_TIMEOUT)

    def send(self, desk: AlertDesk, since_1970: float) -> None:
        """Leave the alerts as they are, without waiting for anything."""
        self._newest = notifications(desk, since_1970)
        self._changed.set()

    def _run(self) -> None:
        from websockets.exceptions import WebSocketException

        pause = settings.FIRST_PAUSE
        while not self._stop.is_set():
            try:
                with self._connect(self.address, open_timeout=settings.OPEN_TIMEOUT) as server:
                    sent, ends = None, False
                    while not ends:
                        self._changed.clear()
                        ends, newest = self._stop.is_set(), self._newest
                        if newest and newest["updates"][0]["values"] != sent:
                            server.send(to_json(newest))
                            sent = newest["updates"][0]["values"]
                        with suppress(TimeoutError):  # A connection that is never read breaks unnoticed
                            while True:
                                server.recv(0.0)
                        pause = settings.FIRST_PAUSE
                        self._changed.wait(0.0 if ends else settings.READ_TIMEOUT)
            except (OSError, WebSocketException):
                self._stop.wait(pause)
                pause = min(2 * pause, settings.LONGEST_PAUSE)
