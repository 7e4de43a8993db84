"""A recording of NMEA 0183 as a table: a row a sentence."""

from collections.abc import Iterator
from itertools import islice

import numpy as np
import pandas as pd

from narrows.errors import InputError
from narrows.readers.nmea.nmea_clock import Entry
from narrows.readers.nmea.nmea_recording import Recording
from narrows.readers.nmea.nmea_sentences import SOURCES
from narrows.readers.nmea.nmea_sources import Sources


class NmeaTable(Recording):
    """A recording, read as a table."""

    def frames(self, rows: int) -> Iterator[pd.DataFrame]:
        """Yield the recording in the documented columns, SI, piece by piece."""
        entries, first = self.entries(), 0
        while piece := list(islice(entries, rows)):
            frame = _frame(piece, self.sources, first)
            first += len(piece)
            if len(frame.columns) > 1:
                yield frame
        if not self.sources.chosen:
            ships = ", ".join(name for name, _ in self.hearing.ships.most_common(3))
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


def _frame(entries: list[Entry], sources: Sources, first: int) -> pd.DataFrame:
    """A row a sentence; what is told by a source that is not chosen is passed over."""
    cells: dict[str, list[tuple[int, float]]] = {}
    for row, (t, told) in enumerate(entries):
        for about, values in told.values.items():
            if values and about in SOURCES and sources.tells(about, told.source, t):
                for name, value in values.items():
                    cells.setdefault(name, []).append((row, value))
    columns = {"t": np.array([entry.t for entry in entries])}
    for name, pairs in cells.items():
        rows, values_of = zip(*pairs, strict=True)
        columns[name] = np.full(len(entries), np.nan)
        columns[name][list(rows)] = values_of
    return pd.DataFrame(columns, index=pd.RangeIndex(first, first + len(entries)))
