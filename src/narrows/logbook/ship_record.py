"""One manoeuvre or transit, as the ship's sensors recorded it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.logbook.signals import Signal, check_signals

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class ShipRecord:
    """One manoeuvre or transit: signals in SI and rad, in the package's axes and signs (see ``SIGNALS``).

    Parameters
    ----------
    name : str
        Of the record.
    signals : mapping of str to Signal
        By name.
    antenna : pair of float [m]
        Of the position that ``x`` and ``y`` tell: forward and to starboard of midship.
    condition : mapping of str to float
        What the ship was loaded to and the like, as in ``{"draft": 10.2}``.

    Raises
    ------
    InputError
        Where a name is no signal's, what it names is none, or the antenna is not two numbers.
    """

    name: str
    signals: Mapping[str, Signal]
    antenna: tuple[float, float] = (0.0, 0.0)
    condition: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_signals(self.signals)
        for name, signal in self.signals.items():
            if not isinstance(signal, Signal):
                raise InputError(f"record {self.name}: {name} is a {type(signal).__name__}; give nw.Signal(t, values)")
        if np.shape(self.antenna) != (2,) or not np.isfinite(self.antenna).all():
            raise InputError(f"record {self.name}: an antenna stands forward and to starboard of midship; give both")

    def __getitem__(self, name: str) -> Signal:
        """A signal."""
        if name not in self.signals:
            raise InputError(f"record {self.name} has no signal {name!r}{did_you_mean(name, self.signals)}")
        return self.signals[name]

    def __contains__(self, name: object) -> bool:
        """Whether there is such a signal."""
        return name in self.signals

    def __iter__(self) -> Iterator[str]:
        """The names of its signals."""
        return iter(self.signals)

    @property
    def start(self) -> float:
        """Earliest time of any signal [s]; NaN where there is none."""
        return min((float(signal.t.min()) for signal in self.signals.values() if len(signal)), default=np.nan)

    @property
    def stop(self) -> float:
        """Latest time of any signal [s]; NaN where there is none."""
        return max((float(signal.t.max()) for signal in self.signals.values() if len(signal)), default=np.nan)

    @property
    def duration(self) -> float:
        """From the earliest time to the latest [s]."""
        return self.stop - self.start

    def between(self, start: float, stop: float) -> "ShipRecord":
        """Return the part from one time to another, both included.

        Parameters
        ----------
        start, stop : float [s]
            From when to when.
        """
        return replace(self, signals={name: own.between(start, stop) for name, own in self.signals.items()})

    def with_signals(self, **signals: Signal) -> "ShipRecord":
        """Return the record with some signals added or replaced.

        Parameters
        ----------
        **signals : Signal
            By name.

        Raises
        ------
        InputError
            Where a name is no signal's.
        """
        check_signals(signals)
        return replace(self, signals={**self.signals, **signals})

    def over_ground(self, longest: float = 10.0) -> tuple[Signal, Signal] | None:
        """Return the velocities over ground along and across the ship [m/s], from speed and course where need be.

        Parameters
        ----------
        longest : float [s]
            Between two courses, or two headings, over which they are still joined.

        Returns
        -------
        pair of Signal, or None
            None where nothing tells them.
        """
        if "u_ground" in self and "v_ground" in self:
            return self["u_ground"], self["v_ground"]
        if not {"speed_over_ground", "course", "psi"} <= self.signals.keys():
            return None
        speed = self["speed_over_ground"]
        drift = self["course"].at(speed.t, longest) - self["psi"].at(speed.t, longest)
        known = np.isfinite(drift)
        t, ahead, drift = speed.t[known], speed.values[known], drift[known]
        return Signal(t, ahead * np.cos(drift)), Signal(t, ahead * np.sin(drift))

    def to_dataframe(self) -> "pd.DataFrame":
        """Give a row for each time at which anything was measured: NaN where that signal was not."""
        import pandas as pd

        columns = [pd.Series(own.values, index=own.t, name=name) for name, own in self.signals.items()]
        once = [column[~column.index.duplicated()] for column in columns]
        frame = pd.concat(once, axis="columns").sort_index() if once else pd.DataFrame()
        return frame.rename_axis("t")
