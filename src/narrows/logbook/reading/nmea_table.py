"""A recording of NMEA 0183 as a table: which sentence tells what, a row a sentence."""

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd

from narrows.errors import InputError, needs
from narrows.logbook.reading.nmea_clock import Clock, Entry
from narrows.logbook.reading.nmea_lines import SENTENCE, Sentence, sentences
from narrows.logbook.reading.nmea_sentences import Telling, told_by
from narrows.logbook.reading.nmea_sources import Sources
from narrows.progress import opened

SNIFFED = 1 << 16
"""Bytes of a file by which a recording is recognised."""
SAMPLE = 20_000
"""Sentences that are looked at to choose who tells what."""
MOSTLY = 0.5


def is_nmea(path: Path) -> bool:
    """Say whether a file is a recording of NMEA 0183 (ours).

    Parameters
    ----------
    path : Path
        The file.
    """
    with path.open("rb") as file:
        lines = [line for line in file.read(SNIFFED).splitlines() if line.strip()]
    found = sum(bool((match := SENTENCE.search(line)) and match[3]) for line in lines)
    return bool(lines) and found > MOSTLY * len(lines)


class NmeaTable:
    """A recording, read as a table.

    Parameters
    ----------
    path : Path
        The file.
    mmsi : int, optional
        Whose AIS reports to read; what the ship reports of itself unless given.
    """

    def __init__(self, path: Path, mmsi: int | None = None) -> None:
        self.path, self.mmsi = path, mmsi
        self.faults: Counter[str] = Counter()
        self.heard: Counter[str] = Counter()
        self.sources, self.clock = Sources(), Clock(logged=False)

    def frames(self, rows: int) -> Iterator[pd.DataFrame]:
        """Yield the recording in the documented columns, SI, piece by piece (ours).

        Parameters
        ----------
        rows : int
            Of a piece, at most.

        Raises
        ------
        InputError
            Where the parsers are not installed, or no sentence tells anything.
        """
        with needs("nmea", "a recording of NMEA 0183"):
            import pyais  # noqa: F401
            import pynmeagps  # noqa: F401
        self._begin()
        first = 0
        with opened(self.path) as file:
            entries = self.clock.entries(self._told(file))
            while piece := list(islice(entries, rows)):
                frame = _frame(piece, self.sources, first)
                first += len(piece)
                if len(frame.columns) > 1:
                    yield frame
        if not self.sources.chosen:
            ships = ", ".join(name for name, _ in self.heard.most_common(3))
            heard = f"; it heard the ships {ships} by AIS: say whose reports to read, mmsi=" if ships else ""
            raise InputError(f"{self.path}: no sentence tells where this ship is or how it moves{heard}")

    def notes(self) -> tuple[str, ...]:
        """What there is to say of the recording once it is read."""
        clock = self.clock
        by = "the logger's times" if clock.logged else "the clocks in the sentences, evenly between them"
        start = f", from {clock.started.isoformat()}" if clock.started else ""
        left = [f"{count} sentences {what} were left out" for what, count in self.faults.items()]
        lost = [f"{clock.lost} sentences before the first time were left out"] if clock.lost else []
        return (f"{self.sources.words()}; timed by {by}{start}", *left, *lost)

    def _begin(self) -> None:
        """Choose sources and clock by the first sentences."""
        with self.path.open("rb") as file:
            sample = list(islice(self._told(file), SAMPLE))
        self.faults.clear()
        self.heard.clear()
        logged = sum(sentence.logged is not None for sentence, _ in sample)
        day = next((told.day for _, told in sample if told.day), None)
        self.sources, self.clock = Sources(told for _, told in sample), Clock(logged > MOSTLY * len(sample), day)

    def _told(self, lines: Iterable[bytes]) -> Iterator[tuple[Sentence, Telling]]:
        """Sentences that tell something here."""
        for sentence in sentences(lines, self.faults):
            try:
                told = told_by(sentence.text, sentence.kind, self.mmsi)
            except Exception:  # The parsers raise nearly anything on fields that are none.
                self.faults["that cannot be understood"] += 1
                continue
            if told is None:
                continue
            if sentence.kind.endswith("VDM") and not told.values:
                self.heard[told.source.split()[-1]] += 1
            yield sentence, told


def _frame(entries: list[Entry], sources: Sources, first: int) -> pd.DataFrame:
    """A row a sentence; what is told by a source that is not chosen is passed over."""
    cells: dict[str, list[tuple[int, float]]] = {}
    for row, (t, told) in enumerate(entries):
        for about, values in told.values.items():
            if values and sources.tells(about, told.source, t):
                for name, value in values.items():
                    cells.setdefault(name, []).append((row, value))
    columns = {"t": np.array([entry.t for entry in entries])}
    for name, pairs in cells.items():
        rows, values_of = zip(*pairs, strict=True)
        columns[name] = np.full(len(entries), np.nan)
        columns[name][list(rows)] = values_of
    return pd.DataFrame(columns, index=pd.RangeIndex(first, first + len(entries)))
