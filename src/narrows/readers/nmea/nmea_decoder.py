"""Sentences of NMEA 0183 decoded one after the other, with their times, and the choice among sources of one quantity.

Invalid sentences and other ships are counted.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from datetime import UTC, date, datetime
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.base.errors import InputError, needs
from narrows.base.progress import opened
from narrows.readers import settings
from narrows.readers.nmea.nmea_sentences import SENTENCE, SOURCES, DecodedMessage, Sentence, decode_text, sentences


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

    def decode(self, sentence: Sentence) -> DecodedMessage | None:
        """Return the values of a sentence; None if it has none for this package, or is invalid."""
        try:
            message = decode_text(sentence.text, sentence.kind, self.mmsi)
        except Exception:  # The parsers raise many kinds of errors on bad fields
            self.faults["that cannot be understood"] += 1
            return None
        if message is not None and sentence.kind.endswith("VDM") and not message.values:
            self._count(message.source.split()[-1])
        return message

    def _count(self, ship: str) -> None:
        self.ships[ship] += 1
        if len(self.ships) > settings.MOST_SHIPS:
            self.ships = Counter(dict(self.ships.most_common(settings.MOST_SHIPS // 2)))


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
            clock = sentence.logged if self.logged else self._by_clock(one)
            if clock is None:
                waiting.append(one)
                continue
            self.begin = clock if self.begin is None else self.begin
            now = clock - self.begin
            if before is None:
                self.lost += len(waiting)
            else:  # Those without a clock, evenly between those with one
                step = max(now - before, 0.0) / (len(waiting) + 1)
                yield from (Entry(before + step * place, other) for place, other in enumerate(waiting, 1))
            waiting, before = [], now
            yield Entry(now, one)
        if before is not None:
            yield from (Entry(before, one) for one in waiting)

    @property
    def started(self) -> datetime | None:
        """Date and time at which t is 0; None if only the time of day is known."""
        dated = self.begin is not None and (self.logged or self.day is not None)
        return datetime.fromtimestamp(self.begin or 0.0, UTC) if dated else None

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


def is_nmea(path: Path) -> bool:
    with path.open("rb") as file:
        lines = [line for line in file.read(settings.SNIFFED).splitlines() if line.strip()]
    found = sum(bool((match := SENTENCE.search(line)) and match[3]) for line in lines)
    return bool(lines) and found > settings.NMEA_SHARE * len(lines)


class Recording:
    def __init__(self, path: Path, mmsi: int | None = None) -> None:
        if not path.is_file():
            raise InputError(f"{path}: there is no such file; check the path")
        self.path, self.decoder = path, NmeaDecoder(mmsi)
        self.sources, self.clock = Sources(), Clock(logged=False)

    @property
    def faults(self) -> Counter[str]:
        return self.decoder.faults

    def entries(self) -> Iterator[Entry]:
        with self.path.open("rb") as file:
            sample = list(islice(self._decoded(file), settings.SOURCE_SENTENCES))
        self.decoder.forget()
        logged = sum(sentence.logged is not None for sentence, _ in sample)
        day = next((message.day for _, message in sample if message.day), None)
        self.sources, self.clock = (
            Sources(one for _, one in sample),
            Clock(logged > settings.NMEA_SHARE * len(sample), day),
        )
        with opened(self.path) as file:
            yield from self.clock.entries(self._decoded(file))

    def _decoded(self, lines: Iterable[bytes]) -> Iterator[tuple[Sentence, DecodedMessage]]:
        for sentence in sentences(lines, self.decoder.faults):
            message = self.decoder.decode(sentence)
            if message is not None:
                yield sentence, message

    def frames(self, rows: int) -> Iterator[pd.DataFrame]:
        entries, first = self.entries(), 0
        while piece := list(islice(entries, rows)):
            frame = _frame(piece, self.sources, first)
            first += len(piece)
            if len(frame.columns) > 1:
                yield frame
        if not self.sources.chosen:
            ships = ", ".join(name for name, _ in self.decoder.ships.most_common(3))
            others = f"; AIS reports are of the ships {ships}: choose one by mmsi=" if ships else ""
            raise InputError(f"{self.path}: no sentence gives the position or motion of this ship{others}")

    def notes(self) -> tuple[str, ...]:
        clock = self.clock
        by = "the logger's times" if clock.logged else "the clocks in the sentences, evenly between them"
        start = f", from {clock.started.isoformat()}" if clock.started else ""
        left = [f"{count} sentences {what} were left out" for what, count in self.faults.items()]
        lost = [f"{clock.lost} sentences before the first time were left out"] if clock.lost else []
        return (f"{self.sources.words()}; timed by {by}{start}", *left, *lost)


class Sources:
    def __init__(self, sample: Iterable[DecodedMessage] = ()) -> None:
        counts: dict[str, Counter[str]] = {about: Counter() for about in SOURCES}
        for message in sample:
            for about, values in message.values.items():
                if values and about in counts:
                    counts[about][message.source] += 1
        self.chosen = {  # The best type, and of these the most frequent
            about: min(found, key=lambda source: (SOURCES[about].index(source.split()[0][-3:]), -found[source]))
            for about, found in counts.items() if found
        }  # fmt: skip
        self.used = {about: [source] for about, source in self.chosen.items()}
        self._last: dict[str, float] = {}

    def accepts(self, about: str, source: str, t: float) -> bool:
        chosen = self.chosen.setdefault(about, source)
        if source != chosen:
            # The talker stands first: a source of the same type and detail may replace it.
            if source[2:] != chosen[2:] or t - self._last.get(about, 0.0) < settings.TALKER_SILENCE:
                return False
            self.chosen[about] = source
        used = self.used.setdefault(about, [])
        if source not in used:
            used.append(source)
        self._last[about] = t
        return True

    def words(self) -> str:
        return ", ".join(f"{about} by {' and '.join(used)}" for about, used in self.used.items())


def _frame(entries: list[Entry], sources: Sources, first: int) -> pd.DataFrame:
    """One row per sentence; values of sources that were not chosen are skipped."""
    cells: dict[str, list[tuple[int, float]]] = {}
    for row, (t, message) in enumerate(entries):
        for about, values in message.values.items():
            if values and about in SOURCES and sources.accepts(about, message.source, t):
                for name, value in values.items():
                    cells.setdefault(name, []).append((row, value))
    columns = {"t": np.array([entry.t for entry in entries])}
    for name, pairs in cells.items():
        rows, values_of = zip(*pairs, strict=True)
        columns[name] = np.full(len(entries), np.nan)
        columns[name][list(rows)] = values_of
    return pd.DataFrame(columns, index=pd.RangeIndex(first, first + len(entries)))
