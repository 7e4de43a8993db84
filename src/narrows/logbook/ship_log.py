"""A ship's own records, together, and the waterway that they are of."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.logbook.ship_record import SIGNALS, ShipRecord
from narrows.results import BaseResult
from narrows.waterway import Waterway

if TYPE_CHECKING:
    import pandas as pd
    import xarray


@dataclass(frozen=True, repr=False, eq=False)
class ShipLog(BaseResult):
    """Records of one ship: manoeuvres, transits.

    Parameters
    ----------
    records : tuple of ShipRecord
        In their order.
    waterway : Waterway, optional
        Line of x, y, psi and course; a plane without one.
    notes : tuple of str
        Notes of the reader: interpretation of columns, rows left out.

    Raises
    ------
    InputError
        Where two records share a name.

    Examples
    --------
    >>> signal = nw.Signal(np.array([0.0, 1.0]), np.array([2.0, 3.0]))
    >>> len(nw.ShipLog((nw.ShipRecord("A", {"u": signal}),)).records)
    1
    """

    records: tuple[ShipRecord, ...]
    waterway: Waterway | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        twice = [name for name, count in Counter(self.names).items() if count > 1]
        if twice:
            raise InputError(f"two records are called {twice[0]!r}; give each a name of its own")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the records."""
        return tuple(record.name for record in self.records)

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[ShipRecord]:
        return iter(self.records)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def __getitem__(self, key: str | int) -> ShipRecord:
        if isinstance(key, str):
            if key not in self.names:
                raise InputError(f"there is no record {key!r}{did_you_mean(key, self.names)}")
            return self.records[self.names.index(key)]
        if not -len(self) <= key < len(self):
            raise InputError(f"there is no record {key}: they count from 0 to {len(self) - 1}; choose another")
        return self.records[key]

    def select(self, *names: str) -> "ShipLog":
        """Return some of the records, in the order given.

        Parameters
        ----------
        *names : str
            Names of the records to keep.

        Raises
        ------
        InputError
            Where there is no such record.
        """
        return replace(self, records=tuple(self[name] for name in names))

    def drop(self, *names: str) -> "ShipLog":
        """Return all records but some.

        Parameters
        ----------
        *names : str
            Names of the records to leave out.

        Raises
        ------
        InputError
            Where there is no such record, or none is left.
        """
        out = {self[name].name for name in names}
        if not (left := [name for name in self.names if name not in out]):
            raise InputError("no record is left after the selection; leave out fewer")
        return self.select(*left)

    @property
    def counts(self) -> dict[str, int]:
        """Values of each signal in all records."""
        return {
            name: count for name in SIGNALS if (count := sum(len(own[name]) for own in self.records if name in own))
        }

    def summary(self) -> str:
        """Number of records, their duration and their signals."""
        hours = sum(record.duration for record in self.records if np.isfinite(record.duration)) / 3600
        lasting = f"{hours:.3g} h" if hours >= 1 else f"{60 * hours:.3g} min"
        where = f" along {self.waterway.name}" if self.waterway else ""
        several = "record" if len(self) == 1 else "records"
        return f"{len(self)} {several}, {lasting} together{where}, with {', '.join(self.counts) or 'no signal'}."

    def to_dict(self) -> dict[str, Any]:
        """Give what each record holds by name: from when to when, values of each signal, antenna and condition."""
        return {
            "records": {record.name: _held(record) for record in self.records},
            "waterway": self.waterway.name if self.waterway else None,
            "signals": {name: SIGNALS[name].unit for name in self.counts},
            "summary": self.summary(), "notes": list(self.notes),
        }  # fmt: skip

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the rows as a table that ``read_log`` reads again: record, t, and a column for each signal."""
        import pandas as pd

        frames = {record.name: record.to_dataframe() for record in self.records}
        rows = pd.concat(frames, names=["record"]).reset_index() if frames else pd.DataFrame({"record": [], "t": []})
        return rows[["record", "t", *self.counts]]

    def dataset(self) -> "xarray.Dataset":
        """Return the rows as an xarray Dataset with units: NaN where a signal was not measured."""
        import xarray

        rows = self.to_dataframe()
        variables: Mapping[str, Any] = {
            name: ("row", rows[name].to_numpy(), {"units": SIGNALS[name].unit, "long_name": SIGNALS[name].meaning})
            for name in self.counts
        }
        time = ("row", rows["t"].to_numpy(float), {"units": "s", "long_name": "time"})
        coordinates = {"record": ("row", rows["record"].to_numpy()), "t": time}
        attributes = {"summary": self.summary(), "notes": "\n".join(self.notes)}
        return xarray.Dataset(variables, coords=coordinates, attrs=attributes)


def _held(record: ShipRecord) -> dict[str, Any]:
    return {
        "start": record.start, "stop": record.stop, "antenna": list(record.antenna),
        "condition": dict(record.condition), "values": {name: len(own) for name, own in record.signals.items()},
    }  # fmt: skip
