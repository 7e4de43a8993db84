"""A ship's own log: signals, records of manoeuvres and transits, their waterway, and errors of the sensors by grade."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.errors import InputError, check_choice, did_you_mean
from narrows.base.results import Aliased, BaseResult, BaseSummary
from narrows.quantities.names import DEGREE, KNOT, Quantity
from narrows.ship.checks import check_sizes
from narrows.waterway import Waterway

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Signal:
    """One measured quantity at its own times, as received: uneven, with gaps.

    Raises an InputError where the two are not of one length, or a number is not finite.

    Examples
    --------
    >>> nw.Signal(np.array([0.0, 1.0]), np.array([2.0, 3.0])).values.tolist()
    [2.0, 3.0]
    """

    t: np.ndarray  #: (n,) Times [s]
    values: np.ndarray  #: (n,) In the unit of ``SIGNALS``

    def __post_init__(self) -> None:
        if np.ndim(self.t) != 1 or np.shape(self.t) != np.shape(self.values):
            raise InputError(
                f"a signal with {np.size(self.t)} times and {np.size(self.values)} values; give one value for each time"
            )
        if not (np.isfinite(self.t).all() and np.isfinite(self.values).all()):
            raise InputError("a signal holds what is not finite; leave out the times at which nothing was measured")

    def __len__(self) -> int:
        return len(self.t)

    @property
    def step(self) -> float:
        """Usual time between two values [s]; infinite where there are fewer than two."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else np.inf

    def between(self, start: float, stop: float) -> "Signal":
        """Return the part from ``start`` to ``stop`` [s], both included."""
        kept = (self.t >= start) & (self.t <= stop)
        return Signal(self.t[kept], self.values[kept])

    def at(self, t: np.ndarray, longest: float = np.inf) -> np.ndarray:
        """Interpolate linearly at times ``t`` [s]; NaN outside the signal and in gaps longer than ``longest`` [s].

        The signal's own times must rise.
        """
        if not len(self.t):
            return np.full(np.shape(t), np.nan)
        values = np.interp(t, self.t, self.values, left=np.nan, right=np.nan)
        after = np.clip(np.searchsorted(self.t, t), 1, max(len(self.t) - 1, 1))
        wide = np.diff(self.t, append=self.t[-1])[after - 1] > longest
        return np.where(wide & ~np.isin(t, self.t), np.nan, values)


@dataclass(frozen=True, eq=False)
class ShipRecord(Aliased):
    """One manoeuvre or transit: signals in SI and rad, in the package's axes and signs (see ``SIGNALS``).

    Raises an InputError where a name is no signal's, what it names is none, or the antenna is not two numbers.

    Examples
    --------
    >>> record = nw.ShipRecord("A", {"u": nw.Signal(np.array([0.0, 1.0]), np.array([2.0, 3.0]))})
    >>> sorted(record.signals)
    ['u']
    """

    name: str  #: Name of the record
    signals: Mapping[str, Signal]  #: Its signals by name
    #: Place of the antenna of ``x`` and ``y``: forward and to starboard of midship [m]
    antenna: tuple[float, float] = (0.0, 0.0)
    condition: Mapping[str, float] = field(default_factory=dict)  #: Loading, as in ``{"draft": 10.2}``

    def __post_init__(self) -> None:
        check_signals(self.signals)
        for name, signal in self.signals.items():
            if not isinstance(signal, Signal):
                raise InputError(f"record {self.name}: {name} is a {type(signal).__name__}; give nw.Signal(t, values)")
        if np.shape(self.antenna) != (2,) or not np.isfinite(self.antenna).all():
            raise InputError(f"record {self.name}: an antenna stands forward and to starboard of midship; give both")

    def __getitem__(self, name: str) -> Signal:
        if name not in self.signals:
            raise InputError(f"record {self.name} has no signal {name!r}{did_you_mean(name, self.signals)}")
        return self.signals[name]

    def __contains__(self, name: object) -> bool:
        return name in self.signals

    def __iter__(self) -> Iterator[str]:
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
        """Time between the first and the last value [s]."""
        return self.stop - self.start

    def between(self, start: float, stop: float) -> "ShipRecord":
        """Return the part from ``start`` to ``stop`` [s], both included."""
        return replace(self, signals={name: own.between(start, stop) for name, own in self.signals.items()})

    def with_signals(self, **signals: Signal) -> "ShipRecord":
        """Return the record with some ``signals`` added or replaced, by name."""
        return replace(self, signals={**self.signals, **signals})

    def to_dataframe(self) -> "pd.DataFrame":
        """Give a row for each time at which anything was measured: NaN where that signal was not."""
        import pandas as pd

        columns = {name: pd.Series(own.values, index=own.t) for name, own in self.signals.items()}
        once = {name: column[~column.index.duplicated()] for name, column in columns.items()}
        return pd.DataFrame(once).sort_index().rename_axis("t")


MEETING = "meeting"

# Every signal: its unit and meaning.
SIGNALS = {
    "x": Quantity("m", "antenna or reference point along the waterway, or along the axis that psi is measured from"),
    "y": Quantity("m", "antenna or reference point to starboard of the centreline, or of that axis"),
    "psi": Quantity("rad", "heading from that axis or from the waterway's line, positive to starboard, without jumps"),
    "r": Quantity("rad/s", "yaw rate, positive to starboard"),
    "u": Quantity("m/s", "surge velocity through the water"),
    "v": Quantity("m/s", "sway velocity through the water, positive to starboard"),
    "u_ground": Quantity("m/s", "velocity over ground along the ship"),
    "v_ground": Quantity("m/s", "velocity over ground across the ship, positive to starboard"),
    "speed_over_ground": Quantity("m/s", "speed over ground"),
    "course": Quantity("rad", "course over ground, measured as psi is"),
    "rudder": Quantity("rad", "rudder angle, positive where it turns the bow to starboard"),
    "revolutions": Quantity("1/s", "propeller revolutions n"),
    MEETING: Quantity("1", "1 while another ship passes, else 0: what it pushes is no gust"),
    "wind_speed": Quantity("m/s", "speed of the wind over ground"),
    "wind_direction": Quantity("rad", "where the wind comes from, measured as psi is"),
}

TURNING = ("psi", "course", "wind_direction")  # Directions: a whole turn more is the same


def size_of(durations: Sequence[float], count: int) -> str:
    """Return the number of records, and how long [s] they are together, in words."""
    hours = sum(durations) / 3600
    lasting = f"{hours:.3g} h" if hours >= 1 else f"{60 * hours:.3g} min"
    return f"{count} record{'s' * (count != 1)}, {lasting}"


def check_signals(names: Iterable[str]) -> None:
    for name in names:
        if name not in SIGNALS:
            raise InputError(f"there is no signal {name!r}{did_you_mean(str(name), SIGNALS)}")


@dataclass(frozen=True, repr=False, eq=False)
class ShipLog(BaseResult):
    """Records of one ship: manoeuvres, transits.

    Raises an InputError where two records share a name.

    Examples
    --------
    >>> len(nw.ShipLog((nw.ShipRecord("A", {}),)))
    1
    """

    records: tuple[ShipRecord, ...]  #: Each with a name of its own
    waterway: Waterway | None = None  #: Line of x, y, psi and course; a plane without one
    notes: tuple[str, ...] = ()  #: Notes of the reader: interpretation of columns, rows left out

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

    @property
    def counts(self) -> dict[str, int]:
        """Values of each signal in all records."""
        counts = {name: sum(len(own[name]) for own in self.records if name in own) for name in SIGNALS}
        return {name: count for name, count in counts.items() if count}

    def summary(self) -> str:
        size = size_of([record.duration for record in self.records if np.isfinite(record.duration)], len(self))
        where = f" along {self.waterway.name}" if self.waterway else ""
        return f"{size} together{where}, with {', '.join(self.counts) or 'no signal'}."

    def to_dict(self) -> dict[str, Any]:
        records = {
            own.name: {"antenna": list(own.antenna), "condition": dict(own.condition),
                       "values": {name: len(own[name]) for name in own}}
            for own in self.records
        }  # fmt: skip
        return {"summary": self.summary(), "records": records, "notes": list(self.notes)}

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the rows as a table that ``read_log`` reads again: record, t, and a column for each signal."""
        import pandas as pd

        frames = {record.name: record.to_dataframe() for record in self.records}
        rows = pd.concat(frames, names=["record"]).reset_index() if frames else pd.DataFrame({"record": [], "t": []})
        return rows[["record", "t", *self.counts]]


@dataclass(frozen=True)
class SignalGrade:
    """Errors of one signal.

    Raises an InputError where a number is negative or not finite, or there is no noise or period at all.

    Examples
    --------
    >>> nw.SignalGrade(noise=0.5, period=1.0).noise
    0.5
    """

    noise: float  #: Standard deviation from reading to reading [unit of the signal]
    period: float = 1.0  #: Time between two readings [s]
    wander: float = 0.0  #: Standard deviation of an error of a first-order process [unit of the signal]
    memory: float = 60.0  #: Its correlation time [s]
    zero: float = 0.0  #: Standard deviation of an error that is constant over a record [unit of the signal]

    def __post_init__(self) -> None:
        check_sizes(self, over=("noise", "period", "memory"))


@dataclass(frozen=True, repr=False)
class SensorGrade(BaseSummary):
    """A ship's sensors.

    Raises an InputError where a name is no signal's.

    Examples
    --------
    >>> nw.SensorGrade("tank", "", {"y": nw.SignalGrade(0.01)}).name
    'tank'
    """

    name: str  #: Name of the grade
    words: str  #: Its meaning
    #: By the names of ``SIGNALS``; what is not there is not measured
    signals: Mapping[str, SignalGrade] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_signals(self.signals)

    def summary(self) -> str:
        return f"{self.name}: {self.words}; measures {', '.join(self.signals)}"


# Assumed but for these. IMO A.424(XI), gyro-compasses: to 0.75 deg at rest, 1.0 deg under way, times the secant of the
# latitude; standard deviations are about half of it (nippon.zaidan.info/seikabutsu/2000/00402/contents/006.htm,
# checked). IMO A.526(13), rate-of-turn indicators: to 0.5 deg/min and 5 % of what is shown
# (ajishnavigator.blogspot.com/2011/10/imo-performance-standards-for-rot.html, checked). AIS: heading in whole degrees
# and no rudder, by the form of the message (ais_msg_2.html at vislab-ccom.unh.edu, checked). The zeros of x and y are
# those of the antenna and of the banks as charted.
RTK = SensorGrade(
    "rtk",
    "a pilot's own unit, two antennas with corrections, and the rudder's indicator by wire",
    {
        **dict.fromkeys(("y", "x"), SignalGrade(0.05, zero=0.3)),
        "psi": SignalGrade(0.05 * DEGREE, zero=0.1 * DEGREE),
        "r": SignalGrade(0.008 * DEGREE, wander=0.002 * DEGREE),
        **dict.fromkeys(("v_ground", "u_ground"), SignalGrade(0.02, wander=0.01, memory=100.0)),
        "rudder": SignalGrade(0.1 * DEGREE, zero=0.3 * DEGREE),
    },
)
VDR = SensorGrade(
    "vdr",
    "what a voyage data recorder keeps: GNSS, gyro, rate of turn, rudder indicator",
    {
        **dict.fromkeys(("y", "x"), SignalGrade(0.7, wander=1.0, memory=300.0, zero=2.0)),
        "psi": SignalGrade(0.15 * DEGREE, wander=0.2 * DEGREE, memory=600.0, zero=0.5 * DEGREE),
        "r": SignalGrade(0.01 * DEGREE, wander=0.004 * DEGREE, memory=60.0),
        "u": SignalGrade(0.1, zero=0.1),
        "rudder": SignalGrade(0.4 * DEGREE, zero=0.5 * DEGREE),
    },
)
AIS = SensorGrade(
    "ais",
    "what the ship broadcasts: position, heading in whole degrees, every ten seconds, without the rudder",
    {
        **dict.fromkeys(("y", "x"), SignalGrade(1.5, period=10.0, wander=1.0, memory=300.0, zero=3.0)),
        "psi": SignalGrade(0.3 * DEGREE, period=10.0, wander=0.2 * DEGREE, memory=600.0, zero=1.0 * DEGREE),
        "speed_over_ground": SignalGrade(0.05 * KNOT, period=10.0, wander=0.05 * KNOT, memory=300.0),
    },
)
GRADES = {grade.name: grade for grade in (RTK, VDR, AIS)}  # Grades by name, the best first


def sensor_grade(sensors: str | SensorGrade, known: Mapping[str, SensorGrade] = GRADES) -> SensorGrade:
    if isinstance(sensors, SensorGrade):
        return sensors
    check_choice("sensors", sensors, known)
    return known[sensors]
