"""A recording of NMEA 0183: its sentences with times, and the choice among several sources of one quantity."""

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd

from narrows.errors import InputError
from narrows.progress import opened
from narrows.readers.nmea.nmea_decoder import Clock, Entry, NmeaDecoder
from narrows.readers.nmea.nmea_sentences import SENTENCE, SOURCES, DecodedMessage, Sentence, sentences
from narrows.readers.settings import NMEA_SHARE, SNIFFED, SOURCE_SENTENCES, TALKER_SILENCE


def is_nmea(path: Path) -> bool:
    with path.open("rb") as file:
        lines = [line for line in file.read(SNIFFED).splitlines() if line.strip()]
    found = sum(bool((match := SENTENCE.search(line)) and match[3]) for line in lines)
    return bool(lines) and found > NMEA_SHARE * len(lines)


class Recording:
    def __init__(self, path: Path, mmsi: int | None = None) -> None:
        self.path, self.decoder = path, NmeaDecoder(mmsi)
        self.sources, self.clock = Sources(), Clock(logged=False)

    @property
    def faults(self) -> Counter[str]:
        return self.decoder.faults

    def entries(self) -> Iterator[Entry]:
        self._begin()
        with opened(self.path) as file:
            yield from self.clock.entries(self._decoded(file))

    def _begin(self) -> None:
        with self.path.open("rb") as file:
            sample = list(islice(self._decoded(file), SOURCE_SENTENCES))
        self.decoder.forget()
        logged = sum(sentence.logged is not None for sentence, _ in sample)
        day = next((message.day for _, message in sample if message.day), None)
        self.sources, self.clock = Sources(one for _, one in sample), Clock(logged > NMEA_SHARE * len(sample), day)

    def _decoded(self, lines: Iterable[bytes]) -> Iterator[tuple[Sentence, DecodedMessage]]:
        for sentence in sentences(lines, self.decoder.faults):
            message = self.decoder.decode(sentence, sentence.logged or 0.0)
            if message is not None:
                yield sentence, message


class Sources:
    def __init__(self, sample: Iterable[DecodedMessage] = ()) -> None:
        counts: dict[str, Counter[str]] = {about: Counter() for about in SOURCES}
        for message in sample:
            for about, values in message.values.items():
                if values and about in counts:
                    counts[about][message.source] += 1
        self.chosen = {about: _best(found, SOURCES[about]) for about, found in counts.items() if found}
        self.used = {about: [source] for about, source in self.chosen.items()}
        self._last: dict[str, float] = {}

    def accepts(self, about: str, source: str, t: float) -> bool:
        chosen = self.chosen.setdefault(about, source)
        if source != chosen:
            # The talker stands first: a source of the same type and detail may replace it.
            if source[2:] != chosen[2:] or t - self._last.get(about, 0.0) < TALKER_SILENCE:
                return False
            self.chosen[about] = source
        used = self.used.setdefault(about, [])
        if source not in used:
            used.append(source)
        self._last[about] = t
        return True

    def words(self) -> str:
        return ", ".join(f"{about} by {' and '.join(used)}" for about, used in self.used.items())


def _best(found: Counter[str], types: tuple[str, ...]) -> str:
    return min(found, key=lambda source: (types.index(source.split()[0][-3:]), -found[source]))


class NmeaTable(Recording):
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
