"""What came in a second."""

from collections.abc import Sequence
from typing import NamedTuple

from narrows.readers.nmea.nmea_clock import Entry

PERIOD = 1.0
"""Between updates [s]."""


class Tick(NamedTuple):
    """All that was told until a time, since the one before.

    Parameters
    ----------
    t : float [s]
        Until when.
    entries : sequence of Entry
        What was told, in order.
    faults : dict of str to int
        Messages that were left out so far, by what is wrong with them.
    commands : sequence of bytes
        Sentences by which the bridge answers alerts (ACN).
    """

    t: float
    entries: Sequence[Entry]
    faults: dict[str, int]
    commands: Sequence[bytes] = ()
