"""A log as a problem: its records, what moves the ship, what is known before."""

from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.errors import InputError, check_choice, did_you_mean
from narrows.logbook.learning.grid_source import GridSource, speed_of
from narrows.logbook.learning.log_assumptions import BASIN, LogAssumptions
from narrows.logbook.learning.log_prior import Spread, coefficient_prior, covariance_before, push_inertia
from narrows.logbook.reading.read_log import stream_log
from narrows.logbook.sensor_grades import GRADES, SensorGrade, sensor_grade
from narrows.logbook.ship_log import ShipLog
from narrows.logbook.ship_record import ShipRecord
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.recorded_helm import RUDDER
from narrows.logbook.shooting.recorded_motion import RecordedMotion
from narrows.model.model import Model

if TYPE_CHECKING:
    from narrows.waterway import Waterway

# Records by which it is seen what a log holds.
LOOKED_AT = 50


class PosedLog(NamedTuple):
    """What is solved for, by which records."""

    problem: LogProblem  # With the prior
    source: GridSource  # The records, laid out
    before: np.ndarray  # (n, n) Covariance of all coefficients


def posed_log(
    model: Model, log: Any, sensors: str | SensorGrade, *, free: Sequence[str] = (), spread: Spread | None = None,
    gusts: bool | None = None, waterway: "Waterway | None" = None, window: float | None = None, **choices: Any,
) -> PosedLog:  # fmt: skip
    """Return a log as a problem."""
    records = _records(log, waterway)
    if isinstance(sensors, str):
        check_choice("sensors", sensors, (*GRADES, BASIN.name))
    grade = BASIN if sensors == BASIN.name else sensor_grade(sensors)
    gusty = grade.name != BASIN.name if gusts is None else gusts
    surge = choices.setdefault("surge", "free" if model.terms.propelled else "held")
    assumptions = LogAssumptions(grade, gusty, surge, window)
    signals, u = _looked_at(records)
    before = covariance_before(model, spread)
    prior = coefficient_prior(model, before, surge, _known(model, free))
    motion = _motion(model, signals, u, choices, waterway or getattr(records, "waterway", None), prior.members)
    inertia = push_inertia(model, prior, u, choices.get("surge_inertia"))
    problem = assumptions.problem(motion, prior, inertia, signals, u)
    return PosedLog(problem, GridSource(records, assumptions, dict(motion.positions), model.configuration), before)


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


def _looked_at(records: Iterable[ShipRecord]) -> tuple[set[str], float]:
    """Signals that some of the first records have, and their usual speed."""
    signals, speeds = set[str](), list[float]()
    for record in islice(records, LOOKED_AT):
        signals |= {name for name in record if len(record[name])}
        speeds.append(speed_of(record))
    speeds = [speed for speed in speeds if speed > 0]
    if not speeds:
        raise InputError("this log holds neither a speed nor a way of the ship; give x and y, or u")
    return signals, float(np.median(speeds))


def _known(model: Model, free: Sequence[str]) -> frozenset[str] | None:
    for name in free:
        if name not in model.terms.names:
            raise InputError(f"free: there is no coefficient {name!r}{did_you_mean(name, model.terms.names)}")
    return frozenset(free) or None


def _motion(
    model: Model, signals: set[str], u: float, choices: dict[str, Any], waterway: "Waterway | None",
    coefficients: tuple[str, ...],
) -> RecordedMotion:  # fmt: skip
    values = model.configuration.values()
    positions = {
        actuator.name: float(values.get(actuator.name) or 0.0)
        for actuator in model.terms.actuators
        if actuator.name == RUDDER or actuator.name in signals
    }
    told = {"contact": "midship" if model.terms.feels_bank else "none", "u": u, **choices}
    if waterway is not None:
        told |= {"waterway": waterway, "x": waterway.line.length / 2}
    return RecordedMotion(model, positions, coefficients, told)
