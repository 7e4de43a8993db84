"""From a ship's own records to a model that knows more: ``learn``."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from narrows.logbook.learning.log_fit import LogFit
from narrows.logbook.learning.log_prior import Spread
from narrows.logbook.learning.log_result import log_result
from narrows.logbook.learning.log_source import LogSource
from narrows.logbook.learning.posed_log import posed_log
from narrows.logbook.learning.refined_search import refined_search
from narrows.logbook.sensor_grades import SensorGrade
from narrows.logbook.ship_log import ShipLog
from narrows.model.model import Model

if TYPE_CHECKING:
    from narrows.waterway import Waterway

SENSORS = "vdr"


def learn(
    model: Model, log: Any, *, free: Sequence[str] = (), sensors: str | SensorGrade = SENSORS,
    spread: Spread | None = None, gusts: bool | None = None, asymmetry: bool | None = None,
    waterway: "Waterway | None" = None, window: float | None = None, **choices: Any,
) -> LogFit:  # fmt: skip
    """Learn from what a ship did under its own helm: zigzags, turning circles, transits of a canal.

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
    asymmetry : bool, optional
        Whether a constant sway force and yaw moment of the ship are learned, as a rudder zero or its propeller make
        them; where no gusts act and ``free`` names nothing, unless said otherwise. They stay in the model.
    waterway : Waterway, optional
        Along which x and y are told; the one of the log, or else the model's own canal.
    window : float, optional [s]
        Length of a window; a tenth of the time of a ship length where gusts act, else whole records unless given.
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
    posed = posed_log(
        model, log, sensors, free=free, spread=spread, gusts=gusts, asymmetry=asymmetry, waterway=waterway,
        window=window, **choices,
    )  # fmt: skip
    came_from = LogSource.of(posed.source.log, _name(posed.source.log), posed.source.assumptions.grade.name)
    refined, source = refined_search(posed.problem, posed.source), posed.source
    if window is None and not posed.problem.linked and not refined.found.interrupted:
        source = source.of_whole_records
        refined = refined_search(refined.problem, source, refined.found.scaled)
    return log_result(posed.model, posed.before, refined, source, came_from, free)


def _name(log: Any) -> str:
    if isinstance(log, ShipLog):
        return log.names[0] if len(log) == 1 else f"{log.names[0]} to {log.names[-1]}"
    return Path(str(getattr(log, "name", "a log"))).name
