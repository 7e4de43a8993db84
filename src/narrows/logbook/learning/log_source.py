"""Origin of a learned model: the log by its content and times, the sensors, the model before."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from narrows.logbook.ship_record import ShipRecord
from narrows.model.model import Model
from narrows.model.sections import Source

# Digits of a hash in a sentence.
HASH_DIGITS = 12
# Times after this one count from 1970 [s].
A_DATE = 1e8


@dataclass(frozen=True)
class LogSource:
    """Identification of a log."""

    name: str  # Name of the log
    sensors: str  # The grade that it was taken for
    sha256: str  # Hash of all names, times and values
    start: float  # Time of the first value [s]
    stop: float  # Time of the last value [s]

    @classmethod
    def of(cls, records: Iterable[ShipRecord], name: str, sensors: str) -> "LogSource":
        """Return the identification of a log: name, sensors, hash, first and last time."""
        hashed, start, stop = hashlib.sha256(), np.inf, -np.inf
        for record in records:
            hashed.update(record.name.encode())
            start, stop = min(start, record.start), max(stop, record.stop)
            for key in record:
                hashed.update(key.encode())
                for column in (record[key].t, record[key].values):
                    hashed.update(np.ascontiguousarray(column, float).tobytes())
        return cls(name, sensors, hashed.hexdigest(), float(start), float(stop))

    def after(self, prior: Model, records: int) -> Source:
        """Return the source of a learned model: the source of the prior model, then this log."""
        several = "1 record" if records == 1 else f"{records} records"
        text = (
            f"learned from {several} of the ship itself ({self.name}, {_when(self.start)} to {_when(self.stop)}, "
            f"sensors {self.sensors}, sha256 {self.sha256[:HASH_DIGITS]}...), "
            f"from the model {_hash_of(prior)[:HASH_DIGITS]}..."
        )
        before = prior.source
        return Source(*("; ".join(filter(None, pair)) for pair in (
            (before.text, text), (before.table, self.name), (before.sha256, self.sha256)
        )))  # fmt: skip


def _when(t: float) -> str:
    return f"{datetime.fromtimestamp(t, UTC):%Y-%m-%d %H:%M:%S} UTC" if t > A_DATE else f"{t:.0f} s"


def _hash_of(model: Model) -> str:
    """Return the hash of coefficients and covariance."""
    hashed = hashlib.sha256(repr(sorted(model.coefficients.items())).encode())
    hashed.update(np.ascontiguousarray(model.covariance, float).tobytes())
    return hashed.hexdigest()
