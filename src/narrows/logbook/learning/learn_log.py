"""From a ship's own records to a model that knows more: ``learn``."""

from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError, check_choice, did_you_mean
from narrows.logbook.learning.grid_source import GridSource, speed_of
from narrows.logbook.learning.log_assumptions import BASIN, LogAssumptions
from narrows.logbook.learning.log_fit import LogFit
from narrows.logbook.learning.log_prior import Spread, coefficient_prior, covariance_before, push_inertia
from narrows.logbook.learning.log_result import log_result
from narrows.logbook.learning.log_source import LogSource
from narrows.logbook.learning.refined_search import refined_search
from narrows.logbook.reading.read_log import stream_log
from narrows.logbook.sensor_grades import GRADES, SensorGrade, sensor_grade
from narrows.logbook.ship_log import ShipLog
from narrows.logbook.ship_record import ShipRecord
from narrows.logbook.shooting.recorded_helm import RUDDER
from narrows.logbook.shooting.recorded_motion import RecordedMotion
from narrows.model.model import Model

if TYPE_CHECKING:
    from narrows.waterway import Waterway

SENSORS = "vdr"
LOOKED_AT = 50
"""Records by which it is seen what a log holds."""


def learn(
    model: Model, log: Any, *, free: Sequence[str] = (), sensors: str | SensorGrade = SENSORS,
    spread: Spread | None = None, gusts: bool | None = None, waterway: "Waterway | None" = None,
    window: float | None = None, **choices: Any,
) -> LogFit:  # fmt: skip
    """Learn from what a ship did under its own helm: zigzags, turning circles, transits of a canal (ours).

    Records are cut into windows, each sailed from a start of its own under the rudder that was recorded; coefficients,
    starts, and what sensors, wind and gusts do to each record are most likely together. Where gusts act, the push of a
    window is a number in a first-order chain, as strong and as long as the records make most likely, for a pilot
    answers gusts, and taken as noise they would look like a bank. Motion tells of forces over inertia alone, so that
    the prior of the inertia holds the rest.

    Parameters
    ----------
    model : Model
        With the covariance of its fit, which is the prior, all of it; at the ship's own size.
    log : ShipLog, StreamedLog, ShipRecord, path, or a sequence of records
        What was recorded.
    free : sequence of str, optional
        Coefficients that may move, all that have a spread unless given; of the others it is allowed for that they may
        be wrong.
    sensors : {"rtk", "vdr", "ais", "basin"} or SensorGrade
        How well it was measured; in a basin, noise is estimated and no wind blows.
    spread : float or mapping of str to float, optional
        Of a model that has no covariance: standard deviations over the size of coefficients, inertia held, or each in
        its own unit.
    gusts : bool, optional
        Whether pushes with a memory act; in all but a basin, unless said otherwise.
    waterway : Waterway, optional
        Along which x and y are told; the one of the log, or else the model's own canal.
    window : float, optional [s]
        Length of a window; 3.5 times that of a ship length, or a tenth of it where gusts act.
    **choices : Any
        As for ``simulate``: surge, surge_inertia, coriolis.

    Returns
    -------
    LogFit
        The model after, what was learned of each coefficient and what still comes from the prior.

    Raises
    ------
    InputError
        Where the model has neither covariance nor spread, a name is unknown, or no record can be used.
    """
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
    source = GridSource(records, assumptions, dict(motion.positions), model.configuration)
    came_from = LogSource.of(records, _name(records), grade.name)
    return log_result(model, before, refined_search(problem, source), source, came_from, free)


def _name(log: Any) -> str:
    if isinstance(log, ShipLog):
        return log.names[0] if len(log) == 1 else f"{log.names[0]} to {log.names[-1]}"
    return Path(str(getattr(log, "name", "a log"))).name


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
