"""Who tells what in a recording of NMEA 0183: the best sentence, and its likes where its talker falls silent."""

from collections import Counter
from collections.abc import Iterable

from narrows.readers.nmea.nmea_sentences import SOURCES, Telling

# Without a word [s], after which another talker of the same sentence is listened to: receivers change their names.
SILENT = 5.0


class Sources:
    """Chooses whom to believe."""

    def __init__(self, sample: Iterable[Telling] = ()) -> None:
        counts: dict[str, Counter[str]] = {about: Counter() for about in SOURCES}
        for told in sample:
            for about, values in told.values.items():
                if values and about in counts:
                    counts[about][told.source] += 1
        self.chosen = {about: _best(found, SOURCES[about]) for about, found in counts.items() if found}
        self.used = {about: [source] for about, source in self.chosen.items()}
        self._heard: dict[str, float] = {}

    def tells(self, about: str, source: str, t: float) -> bool:
        """Say whether a source is the one to listen to."""
        # t [s]
        chosen = self.chosen.setdefault(about, source)
        if source != chosen:
            if _type(source) != _type(chosen) or t - self._heard.get(about, 0.0) < SILENT:
                return False
            self.chosen[about] = source
        used = self.used.setdefault(about, [])
        if source not in used:
            used.append(source)
        self._heard[about] = t
        return True

    def words(self) -> str:
        """Say who told what."""
        return ", ".join(f"{about} by {' and '.join(used)}" for about, used in self.used.items())


def _type(source: str) -> str:
    """Type and detail, without the talker."""
    return source[2:]


def _best(found: Counter[str], types: tuple[str, ...]) -> str:
    """The source of the best type, and of that the one that tells most."""
    return min(found, key=lambda source: (types.index(source.split()[0][-3:]), -found[source]))
