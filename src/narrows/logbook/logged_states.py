"""The states of a ship over its own log: the sensors of its columns, and the estimator's filter."""

import math
from collections.abc import Sequence
from typing import Any

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.estimation.estimator import Estimator
from narrows.estimation.sensors import CourseOverGround, GaussMarkov, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from narrows.estimation.states import EstimatedTrack, Prior
from narrows.logbook.learning.log_setup import log_records
from narrows.logbook.ship_log import sensor_grade
from narrows.model.model import Model

# Sensors by the signals of a log that they measure, in the order of the fields of a reading.
LOGGED = {
    ("x", "y"): Gnss, ("psi",): Gyro, ("r",): RateOfTurn, ("u",): Log,
    ("course", "speed_over_ground"): CourseOverGround,
}  # fmt: skip
# Without a speed log: the speed over ground, with the current as its constant error.
OVER_GROUND = {("x", "y"): Gnss, ("psi",): Gyro, ("r",): RateOfTurn, ("speed_over_ground",): Log}


@accept_aliases
def estimate_states(model: Model, log: Any, sensors: Any = "vdr", *, smooth: bool = False) -> EstimatedTrack:
    """Estimate position, motion, bank strength and current of a ship over a record of its own log, by a Kalman filter.

    The log's columns give the sensors, and the grade of ``sensors`` their errors; a signal without a grade has the
    usual errors of its sensor. Without speed through the water the speed over ground is one with an unknown current.
    Measured sway velocities are not used.

    Raises an InputError if the log has several records or no signal of a sensor, or an estimate cannot start.

    Parameters
    ----------
    model : Model
        The ship in its canal; in the waterway of the log, if it has one.
    log : ShipLog, ShipRecord, DataFrame, str or Path
        One record, or what ``read_log`` reads.
    sensors : {"rtk", "vdr", "ais"}, SensorGrade or sequence of Sensor
        Grade of the sensors, or sensors of your own under the names of ``Estimator``.
    smooth : bool
        Whether each estimate uses all readings, in place of those until then.

    Returns
    -------
    EstimatedTrack
        The states by name, such as ``track["v"]`` [m/s]; ``to_dataframe()`` has their standard deviations too.

    Examples
    --------
    >>> voyage = nw.simulate("estimated_kcs", y=20.0, u=4.0, hold=0.0, duration=60.0)
    >>> track = nw.estimate_states("estimated_kcs", voyage.to_dataframe()[["t", "x", "y", "psi", "u", "r", "rudder"]])
    >>> bool(abs(track["y"][-1] - voyage.y[-1]) < 2.0)
    True
    """
    waterway = getattr(log, "waterway", None)
    records: list[Any] = [*log_records(log, None)]
    if len(records) != 1:
        raise InputError(f"the log has {len(records)} records; give one of them, as nw.read_log(path)[0]")
    log = records[0]
    kinds = LOGGED if "u" in log or "speed_over_ground" not in log else OVER_GROUND
    used = {signals: kind for signals, kind in kinds.items() if all(name in log for name in signals)}
    if not used:
        raise InputError(f"no sensor measures {', '.join(log) or 'anything'} of this log; it needs x and y, psi or u")
    if isinstance(sensors, Sequence) and not isinstance(sensors, str):
        own = [*sensors]
    else:
        grade = sensor_grade(sensors)
        own = [_sensor(kind, log, signals, grade) for signals, kind in used.items()]
        helm = grade.signals.get("rudder")
        own += [RudderIndicator(helm.noise, helm.zero) if helm else RudderIndicator()] * ("rudder" in log)
    estimator = Estimator(model, own, waterway=waterway)
    fields = {name: field for signals, kind in used.items() for name, field in zip(signals, kind().fields, strict=True)}
    table = log.to_dataframe().rename(columns=fields)
    read = (field for sensor in estimator.filter.sensors.values() for field in sensor.fields)
    known = [name for name in (*read, *estimator.filter.actuators) if name in table]
    return (estimator.smooth if smooth else estimator.run)(table[known])


def _sensor(kind: Any, log: Any, signals: tuple[str, ...], grade: Any) -> Any:
    """Return the sensor of some signals, with the period of the log and the errors of the grade."""
    given: dict[str, Any] = {"period": log[signals[-1]].step} if math.isfinite(log[signals[-1]].step) else {}
    if known := grade.signals.get(signals[-1]):
        slow = GaussMarkov(known.wander, known.memory) if known.wander else None
        given |= {"noise": known.noise, "bias": known.zero, "coloured": slow}
    if signals == ("speed_over_ground",):
        given["bias"] = Prior.current
    if kind in (Gnss, CourseOverGround):
        given |= dict(zip(("forward", "starboard"), log.antenna, strict=True))
    return kind(**given)
