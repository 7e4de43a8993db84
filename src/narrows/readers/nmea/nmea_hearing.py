"""Sentences as they are understood, one after the other; what cannot be is counted, and so are other ships."""

from collections import Counter

from narrows.errors import needs
from narrows.readers.nmea.ais_fragments import AisFragments
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
