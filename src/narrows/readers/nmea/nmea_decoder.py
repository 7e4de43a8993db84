"""Decoding of sentences one after the other; invalid ones and other ships are counted."""

from collections import Counter, OrderedDict
from collections.abc import Iterable, Iterator
from datetime import UTC, date, datetime
from typing import NamedTuple

from narrows.errors import needs
from narrows.readers.nmea.nmea_sentences import DecodedMessage, Sentence, decode_parts
from narrows.readers.settings import MOST_OPEN, MOST_SHIPS, PART_WAIT


class NmeaDecoder:
    def __init__(self, mmsi: int | None = None) -> None:
        with needs("nmea", "NMEA 0183"):
            import pyais  # noqa: F401
            import pynmeagps  # noqa: F401
        self.mmsi = mmsi
        self.forget()

    def forget(self) -> None:
        self.faults: Counter[str] = Counter()
        self.ships: Counter[str] = Counter()
        self._fragments = AisFragments(self.faults)

    def decode(self, sentence: Sentence, t: float = 0.0) -> DecodedMessage | None:
        """Return the values of a sentence; None if it has none for this package, or is invalid."""
        ais = sentence.kind.endswith(("VDO", "VDM"))
        parts = self._fragments.whole(sentence.text, t) if ais else (sentence.text,)
        if parts is None:
            return None
        try:
            message = decode_parts(parts, sentence.kind, self.mmsi)
        except Exception:  # The parsers raise many kinds of errors on bad fields
            self.faults["that cannot be understood"] += 1
            return None
        if message is not None and sentence.kind.endswith("VDM") and not message.values:
            self._count(message.source.split()[-1])
        return message

    def _count(self, ship: str) -> None:
        self.ships[ship] += 1
        if len(self.ships) > MOST_SHIPS:
            self.ships = Counter(dict(self.ships.most_common(MOST_SHIPS // 2)))


GIVEN_UP = "of AIS messages whose parts did not come together"
Key = tuple[bytes, bytes, bytes, bytes]


class Waiting(NamedTuple):
    """An incomplete message."""

    t: float  # Time of the last part [s]
    parts: tuple[bytes, ...]  # Parts so far; empty if two ships used one number at once


class AisFragments:
    """Joins the parts of AIS messages, in the order in which they come."""

    # Parts do not name their ship; they carry a number from 0 to 9 that ships share. Parts that come out of order, too
    # late, or while another message of that number and channel is open are all discarded.

    def __init__(self, faults: Counter[str]) -> None:
        self.faults = faults
        self._open: OrderedDict[Key, Waiting] = OrderedDict()

    def whole(self, text: bytes, t: float = 0.0) -> tuple[bytes, ...] | None:
        fields = text.split(b",", 5)
        if len(fields) < 6:
            return None
        kind, total, number, sequence, channel = fields[:5]
        if total == b"1":
            return (text,)
        self._forget(t)
        return self._joined((kind, total, sequence, channel), number, text, t)

    def __len__(self) -> int:
        return len(self._open)

    def _joined(self, key: Key, number: bytes, text: bytes, t: float) -> tuple[bytes, ...] | None:
        waiting = self._open.pop(key, None)
        first = number == b"1"
        if waiting is None and first:
            self._open[key] = Waiting(t, (text,))
        elif waiting is None or not waiting.parts or first or number != b"%d" % (len(waiting.parts) + 1):
            self._give_up(key, waiting, t)
        elif key[1] == number:
            return (*waiting.parts, text)
        else:
            self._open[key] = Waiting(t, (*waiting.parts, text))
        return None

    def _give_up(self, key: Key, waiting: Waiting | None, t: float) -> None:
        """Count these parts as lost; the number is not used until it has been silent."""
        self.faults[GIVEN_UP] += 1 + (len(waiting.parts) if waiting else 0)
        if waiting is not None:
            self._open[key] = Waiting(t, ())

    def _forget(self, t: float) -> None:
        """Discard parts that wait too long; if time goes back, all of them."""
        while self._open:
            key, oldest = next(iter(self._open.items()))
            if 0.0 <= t - oldest.t <= PART_WAIT and len(self._open) <= MOST_OPEN:
                return
            del self._open[key]
            self.faults[GIVEN_UP] += len(oldest.parts)


DAY = 86400.0
EPOCH = date(1970, 1, 1)


class Entry(NamedTuple):
    t: float  # Time since the start of the recording [s]
    message: DecodedMessage


class Clock:
    def __init__(self, logged: bool, day: date | None = None) -> None:
        self.logged, self.day = logged, day
        self.begin: float | None = None
        self.lost = 0
        self._midnight = DAY * (day - EPOCH).days if day else 0.0
        self._last = -DAY

    def entries(self, messages: Iterable[tuple[Sentence, DecodedMessage]]) -> Iterator[Entry]:
        waiting: list[DecodedMessage] = []
        before: float | None = None
        for sentence, one in messages:
            now = self._since_begin(sentence, one)
            if now is None:
                waiting.append(one)
                continue
            if before is None:
                self.lost += len(waiting)
            else:
                yield from _between(before, now, waiting)
            waiting, before = [], now
            yield Entry(now, one)
        if before is not None:
            yield from (Entry(before, one) for one in waiting)

    @property
    def started(self) -> datetime | None:
        """Date and time at which t is 0; None if only the time of day is known."""
        dated = self.begin is not None and (self.logged or self.day is not None)
        return datetime.fromtimestamp(self.begin or 0.0, UTC) if dated else None

    def _since_begin(self, sentence: Sentence, message: DecodedMessage) -> float | None:
        now = sentence.logged if self.logged else self._by_clock(message)
        if now is None:
            return None
        self.begin = now if self.begin is None else self.begin
        return now - self.begin

    def _by_clock(self, message: DecodedMessage) -> float | None:
        """Seconds since 1970, or since midnight of an unknown day, from the clock inside a sentence."""
        if message.clock is None:
            return None
        at = message.clock
        seconds = 3600.0 * at.hour + 60.0 * at.minute + at.second + 1e-6 * at.microsecond
        if message.day is not None:
            self._midnight = DAY * (message.day - EPOCH).days
        elif seconds < self._last - DAY / 2:
            self._midnight += DAY
        self._last = seconds
        return self._midnight + seconds


def _between(before: float, now: float, waiting: list[DecodedMessage]) -> Iterator[Entry]:
    """Times of sentences without a clock, evenly between those with one."""
    step = max(now - before, 0.0) / (len(waiting) + 1)
    yield from (Entry(before + step * place, one) for place, one in enumerate(waiting, 1))
