"""What came in a second."""

from collections.abc import Sequence
from typing import NamedTuple

from narrows.readers.nmea.nmea_clock import Entry

# Between updates [s].
PERIOD = 1.0


class Tick(NamedTuple):
    """All that was told until a time, since the one before."""

    t: float  # Until when [s]
    entries: Sequence[Entry]  # What was told, in order
    faults: dict[str, int]  # Messages that were left out so far, by what is wrong with them
    commands: Sequence[bytes] = ()  # Sentences by which the bridge answers alerts (ACN)
