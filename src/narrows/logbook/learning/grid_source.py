"""Records as the search asks for them: laid out one by one, long ones in parts, the useless left out and said."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from narrows.errors import InputError
from narrows.logbook.learning.log_assumptions import LogAssumptions
from narrows.logbook.ship_log import ShipLog
from narrows.logbook.ship_record import ShipRecord
from narrows.logbook.shooting.record_grid import READ, RecordGrid, grid_of
from narrows.ship.particulars import Configuration

# Of a record that is taken as one [s]: what is the same all through it does not stay so for ever.
LONGEST = 6 * 3600.0
# Of a way, straight from one place to the next.
LEGS = 60
# Of a draft, by which a record may be of another.
OTHER_DRAFT = 0.02
# Values of a log that are kept laid out; of a longer one each record is laid out when its turn comes.
HELD_VALUES = 20_000_000


@dataclass(frozen=True)
class GridSource:
    """The records of a log, laid out on even times."""

    log: Iterable[ShipRecord]  # That can be gone through again and again
    assumptions: LogAssumptions  # How long steps and windows are
    usual: dict[str, float]  # Actuators, each with where it is if nothing was recorded of it
    configuration: Configuration  # The ship and the water that the model is of

    def __iter__(self) -> Iterator[RecordGrid]:
        """The records."""
        yield from self._held if self._held is not None else self._laid_out([])

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """What could not be used, and why."""
        notes: list[str] = []
        for _ in self._laid_out(notes):
            pass
        return tuple(dict.fromkeys(notes))

    @cached_property
    def _held(self) -> tuple[RecordGrid, ...] | None:
        if not isinstance(self.log, ShipLog) or sum(self.log.counts.values()) > HELD_VALUES:
            return None
        return tuple(self._laid_out([]))

    def _laid_out(self, notes: list[str]) -> Iterator[RecordGrid]:
        for record in self.log:
            for part in parts(record):
                try:
                    yield self._grid(part)
                except InputError as error:
                    notes.append(f"{error}.")

    def _grid(self, record: ShipRecord) -> RecordGrid:
        if "rudder" in self.usual and not ("rudder" in record and len(record["rudder"])):
            raise InputError(
                f"record {record.name} holds no rudder: what the bank did and what the helm did cannot be told apart"
            )
        draft = self.configuration.ship.draft
        if abs(record.condition.get("draft", draft) / draft - 1) > OTHER_DRAFT:
            raise InputError(
                f"record {record.name} is of a draft of {record.condition['draft']:.3g} m, the model of {draft:.3g} m: "
                "what it tells is of another ship; leave it out, or give a model of that draft"
            )
        window, step = self.assumptions.lengths(self.configuration.ship.length, speed_of(record))
        return grid_of(record, step, window, self.usual)


def parts(record: ShipRecord) -> Iterator[ShipRecord]:
    """Yield a record, a long one in equal parts."""
    count = int(np.ceil(record.duration / LONGEST)) if record.duration > LONGEST else 1
    if count == 1:
        yield record
        return
    edges = np.linspace(record.start, record.stop, count + 1)
    for number, (start, stop) in enumerate(pairwise(edges), start=1):
        yield replace(record.between(float(start), float(stop)), name=f"{record.name}, part {number}")


def speed_of(record: ShipRecord) -> float:
    """Return the usual speed of a record [m/s]."""
    for name in ("u", "u_ground", "speed_over_ground"):
        if name in record and len(record[name]):
            return max(float(np.median(np.abs(record[name].values))), 1e-3)
    if "x" in record and len(record["x"]) > 1:
        t = np.linspace(record["x"].t[0], record["x"].t[-1], LEGS)
        legs = [np.diff(np.interp(t, record[name].t, record[name].values)) for name in ("x", "y") if name in record]
        return max(float(np.linalg.norm(legs, axis=0).sum() / max(np.ptp(t), 1e-9)), 1e-3)
    raise InputError(f"record {record.name} holds no speed and no way; give one of {', '.join(READ)}")
