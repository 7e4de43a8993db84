"""Whom to believe while a ship sails, of several that tell the same: the best that is not silent."""

from typing import NamedTuple

from narrows.readers.nmea.nmea_sentences import SOURCES

# Without a word [s], after which another is listened to.
SILENT = 5.0


class Chosen(NamedTuple):
    """Who is believed."""

    rank: int  # Of what it is, the best 0
    source: str  # Who
    t: float  # When it was heard last [s]


class LiveChoice:
    """Chooses, for each thing that is told."""

    def __init__(self) -> None:
        self.chosen: dict[str, Chosen] = {}

    def tells(self, about: str, source: str, t: float) -> bool:
        """Say whether a source is the one to believe."""
        # t [s]
        now, rank = self.chosen.get(about), _rank(about, source)
        if now and source != now.source and rank >= now.rank and t - now.t <= SILENT:
            return False
        self.chosen[about] = Chosen(rank, source, t)
        return True


def _rank(about: str, source: str) -> int:
    """By the type of its sentence; last what comes by other ways."""
    types, kind = SOURCES.get(about, ()), source.split()[0][-3:]
    return types.index(kind) if kind in types else len(types)
