"""Alerts on their way out: into the log first, then to the bridge; lists and heartbeats in between."""

import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from itertools import count

from narrows.errors import InputError
from narrows.warning.alerts.alert import Alert
from narrows.warning.alerts.alert_log import AlertLog
from narrows.warning.alerts.alert_sentences import HEARTBEAT, AlertCommand, alc, alf, arc, hbt

# Between lists of alerts [s].
LIST_EVERY = 30.0
Send = Callable[[str], None]


class AlertPublisher:
    """Logs and sends."""

    def __init__(self, log: AlertLog | None = None, send: Send | None = None) -> None:
        self.log, self.send = log, send or (lambda sentence: None)
        self.late = ""
        self._numbers = {name: count() for name in ("alf", "alc", "hbt")}
        self._listed = self._beaten = -HEARTBEAT

    def publish(self, changed: Sequence[Alert], since_1970: float) -> None:
        """Log alerts that changed, and send them."""
        # since_1970 [s]
        for alert in changed:
            if self.log is not None:
                written = self.log.alert(alert)
                self.late = "" if written else f"alerts are not on disk: {self.log.trouble or 'it does not answer'}"
            for sentence in alf(alert, since_1970, next(self._numbers["alf"])):
                self.send(sentence)

    def refuse(self, command: AlertCommand, since_1970: float) -> None:
        """Say that a command is refused."""
        # since_1970 [s]
        self.send(arc(command, since_1970))

    def beat(self, t: float, alerts: Sequence[Alert], sound: bool) -> None:
        """Send the list of alerts and the heartbeat where they are due."""
        # t [s]
        if t - self._listed >= LIST_EVERY:
            self._listed = t
            for sentence in alc(alerts, next(self._numbers["alc"])):
                self.send(sentence)
        if t - self._beaten >= HEARTBEAT:
            self._beaten = t
            self.send(hbt(sound, next(self._numbers["hbt"])))


@contextmanager
def sender_to(address: str) -> Iterator[Send]:
    """Open what sends sentences as datagrams."""
    host, _, port = address.removeprefix("udp://").rpartition(":")
    if not address.startswith("udp://") or not host or not port.isdecimal() or int(port) > 65_535:
        raise InputError(f"{address}: alerts go out by UDP; write the address as in udp://239.192.0.1:60001")
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as udp:

        def send(sentence: str) -> None:
            with suppress(OSError):  # Nobody listens, or there is no network: the log and the screen have it.
                udp.sendto(sentence.encode("ascii"), (host, int(port)))

        yield send
