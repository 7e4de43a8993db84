"""Alerts on their way out: into the log first, then to the bridge as sentences ALF, ALC, HBT and ARC; ACN comes in.

Source: Fields as printed in makers' manuals, after IEC 61162-1: JRC JLN-900 (2018), 3.1, and JFE-680, 4, for ALF, ALC,
HBT, ARC and ACN.
"""

import re
import socket
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from datetime import UTC, datetime
from itertools import count

from narrows.base.errors import InputError
from narrows.readers.nmea import with_checksum
from narrows.warning import settings
from narrows.warning.alerts.alert import MAKER, Alert, AlertCommand, AlertLog, AlertState

TALKER = "II"  # Integrated instrumentation
# Letters of the second sentence of an alert.
LONGEST_TEXT = 40
# Entries of a list in one sentence.
ENTRIES = 3
RESERVED = re.compile(r"[\r\n$*,!\\^~]|[^\x20-\x7d]")
# Letters of states. Makers' manuals contradict each other, so they can be changed.
LETTERS: Mapping[AlertState, str] = {
    AlertState.NORMAL: "N", AlertState.UNACKNOWLEDGED: "V", AlertState.SILENCED: "S", AlertState.ACKNOWLEDGED: "A",
    AlertState.RECTIFIED: "U",
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


Send = Callable[[str], None]


class AlertPublisher:
    def __init__(self, log: AlertLog | None = None, send: Send | None = None) -> None:
        self.log, self.send, self.late = log, send or (lambda sentence: None), ""
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
