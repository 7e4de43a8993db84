"""Sentences as they are understood, one after the other; what cannot be is counted, and so are other ships."""

from collections import Counter, OrderedDict
from typing import NamedTuple

from narrows.errors import needs
from narrows.readers.nmea.nmea_lines import Sentence
from narrows.readers.nmea.nmea_sentences import Telling, told_by

# Whose reports are counted; then the half of them that were heard least is forgotten.
MOST_SHIPS = 2000


class Hearing:
    """Understands sentences."""

    def __init__(self, mmsi: int | None = None) -> None:
        with needs("nmea", "NMEA 0183"):
            import pyais  # noqa: F401
            import pynmeagps  # noqa: F401
        self.mmsi = mmsi
        self.forget()

    def forget(self) -> None:
        """Count from nothing."""
        self.faults: Counter[str] = Counter()
        self.ships: Counter[str] = Counter()
        self._fragments = AisFragments(self.faults)

    def told(self, sentence: Sentence, t: float = 0.0) -> Telling | None:
        """Return what a sentence tells; None where it tells nothing here, or cannot be understood."""
        # t [s]
        ais = sentence.kind.endswith(("VDO", "VDM"))
        parts = self._fragments.whole(sentence.text, t) if ais else (sentence.text,)
        if parts is None:
            return None
        try:
            told = told_by(parts, sentence.kind, self.mmsi)
        except Exception:  # The parsers raise nearly anything on fields that are none.
            self.faults["that cannot be understood"] += 1
            return None
        if told is not None and sentence.kind.endswith("VDM") and not told.values:
            self._count(told.source.split()[-1])
        return told

    def _count(self, ship: str) -> None:
        self.ships[ship] += 1
        if len(self.ships) > MOST_SHIPS:
            self.ships = Counter(dict(self.ships.most_common(MOST_SHIPS // 2)))


# AIS messages of several sentences: joined where they belong together beyond doubt, given up where they may not.
# For the next part of a message [s].
WAITS = 2.0

# Messages that wait at once; then the oldest is given up.
MOST_OPEN = 256

GIVEN_UP = "of AIS messages whose parts did not come together"

Key = tuple[bytes, bytes, bytes, bytes]


class Waiting(NamedTuple):
    """A message whose parts are not all there."""

    t: float  # When the last part came [s]
    parts: tuple[bytes, ...]  # So far; empty where two ships used one number at once, so that neither's can be told


class AisFragments:
    """Joins the parts of AIS messages, in the order in which they come."""

    # Parts carry no name of their ship, but a number from 0 to 9 that ships share. Parts that come out of order, too
    # late, or while another message of that number and channel is open, are given up, all of them.

    def __init__(self, faults: Counter[str]) -> None:
        self.faults = faults
        self._open: OrderedDict[Key, Waiting] = OrderedDict()

    def whole(self, text: bytes, t: float = 0.0) -> tuple[bytes, ...] | None:
        """Return the sentences of a message that a sentence completes; None where it does not."""
        # t [s]
        fields = text.split(b",", 5)
        if len(fields) < 6:
            return None
        kind, total, number, sequence, channel = fields[:5]
        if total == b"1":
            return (text,)
        self._forget(t)
        return self._joined((kind, total, sequence, channel), number, text, t)

    def __len__(self) -> int:
        """How many messages wait."""
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
        """Count the parts that are there and this one; nothing of that number is believed until it has been silent."""
        self.faults[GIVEN_UP] += 1 + (len(waiting.parts) if waiting else 0)
        if waiting is not None:
            self._open[key] = Waiting(t, ())

    def _forget(self, t: float) -> None:
        """Give up what waits for too long; where the time went back, everything."""
        while self._open:
            key, oldest = next(iter(self._open.items()))
            if 0.0 <= t - oldest.t <= WAITS and len(self._open) <= MOST_OPEN:
                return
            del self._open[key]
            self.faults[GIVEN_UP] += len(oldest.parts)
