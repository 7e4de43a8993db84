"""When each sentence of a recording was measured: by the logger, by its own clock, or evenly between such sentences."""

from collections.abc import Iterable, Iterator
from datetime import UTC, date, datetime
from typing import NamedTuple

from narrows.readers.nmea.nmea_lines import Sentence
from narrows.readers.nmea.nmea_sentences import Telling

DAY = 86400.0
EPOCH = date(1970, 1, 1)


class Entry(NamedTuple):
    """What a sentence tells, and when."""

    t: float  # Since the recording began [s]
    told: Telling  # What


class Clock:
    """Puts sentences in time."""

    def __init__(self, logged: bool, day: date | None = None) -> None:
        self.logged, self.day = logged, day
        self.begin: float | None = None
        self.lost = 0
        self._midnight = DAY * (day - EPOCH).days if day else 0.0
        self._last = -DAY

    def entries(self, told: Iterable[tuple[Sentence, Telling]]) -> Iterator[Entry]:
        """Yield sentences with their times; those before the first time that is told are lost."""
        # told (Sentence, Telling)
        waiting: list[Telling] = []
        before: float | None = None
        for sentence, one in told:
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
        """Date and time at which t is 0; None where only the time of the day is known."""
        dated = self.begin is not None and (self.logged or self.day is not None)
        return datetime.fromtimestamp(self.begin or 0.0, UTC) if dated else None

    def _since_begin(self, sentence: Sentence, told: Telling) -> float | None:
        now = sentence.logged if self.logged else self._by_clock(told)
        if now is None:
            return None
        self.begin = now if self.begin is None else self.begin
        return now - self.begin

    def _by_clock(self, told: Telling) -> float | None:
        """Seconds since 1970, or since midnight of a day that nothing tells, of the clock inside a sentence."""
        if told.clock is None:
            return None
        at = told.clock
        seconds = 3600.0 * at.hour + 60.0 * at.minute + at.second + 1e-6 * at.microsecond
        if told.day is not None:
            self._midnight = DAY * (told.day - EPOCH).days
        elif seconds < self._last - DAY / 2:
            self._midnight += DAY
        self._last = seconds
        return self._midnight + seconds


def _between(before: float, now: float, waiting: list[Telling]) -> Iterator[Entry]:
    """Sentences without a clock, evenly between those with one."""
    step = max(now - before, 0.0) / (len(waiting) + 1)
    yield from (Entry(before + step * place, one) for place, one in enumerate(waiting, 1))
