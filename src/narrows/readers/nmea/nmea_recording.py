"""A recording of NMEA 0183: its sentences with their times, and whom to believe of those who tell the same."""

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

from narrows.progress import opened
from narrows.readers.nmea.nmea_clock import Clock, Entry
from narrows.readers.nmea.nmea_hearing import Hearing
from narrows.readers.nmea.nmea_lines import SENTENCE, Sentence, sentences
from narrows.readers.nmea.nmea_sentences import Telling
from narrows.readers.nmea.nmea_sources import Sources

# Bytes of a file by which a recording is recognised.
SNIFFED = 1 << 16
# Sentences that are looked at to choose who tells what.
SAMPLE = 20_000
MOSTLY = 0.5


def is_nmea(path: Path) -> bool:
    """Say whether a file is a recording of NMEA 0183."""
    with path.open("rb") as file:
        lines = [line for line in file.read(SNIFFED).splitlines() if line.strip()]
    found = sum(bool((match := SENTENCE.search(line)) and match[3]) for line in lines)
    return bool(lines) and found > MOSTLY * len(lines)


class Recording:
    """What a recording tells, sentence by sentence."""

    def __init__(self, path: Path, mmsi: int | None = None) -> None:
        self.path, self.hearing = path, Hearing(mmsi)
        self.sources, self.clock = Sources(), Clock(logged=False)

    @property
    def faults(self) -> Counter[str]:
        """Sentences that were left out, by what is wrong with them."""
        return self.hearing.faults

    def entries(self) -> Iterator[Entry]:
        """Yield what the sentences tell, and when; who is believed is chosen by the first of them."""
        self._begin()
        with opened(self.path) as file:
            yield from self.clock.entries(self._told(file))

    def _begin(self) -> None:
        with self.path.open("rb") as file:
            sample = list(islice(self._told(file), SAMPLE))
        self.hearing.forget()
        logged = sum(sentence.logged is not None for sentence, _ in sample)
        day = next((told.day for _, told in sample if told.day), None)
        self.sources, self.clock = Sources(told for _, told in sample), Clock(logged > MOSTLY * len(sample), day)

    def _told(self, lines: Iterable[bytes]) -> Iterator[tuple[Sentence, Telling]]:
        """Sentences that tell something here."""
        for sentence in sentences(lines, self.hearing.faults):
            told = self.hearing.told(sentence, sentence.logged or 0.0)
            if told is not None:
                yield sentence, told
