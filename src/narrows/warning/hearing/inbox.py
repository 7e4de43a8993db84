"""What came and waits to be understood: of the ship itself first, of others as far as there is time; bounded."""

from collections import deque
from threading import Lock
from typing import NamedTuple

from narrows.readers.nmea.nmea_lines import Sentence
from narrows.readers.nmea.nmea_sentences import Telling

# Messages that wait at most; of more the oldest are lost.
OWN, OTHERS = 20_000, 5_000


class Arrival(NamedTuple):
    """A message that came."""

    t: float  # When [s]
    message: Sentence | Telling  # A sentence that is still to be understood, or what was told


class Inbox:
    """Takes messages from several threads."""

    def __init__(self) -> None:
        self.lost = 0
        self._own: deque[Arrival] = deque(maxlen=OWN)
        self._others: deque[Arrival] = deque(maxlen=OTHERS)
        self._lock = Lock()

    def put(self, arrival: Arrival) -> None:
        """Add a message."""
        message = arrival.message
        queue = self._others if isinstance(message, Sentence) and message.kind.endswith("VDM") else self._own
        with self._lock:
            self.lost += len(queue) == queue.maxlen
            queue.append(arrival)

    def own(self) -> list[Arrival]:
        """Take all that the ship told of itself."""
        with self._lock:
            taken = list(self._own)
            self._own.clear()
        return taken

    def other(self) -> Arrival | None:
        """Take the oldest report of the others; None where there is none."""
        with self._lock:
            return self._others.popleft() if self._others else None
