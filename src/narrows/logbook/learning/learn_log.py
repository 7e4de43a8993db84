"""Learn a model from a ship's own records: ``learn``."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from narrows.errors import InputError
from narrows.logbook.filtering.predicted_signals import RUDDER
from narrows.logbook.filtering.search import search
from narrows.logbook.learning.log_fit import LogFit
from narrows.logbook.learning.log_prior import Spread
from narrows.logbook.learning.log_result import log_result
from narrows.logbook.learning.log_setup import log_problem
from narrows.logbook.learning.log_source import LogSource
from narrows.logbook.sensor_grades import SensorGrade
from narrows.logbook.ship_log import ShipLog
from narrows.model.model import Model
from narrows.progress import stage

if TYPE_CHECKING:
    from narrows.waterway import Waterway

SENSORS = "vdr"
RUNS_AWAY = (
    "the model cannot follow this log at all: its motion goes to infinity; look at signs and axes with `check_log`"
)


def learn(
    model: Model, log: Any, *, free: Sequence[str] = (), sensors: str | SensorGrade = SENSORS,
    spread: Spread | None = None, gusts: bool | None = None, asymmetry: bool | None = None,
    waterway: "Waterway | None" = None, **choices: Any,
) -> LogFit:  # fmt: skip
    """Learn from what a ship did under its own helm: zigzags, turning circles, transits of a canal.

    A Kalman filter predicts each reading from the earlier ones under the recorded rudder; the coefficients maximise the
    likelihood of its errors (innovations) and the prior. Gusts are first-order Gauss-Markov processes, as strong and as
    long as the records make most likely; sensor errors, currents and a steady wind are estimated with the ship's state.
    A pilot may see more than the sensors: where gusts act, the answer is the mean of two fits, one with the rudder as
    given, one with the rudder as readings of a pilot's linear law. Where no gusts act, whole records are predicted from
    their start. Motion determines forces over inertia alone, so that the prior of the inertia holds the rest. Ctrl-C
    ends the search and keeps what was found.

    Parameters
    ----------
    model : Model
        With the covariance of its fit, which is the prior, all of it; at the ship's own size.
    log : ShipLog, StreamedLog, ShipRecord, path, or a sequence of records
        What was recorded.
    free : sequence of str, optional
        Coefficients that may change, all that have a spread unless given. The others keep their mean and covariance,
        and their errors are part of the standard errors of the free ones (Schmidt's Kalman update).
    sensors : {"rtk", "vdr", "ais", "basin"} or SensorGrade
        How well it was measured; in a basin, noise is estimated and no wind blows.
    spread : float or mapping of str to float, optional
        Prior of a model without a covariance: standard deviations over the size of coefficients, inertia held, or
        each in its own unit.
    gusts : bool, optional
        Whether gusts act; in all but a basin, unless given.
    asymmetry : bool, optional
        Whether a constant sway force and yaw moment of the ship are learned, as its propeller or a rudder zero make
        them; where no gusts act and ``free`` names nothing, unless given. They stay in the model.
    waterway : Waterway, optional
        Along which x and y are told; the one of the log, or else the model's own canal.
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
    given: dict[str, Any] = {
        "free": free,
        "spread": spread,
        "gusts": gusts,
        "asymmetry": asymmetry,
        "waterway": waterway,
        **choices,
    }
    setup = log_problem(model, log, sensors, **given)
    came_from = LogSource.of(setup.source.log, _name(setup.source.log), setup.source.assumptions.grade.name)
    with stage("fitting the records"):
        found = search(setup.problem, setup.source)
    if found is None:
        raise InputError(RUNS_AWAY)
    if not found.records:
        why = " ".join(setup.source.left_out).removesuffix(".") or "it has none"
        raise InputError(f"no record of this log can be used: {why}")
    piloted = None
    if setup.source.assumptions.gusts and RUDDER in setup.problem.motion.positions and not found.interrupted:
        joint = log_problem(model, log, sensors, pilot=True, **given)
        with stage("fitting the records with a pilot"):
            piloted = search(joint.problem, joint.source, scaled=found.scaled)
    return log_result(setup, found, came_from, free, piloted)


def _name(log: Any) -> str:
    if isinstance(log, ShipLog):
        return log.names[0] if len(log) == 1 else f"{log.names[0]} to {log.names[-1]}"
    return Path(str(getattr(log, "name", "a log"))).name
