"""A log as a problem: its records, what moves the ship, errors of sensors, what is known before."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from narrows.base.errors import InputError
from narrows.logbook.filtering.log_problem import (
    SPREAD_OF_STRENGTH,
    SWAY,
    YAW,
    CoefficientPrior,
    Estimated,
    LogProblem,
    Process,
    RecordedMotion,
    StochasticModel,
)
from narrows.logbook.filtering.record_grid import CURRENTS, ERROR, OFFSET, READ, RUDDER, RecordGrid, grid_of
from narrows.logbook.learned_coefficients import Spread, push_inertia, record_prior
from narrows.logbook.reading.read_log import StreamedLog, read_log, stream_log
from narrows.logbook.ship_log import GRADES, SensorGrade, ShipLog, ShipRecord, Signal, SignalGrade, sensor_grade
from narrows.model.model import Model
from narrows.quantities.names import DEGREE
from narrows.simulation.initial_state import steady_revolutions
from narrows.waterway import Waterway
from narrows.waterway.centreline import check_along_only

# Length of a step, in times of a ship length; in a basin, where the kinks of a rudder in a zigzag matter more.
STEP, BASIN_STEP = 1 / 25, 1 / 40
STEADY = "steady_{}".format  # Steady push of a record
# How long a gust stays before anything is known of it [s], and standard deviations of logarithms: of that, of noise; of
# the inverse hyperbolic tangent of the correlation between sway and yaw.
USUAL_MEMORY, SPREAD_OF_MEMORY, SPREAD_OF_NOISE, SPREAD_OF_CORRELATION = 40.0, 1.0, 0.3, 1.0
# Standard deviations of accelerations before anything is known, over speed squared by length (and by length again for
# yaw): of gusts, and of a push that stays.
GUST, STEADY_PUSH = 0.005, 0.1
SPREAD_OF_CURRENT = 0.3  # Standard deviation of a current that nothing is known of [m/s]
# Standard deviation of revolutions that are not recorded, over those that keep the usual speed: by hull, propeller and
# wind a ship needs a fifth more or less.
SPREAD_OF_REVOLUTIONS = 0.2

# What a model leaves of places in a basin, in lengths of the ship, its memory counted; four times as much of angles,
# five of yaw rates and twice as much of speeds, over those of the ship.
USUALLY_LEFT = 0.015
BASIN_SPREAD = 2.0  # Standard deviation of the logarithm of noise in a basin
USUALLY_CORRELATED = 60.0  # Readings for each independent one where a model's own error is what is left, to begin with
# The noise that counts is what the model leaves of the records.
BASIN = SensorGrade(
    "basin",
    "a towing tank: no wind, no current, noise estimated from the records",
    {**{name: SignalGrade(1e-6) for name in READ}, RUDDER: SignalGrade(1e-9, zero=0.1 * DEGREE)},
)
LOOKED_AT = 50  # Records by which it is seen what a log holds
# Share of readings that differ from the one before, above which rounding leaves a white error [1].
SELDOM_REPEATED = 0.5
LONGEST = 6 * 3600.0  # Longest record taken as one [s]: constant errors do not stay constant for ever
LEGS = 60  # Number of straight legs of a way
OTHER_DRAFT = 0.02  # Share of a draft, by which a record may differ
# Values of a log that are kept laid out; of a longer one each record is laid out when its turn comes.
HELD_VALUES = 20_000_000

# Errors of signals outside a grade.
UNGRADED = {
    "x": SignalGrade(1.0), "y": SignalGrade(1.0), "psi": SignalGrade(0.3 * DEGREE), "r": SignalGrade(0.02 * DEGREE),
    "u": SignalGrade(0.1), "v": SignalGrade(0.1), "u_ground": SignalGrade(0.1), "v_ground": SignalGrade(0.1),
    "speed_over_ground": SignalGrade(0.1), "course": SignalGrade(2 * DEGREE), RUDDER: SignalGrade(0.5 * DEGREE),
}  # fmt: skip


@dataclass(frozen=True)
class LogSetup:
    log: Iterable[ShipRecord]  # That can be gone through again and again
    grade: SensorGrade
    gusts: bool  # Whether pushes with a memory act
    pilot: bool  # Whether the rudder follows what a pilot sees
    signals: set[str]  # Signals of the first records
    rounding: Mapping[str, tuple[float, float]]  # Standard deviation and memory [s] of the rounding error of signals
    motion: RecordedMotion
    prior: CoefficientPrior
    left_out: dict[str, None] = field(default_factory=dict)  # Records that could not be laid out so far, and why

    def __iter__(self) -> Iterator[RecordGrid]:
        yield from self._held if self._held is not None else self._laid_out()

    @cached_property
    def _held(self) -> tuple[RecordGrid, ...] | None:
        if not isinstance(self.log, ShipLog) or sum(self.log.counts.values()) > HELD_VALUES:
            return None
        return tuple(self._laid_out())

    def _laid_out(self) -> Iterator[RecordGrid]:
        for record in self.log:
            for part in parts(record):
                try:
                    yield self._grid(part)
                except InputError as error:
                    self.left_out[f"{error}."] = None

    def _grid(self, record: ShipRecord) -> RecordGrid:
        usual, ship = self.motion.positions, self.motion.model.configuration.ship
        if RUDDER in usual and not (RUDDER in record and len(record[RUDDER])):
            raise InputError(f"record {record.name} has no rudder angle: bank and helm cannot be separated; record it")
        if abs(record.condition.get("draft", ship.draft) / ship.draft - 1) > OTHER_DRAFT:
            raise InputError(
                f"record {record.name} is of a draft of {record.condition['draft']:.3g} m, the model of "
                f"{ship.draft:.3g} m: leave it out, or give a model of that draft"
            )
        return grid_of(record, self._step(speed_of(record)), usual, self.pilot)

    def _step(self, u: float) -> float:
        return float(f"{(STEP if self.gusts else BASIN_STEP) * self.motion.model.configuration.ship.length / u:.2g}")

    @cached_property
    def problem(self) -> LogProblem:
        u, length = self.motion.choices["u"], self.motion.model.configuration.ship.length
        along = {"X": u**2 / length} if self.motion.choices["surge"] == "free" else {}
        sizes = {**along, "Y": u**2 / length, "N": (u / length) ** 2}
        noise = self._noise(length, u)
        gusts = [Process(name, name, GUST * size, USUAL_MEMORY) for name, size in sizes.items()] if self.gusts else []
        names = tuple(one.name for one in gusts)
        processes = [*gusts, *self._errors(noise, u)]
        estimated = [Estimated("std", (name,), SPREAD_OF_STRENGTH) for name in names]
        if gusts:
            processes += [Process(STEADY(n), n, STEADY_PUSH * size, np.inf) for n, size in sizes.items()]
            estimated.append(Estimated("memory", names, SPREAD_OF_MEMORY))
            estimated.append(Estimated("correlation", (SWAY, YAW), SPREAD_OF_CORRELATION))
        spread = BASIN_SPREAD if self.grade.name == BASIN.name else SPREAD_OF_NOISE
        estimated += [Estimated("noise", (name,), spread) for name in noise]
        model = StochasticModel(tuple(processes), noise, tuple(estimated), gusts=names)
        if self.pilot and RUDDER in self.signals:
            model = model.with_pilot(length, u)
        inertia = push_inertia(self.prior, u, self.motion.choices.get("surge_inertia"))
        return LogProblem(self.motion, self.prior, inertia, model, 1.0 if self.gusts else USUALLY_CORRELATED)

    def _noise(self, length: float, u: float) -> dict[str, float]:
        """Noise of the grade; in a basin the usual model error, to begin with."""
        read = [name for name in READ if name in self.signals]
        if self.grade.name != BASIN.name:
            return {name: self._grade(name).noise for name in read}
        place, angle = USUALLY_LEFT * length, USUALLY_LEFT * 4
        sizes = {"x": place, "y": place, "psi": angle, "course": angle, "r": USUALLY_LEFT * 5 * u / length}
        return {name: sizes.get(name, USUALLY_LEFT * 2 * u) for name in read}

    def _grade(self, name: str) -> SignalGrade:
        """The grade of a signal; of one that the sensors are not said to have, that of the nearest."""
        nearest = {"u_ground": "u", "speed_over_ground": "u", "course": "psi", "v_ground": "u", "v": "u"}
        graded = self.grade.signals
        return graded.get(name) or graded.get(nearest.get(name, name)) or UNGRADED[name]

    def _errors(self, noise: Mapping[str, float], u: float) -> list[Process]:
        found, positions = [], self.motion.positions
        if RUDDER in self.signals:
            rudder = self._grade(RUDDER)
            white = rudder.noise * np.sqrt(rudder.period / self._step(u))
            found += [Process("rudder_noise", OFFSET(RUDDER), white, 0.0)]
            found += [Process(OFFSET(RUDDER), OFFSET(RUDDER), rudder.zero, np.inf)]
        if "revolutions" in positions and lacks_revolutions(self.signals, self.grade):
            usual = SPREAD_OF_REVOLUTIONS * positions["revolutions"]
            found.append(Process(OFFSET("revolutions"), OFFSET("revolutions"), usual, np.inf))
        for name in noise:
            grade = self._grade(name)
            found.append(Process(f"{name}_wander", ERROR(name), grade.wander, grade.memory))
            if name in self.rounding:
                found.append(Process(f"{name}_rounding", ERROR(name), *self.rounding[name]))
            if name != "x":
                found.append(Process(ERROR(name), ERROR(name), grade.zero, np.inf))
        over_ground = {"u_ground", "v_ground", "speed_over_ground", "course", "x"}
        if self.signals & over_ground and self.grade.name != BASIN.name:
            axes = CURRENTS[:1] if self.motion.model.has_bank else CURRENTS
            found += [Process(name, name, SPREAD_OF_CURRENT, np.inf) for name in axes]
        return [one for one in found if one.std > 0]


def lacks_revolutions(signals: set[str], grade: SensorGrade) -> bool:
    """Return whether propeller revolutions are unknown: not recorded, and not those of a tank's tests."""
    return "revolutions" not in signals and grade.name != BASIN.name


def log_problem(
    model: Model, log: Any, sensors: str | SensorGrade, *, free: Sequence[str] = (), spread: Spread | None = None,
    gusts: bool | None = None, asymmetry: bool | None = None, waterway: Waterway | None = None, pilot: bool = False,
    **choices: Any,
) -> LogSetup:  # fmt: skip
    records, grade = log_records(log, waterway), sensor_grade(sensors, {**GRADES, BASIN.name: BASIN})
    gusty = grade.name != BASIN.name if gusts is None else gusts
    changes = list[bool]()  # Whether the speed changes, by record
    signals, rounding, speeds = set[str](), dict[str, tuple[float, float]](), list[float]()
    for record in islice(records, LOOKED_AT):
        signals |= {name for name in record if len(record[name])}
        for name in record:
            rounding[name] = max(rounding.get(name, (0.0, 1.0)), _rounding(record[name]))
            changes += [bool(np.ptp(record[name].values))] * (name == "u" and len(record[name]) > 1)
        speeds.append(speed_of(record))
    # A speed that never changes is that of a simulation that holds it.
    held = not model.terms.propelled or (bool(changes) and not any(changes))
    surge = choices.setdefault("surge", "held" if held else "free")
    if not speeds:
        raise InputError("this log holds neither a speed nor a way of the ship; give x and y, or u")
    u = float(np.median(speeds))
    asymmetric = not gusty and not free if asymmetry is None else asymmetry
    prior = record_prior(model, u, surge, spread, asymmetric, tuple(free))
    model = prior.model
    options = {"contact": "midship" if model.terms.has_bank else "none", "u": u, **choices}
    if water := waterway or getattr(records, "waterway", None):
        check_along_only(water, "learning")
        options |= {"waterway": water, "x": water.line.length / 2}
    # Usual positions of the actuators that follow a record, and of a propeller whose revolutions are not recorded
    values, followed = model.configuration.values(), {RUDDER, "revolutions"} | signals
    if lacks_revolutions(signals, grade):
        values["revolutions"] = steady_revolutions(model, u) or values.get("revolutions", 0.0)
    positions = {own.name: float(values.get(own.name) or 0.0) for own in model.terms.actuators if own.name in followed}
    motion = RecordedMotion(model, positions, (), options)
    return LogSetup(records, grade, gusty, pilot and gusty, signals, rounding, motion, prior)


def log_records(log: Any, waterway: Waterway | None) -> Iterable[ShipRecord]:
    """Return the records of a log, a path, a table, a voyage, or of what has records."""
    if isinstance(log, ShipLog | StreamedLog):
        return log
    if isinstance(log, str | Path):
        return stream_log(log, waterway)
    log = (log,) if isinstance(log, ShipRecord) else log
    if isinstance(log, Sequence):
        are_records = all(isinstance(record, ShipRecord) for record in log)
        return ShipLog(tuple(log), waterway) if are_records else read_log(log, waterway)
    table = log.to_dataframe().reset_index() if hasattr(log, "to_dataframe") else log
    if hasattr(table, "columns"):
        return read_log(table, waterway)
    if isinstance(log, Iterable) and not hasattr(log, "__next__"):
        return log
    raise InputError(f"a {type(log).__name__} is no log: give one that `read_log` made, records, a table, or a path")


def _rounding(signal: Signal) -> tuple[float, float]:
    """Standard deviation and memory [s] of the error of rounded values; 0 if values seldom repeat."""
    change = np.abs(np.diff(signal.values))
    moved = change[change > 0]
    if not len(moved) or len(moved) > SELDOM_REPEATED * len(change):
        return 0.0, 1.0  # The error is then white, and part of the noise
    # Uniform over a step; of a signal that rises steadily it is a sawtooth of period T, whose autocorrelation
    # 1 - 6 s/T (1 - s/T) begins like that of a process of memory T/6.
    return float(moved.min() / np.sqrt(12)), float(np.ptp(signal.t) / len(moved) / 6)


def parts(record: ShipRecord) -> Iterator[ShipRecord]:
    if not record.duration > LONGEST:
        yield record
        return
    edges = np.linspace(record.start, record.stop, int(np.ceil(record.duration / LONGEST)) + 1)
    for number, (start, stop) in enumerate(pairwise(edges), start=1):
        yield replace(record.between(float(start), float(stop)), name=f"{record.name}, part {number}")


def speed_of(record: ShipRecord) -> float:
    for name in ("u", "u_ground", "speed_over_ground"):
        if name in record and len(record[name]):
            return max(float(np.median(np.abs(record[name].values))), 1e-3)
    if "x" in record and len(record["x"]) > 1:
        t = np.linspace(record["x"].t[0], record["x"].t[-1], LEGS)
        legs = [np.diff(np.interp(t, record[name].t, record[name].values)) for name in ("x", "y") if name in record]
        return max(float(np.linalg.norm(legs, axis=0).sum() / max(np.ptp(t), 1e-9)), 1e-3)
    if "x" in record:
        raise InputError(f"record {record.name} holds a single position: a gap begins a record; give a longer gap=")
    raise InputError(f"record {record.name} holds no speed and no way; give one of {', '.join(READ)}")
