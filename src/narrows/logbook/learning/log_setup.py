"""A log as a problem: its records, what moves the ship, what is known before."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError, check_choice, did_you_mean
from narrows.logbook.filtering.log_problem import LogProblem, RecordedMotion
from narrows.logbook.filtering.record_grid import READ, REVOLUTIONS, RUDDER, RecordGrid, grid_of
from narrows.logbook.learning.log_prior import (
    BASIN,
    LogAssumptions,
    Spread,
    coefficient_prior,
    covariance_before,
    push_inertia,
    with_asymmetry_before,
)
from narrows.logbook.reading.read_log import stream_log
from narrows.logbook.sensor_grades import GRADES, SensorGrade, sensor_grade
from narrows.logbook.ship_log import ShipLog, ShipRecord, Signal
from narrows.model.model import Model
from narrows.simulation.self_propulsion import steady_revolutions
from narrows.waterway.current_profile import check_along_only

if TYPE_CHECKING:
    from narrows.waterway import Waterway

# Records by which it is seen what a log holds.
LOOKED_AT = 50
# Share of readings that differ from the one before, above which rounding leaves a white error [1].
SELDOM_REPEATED = 0.5


@dataclass(frozen=True)
class LogSetup:
    """Unknowns, and the records of the problem, laid out on even times."""

    problem: LogProblem  # With the prior
    log: Iterable[ShipRecord]  # That can be gone through again and again
    assumptions: LogAssumptions  # How long steps are
    before: np.ndarray  # (n, n) Covariance of all coefficients
    model: Model  # With an asymmetry where one is learned

    def __iter__(self) -> Iterator[RecordGrid]:
        """The records."""
        yield from self._held if self._held is not None else self._laid_out([])

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """Records that could not be used, and why."""
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
        usual, ship = self.problem.motion.positions, self.model.configuration.ship
        if RUDDER in usual and not (RUDDER in record and len(record[RUDDER])):
            raise InputError(f"record {record.name} has no rudder angle: bank and helm cannot be separated; record it")
        if abs(record.condition.get("draft", ship.draft) / ship.draft - 1) > OTHER_DRAFT:
            raise InputError(
                f"record {record.name} is of a draft of {record.condition['draft']:.3g} m, the model of "
                f"{ship.draft:.3g} m: leave it out, or give a model of that draft"
            )
        step = self.assumptions.step(ship.length, speed_of(record))
        return grid_of(record, step, usual, self.assumptions.pilot)


def log_problem(
    model: Model, log: Any, sensors: str | SensorGrade, *, free: Sequence[str] = (), spread: Spread | None = None,
    gusts: bool | None = None, asymmetry: bool | None = None, waterway: "Waterway | None" = None, pilot: bool = False,
    **choices: Any,
) -> LogSetup:  # fmt: skip
    """Return a log as a problem."""
    records = _records(log, waterway)
    if isinstance(sensors, str):
        check_choice("sensors", sensors, (*GRADES, BASIN.name))
    grade = BASIN if sensors == BASIN.name else sensor_grade(sensors)
    gusty = grade.name != BASIN.name if gusts is None else gusts
    surge = choices.setdefault("surge", "free" if model.terms.propelled else "held")
    signals, rounding, u = _looked_at(records)
    assumptions = LogAssumptions(grade, gusty, surge, pilot and gusty, rounding)
    before = covariance_before(model, spread)
    steered = RUDDER in {own.name for own in model.terms.actuators}
    if steered and (not gusty and not free if asymmetry is None else asymmetry):
        model, before = with_asymmetry_before(model, before, u)
    for name in free:
        if name not in model.terms.names:
            raise InputError(f"free: there is no coefficient {name!r}{did_you_mean(name, model.terms.names)}")
    prior = coefficient_prior(model, before, surge, frozenset(free) or None)
    positions = _positions(model, signals, u, assumptions.lacks_revolutions(signals))
    motion = _motion(model, positions, u, choices, waterway or getattr(records, "waterway", None))
    inertia = push_inertia(model, prior, u, choices.get("surge_inertia"))
    problem = assumptions.problem(motion, prior, inertia, signals, u)
    return LogSetup(problem, records, assumptions, before, model)


def _records(log: Any, waterway: "Waterway | None") -> Iterable[ShipRecord]:
    """Records that can be gone through again and again; files are read each time."""
    if isinstance(log, str | Path):
        return stream_log(log, waterway)
    if isinstance(log, ShipRecord):
        return ShipLog((log,), waterway)
    if isinstance(log, Sequence) and all(isinstance(record, ShipRecord) for record in log):
        return ShipLog(tuple(log), waterway)
    if isinstance(log, Iterable) and not hasattr(log, "__next__"):
        return log
    raise InputError(f"a {type(log).__name__} is no log: give one that `read_log` made, records, or the path of one")


def _looked_at(records: Iterable[ShipRecord]) -> tuple[set[str], dict[str, tuple[float, float]], float]:
    """Signals of the first records, the errors of those that are rounded coarsely, and the usual speed."""
    signals, rounding, speeds = set[str](), dict[str, tuple[float, float]](), list[float]()
    for record in islice(records, LOOKED_AT):
        signals |= {name for name in record if len(record[name])}
        for name in record:
            rounding[name] = max(rounding.get(name, (0.0, 1.0)), _rounding(record[name]))
        speeds.append(speed_of(record))
    speeds = [speed for speed in speeds if speed > 0]
    if not speeds:
        raise InputError("this log holds neither a speed nor a way of the ship; give x and y, or u")
    return signals, rounding, float(np.median(speeds))


def _rounding(signal: Signal) -> tuple[float, float]:
    """Standard deviation and memory [s] of the error of rounded values; 0 if values seldom repeat."""
    change = np.abs(np.diff(signal.values))
    moved = change[change > 0]
    if not len(moved) or len(moved) > SELDOM_REPEATED * len(change):
        return 0.0, 1.0  # The error is then white, and part of the noise
    # Uniform over a step; of a signal that rises steadily it is a sawtooth of period T, whose autocorrelation
    # 1 - 6 s/T (1 - s/T) begins like that of a process of memory T/6.
    return float(moved.min() / np.sqrt(12)), float(np.ptp(signal.t) / len(moved) / 6)


def _positions(model: Model, signals: set[str], u: float, assumed: bool) -> dict[str, float]:
    """Usual positions of the actuators that follow a record, and of a propeller whose revolutions are not recorded."""
    values = model.configuration.values()
    if assumed:
        values[REVOLUTIONS] = steady_revolutions(model, u) or values.get(REVOLUTIONS, 0.0)
    return {
        actuator.name: float(values.get(actuator.name) or 0.0)
        for actuator in model.terms.actuators
        if actuator.name in (RUDDER, REVOLUTIONS) or actuator.name in signals
    }


def _motion(
    model: Model, positions: dict[str, float], u: float, choices: dict[str, Any], waterway: "Waterway | None"
) -> RecordedMotion:
    options = {"contact": "midship" if model.terms.has_bank else "none", "u": u, **choices}
    if waterway is not None:
        check_along_only(waterway, "learning")
        options |= {"waterway": waterway, "x": waterway.line.length / 2}
    return RecordedMotion(model, positions, (), options)


# Records for the search: laid out one by one, long ones in parts; useless ones are left out with a note.
# Longest record taken as one [s]: constant errors do not stay constant for ever.
LONGEST = 6 * 3600.0

# Number of straight legs of a way.
LEGS = 60

# Share of a draft, by which a record may differ.
OTHER_DRAFT = 0.02

# Values of a log that are kept laid out; of a longer one each record is laid out when its turn comes.
HELD_VALUES = 20_000_000


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
    if "x" in record:
        raise InputError(
            f"record {record.name} holds a single position: read_log begins a record after a gap; give a longer gap="
        )
    raise InputError(f"record {record.name} holds no speed and no way; give one of {', '.join(READ)}")
