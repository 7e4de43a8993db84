"""The monitor for Python: the engine of ``narrows monitor``, fed with readings or sentences."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.results import Aliased
from narrows.estimation.filter_run import checked_readings
from narrows.model.model import Model
from narrows.readers.nmea import Entry, NmeaDecoder, sentences
from narrows.ship.checks import is_finite
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.warning.alerts.alert import Alert
from narrows.warning.inputs.bridge_readings import NEEDED, Messages, Tick
from narrows.warning.monitoring.bridge_monitor import MEASURES, BridgeMonitor
from narrows.warning.monitoring.watched_transit import BridgeStatus
from narrows.warning.settings import MEMBERS
from narrows.waterway.waterway import Waterway, straight_waterway

CANAL_LENGTHS = 200.0  # Length of the model's own canal as a waterway [ship lengths]
# Sensor of each state that is given by its name.
SENSOR_OF = {"psi": "gyro", "u": "log", "r": "rate_of_turn"}


class Monitor(Aliased):
    """Bank warnings for a ship: the engine of ``narrows monitor``; decision support, not type-approved equipment.

    Raises an InputError if the model has no rudder, or the compiler (the extra ``compiled``) is missing.

    Parameters
    ----------
    model : Model
        The ship at its own size, with the terms of a rudder.
    waterway : Waterway, optional
        Default: the model's own canal, straight.
    line : float [m]
        Offset from the line of the waterway to which the escape manoeuvre steers.
    members : int
        Number of samples of a forecast.

    Examples
    --------
    >>> monitor = nw.Monitor("estimated_kcs", members=50)
    >>> for t in range(6):
    ...     status = monitor.update(t, x=1000.0 + 4.0 * t, y=100.0, psi=0.0, u=4.0, r=0.0, rudder=0.0)
    >>> status.word, monitor.alerts
    ('watch', ())
    """

    @accept_aliases
    def __init__(
        self, model: Model, waterway: Waterway | None = None, line: float = 0.0, members: int = MEMBERS
    ) -> None:
        check_waterway(waterway)
        line = finite_numbers(line=line)["line"]
        water = waterway or straight_waterway(model.canal, CANAL_LENGTHS * model.ship.length)
        # Only sentences need a place on earth.
        self._is_placed = water.origin is not None
        placed = water if self._is_placed else replace(water, origin=(0.0, 0.0))
        self.engine = BridgeMonitor(model, placed, line, members=members, live=False)
        self.status: BridgeStatus | None = None
        self._decoder: NmeaDecoder | None = None
        self._last: dict[str, float] = {}

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """Alerts that are not normal, the most urgent first."""
        return self.status.alerts if self.status else ()

    def update(self, t: float, readings: Any = None, **named: Any) -> BridgeStatus:
        """Use the ``readings`` of a second ending at ``t`` [s]; return estimate, forecast and alerts.

        They are NMEA 0183 sentences, or numbers along the waterway by the names of sensors, as for
        ``Estimator.update``, or of states: x, y [m], psi, rudder [rad], u [m/s] through the water, r [rad/s]; also by
        keyword (``named``). Raises an InputError for an unknown name, what is no reading or time, and for a sentence
        without a place on earth.
        """
        if not is_finite(t):
            raise InputError(f"t = {shown(t)} is no time; give seconds, then the readings")
        if readings is None or isinstance(readings, Mapping | pd.Series):
            messages = self._messages(t, {**({} if readings is None else readings), **named})
        else:
            lines = [readings] if isinstance(readings, str | bytes) else readings
            if named or not (isinstance(lines, Sequence) and all(isinstance(line, str | bytes) for line in lines)):
                raise InputError(f"readings = {shown(readings)}: give sentences, or else numbers by name")
            messages = self._decoded(t, lines)
        self.status = self.engine.watch(messages, t)
        return self.status

    def _decoded(self, t: float, lines: Sequence[str | bytes]) -> Messages:
        if not self._is_placed:
            raise InputError("sentences have longitude and latitude; give a waterway with its origin, or readings")
        decoder = self._decoder = self._decoder or NmeaDecoder()
        told = sentences([line.encode() if isinstance(line, str) else line for line in lines], decoder.faults)
        entries = [Entry(t, message) for one in told if (message := decoder.decode(one))]
        return self.engine.bridge.convert(Tick(t, entries, dict(decoder.faults)))

    def _messages(self, t: float, given: Mapping[str, Any]) -> Messages:
        readings = {SENSOR_OF.get(name, name): value for name, value in given.items() if name not in ("x", "y")}
        if ("x" in given) != ("y" in given):
            raise InputError("a place is x along the waterway and y to starboard of its line; give both")
        if "x" in given:
            readings["gnss"] = given["x"], given["y"]
        sensors, actuators = self.engine.estimator.filter.sensors, self.engine.estimator.filter.actuators
        measured, positions, _ = checked_readings(readings, sensors, actuators)
        for name in (*measured, *positions):
            self._last[MEASURES.get(name, name)] = t
        for what in NEEDED:
            self._last.setdefault(what, t)
        known: dict[str, Any] = {**measured, **positions}
        return Messages(t, known, {what: t - last for what, last in self._last.items()}, {}, None)
