"""Listening to a ship's network: a thread a connection, and every second what was told in it."""

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from threading import Event, Thread

from narrows.readers.nmea.nmea_clock import Entry
from narrows.readers.nmea.nmea_hearing import Hearing
from narrows.readers.nmea.nmea_lines import Sentence, sentences
from narrows.readers.nmea.nmea_sentences import Telling
from narrows.warning.hearing.connections import Connection
from narrows.warning.hearing.inbox import Arrival, Inbox
from narrows.warning.hearing.line_splitter import LineSplitter
from narrows.warning.hearing.signal_k import deltas
from narrows.warning.hearing.tick import PERIOD, Tick

# Of a second that the reports of other ships may take.
SHARE = 0.2


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
