"""Twins of a ship's own log: transits of a ship whose truth is known, in wind and gusts, as its sensors record them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError
from narrows.identification.conditions import bundled_ship
from narrows.logbook.sensor_grades import SensorGrade, SignalGrade
from narrows.logbook.settings import AIM_STEP, CURRENT, MOST_DRAWS, MOST_SHIPS, ORDER_INTERVAL, PUSH_STEP
from narrows.logbook.ship_log import ShipLog
from narrows.logbook.ship_record import ShipRecord, Signal
from narrows.logbook.transits.transit_conditions import TransitConditions, TransitPilot, wandering
from narrows.model.model import Model
from narrows.progress import bar, is_shown
from narrows.quantities.names import KNOT
from narrows.simulation.controllers import Order, VoyageState
from narrows.simulation.grid import correlated
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

DEGREE = math.pi / 180


@dataclass(frozen=True)
class WholeDegrees:
    """A pilot at the wheel: an order every few seconds, in whole degrees."""

    pilot: TransitPilot  # Whose orders they are

    def begin(self) -> Order:
        inner, memory = self.pilot.begin(), {"next": 0.0, "order": 0.0}

        def order(t: float, at: VoyageState) -> float:
            if t >= memory["next"] - 1e-6:
                memory["order"] = round(inner(t, at) / DEGREE) * DEGREE
                memory["next"] = t + ORDER_INTERVAL
            return memory["order"]

        return order


@dataclass(frozen=True)
class TransitTwin:
    truth: Model  # What the ship is
    u: float  # Through the water [m/s]
    duration: float = 2400.0  # How long [s]
    conditions: TransitConditions = field(default_factory=TransitConditions)  # Wind, gusts, and how an aim wanders
    passes: Sequence[float] = ()  # When another ship passes, pushed off and drawn on as in a meeting [s]
    waterway: "Waterway | None" = None  # That it sails along from where it begins, instead of the model's own canal

    def sailed(self, seed: int) -> Voyage:
        draw, told = np.random.default_rng((seed, 11)), self.conditions
        count = math.ceil(self.duration / AIM_STEP) + 1
        aims = wandering(told.wander, told.wander_time, AIM_STEP, count, draw)[:, 0]
        times = AIM_STEP * np.arange(count)
        pilot = WholeDegrees(TransitPilot.of(self.truth, self.u, times, aims, self.waterway))
        pushes: dict[str, Any] = dict(zip("YN", self._pushes(draw), strict=True))
        voyage = simulate(
            self.truth, y=float(aims[0]), u=self.u, duration=self.duration, dt=PUSH_STEP, controller=pilot,
            waterway=self.waterway, **pushes,
        )  # fmt: skip
        if voyage.t[-1] < self.duration - PUSH_STEP:
            raise InputError("this ship does not come through in these gusts; draw another")
        return voyage

    def _pushes(self, draw: np.random.Generator) -> list[list[tuple[float, float]]]:
        """Sway force and yaw moment through the transit: wind, gusts, and ships that pass."""
        told, times = self.conditions, np.arange(0.0, self.duration, PUSH_STEP)
        gusts = wandering(1.0, told.gust_time, PUSH_STEP, len(times), draw, 2) @ told.gust_push(self.truth).T
        pushes = gusts + draw.standard_normal(2) * told.steady_push(self.truth)
        for passed in self.passes:
            pushes += _passing(self.truth, self.u, times - passed)
        return [list(zip(times.tolist(), column, strict=True)) for column in pushes.T.tolist()]


def _passing(model: Model, u: float, since: np.ndarray) -> np.ndarray:
    """Force and moment of a passing ship [N, N m]: off, on, off again in sway, out and back in yaw."""
    # No measured passing force is behind it: its size is that of a bank's suction and its time that of two lengths at
    # twice the speed.
    ship = model.configuration.ship
    size = 0.02 * model.configuration.water.density * u * u * ship.length * ship.draft
    phase = np.clip(since * u / ship.length, -1.0, 1.0)
    inside = np.abs(phase) < 1
    sway = -size * np.cos(1.5 * np.pi * phase) * inside
    yaw = 0.15 * ship.length * size * np.sin(np.pi * phase) * inside
    return np.stack([sway, yaw], axis=1)


def recorded(name: str, voyage: Voyage, grade: SensorGrade, seed: int, current: float = CURRENT) -> ShipRecord:
    draw = np.random.default_rng((seed, 13))
    drift = current * float(draw.standard_normal())
    told = {own: voyage[own] for own in ("x", "y", "psi", "r", "u", "v", "rudder")}
    told["x"] = told["x"] + drift * voyage.t
    told["u_ground"] = told["u"] + drift * np.cos(told["psi"])
    told["v_ground"] = told["v"] - drift * np.sin(told["psi"])
    told["speed_over_ground"] = np.hypot(told["u_ground"], told["v_ground"])
    signals = {own: _read(voyage.t, told[own], grade.signals[own], draw) for own in grade.signals if own in told}
    return ShipRecord(name, signals)


def _read(t: np.ndarray, truth: np.ndarray, grade: SignalGrade, draw: np.random.Generator) -> Signal:
    times = np.arange(t[0], t[-1], grade.period)
    wander = wandering(grade.wander, grade.memory, grade.period, len(times), draw)[:, 0] if grade.wander else 0.0
    error = grade.noise * draw.standard_normal(len(times)) + grade.zero * draw.standard_normal() + wander
    return Signal(times, np.interp(times, t, truth) + error)


def drawn_truth(model: Model, seed: int, **held: float) -> Model:
    names = model.terms.names
    mean = np.array([model.coefficients[name] for name in names])
    bounds = np.array([term.bound for term in model.terms.terms])
    for values in mean + correlated(np.asarray(model.covariance), MOST_DRAWS, (seed, 17)):
        if ((values >= bounds[:, 0] - 1e-9) & (values <= bounds[:, 1] + 1e-9)).all():
            return model.with_coefficients(**{**dict(zip(names, values.tolist(), strict=True)), **held})
    raise InputError("no draw of these coefficients is within the bounds of their terms; identify the model again")


# Dimensions of the ship and the canal [m], as in the case of the Suez section.
LENGTH, WIDTH = 399.94, 205.0
# Speed and duration of a transit, and duration of a short demonstration.
SPEED, MINUTES, SHORT_MINUTES = 8 * KNOT, 40.0, 20.0


@dataclass(frozen=True)
class DemonstratedLog:
    prior: Model  # The ship by its captive tests
    truth: Model  # What it is
    log: ShipLog  # What its sensors recorded


def large_container_ship() -> Model:
    return bundled_ship(LENGTH, WIDTH)


def demonstrated_log(sensors: SensorGrade, transits: int = 10, seed: int = 1) -> DemonstratedLog:
    prior = large_container_ship()
    for ship in range(MOST_SHIPS):
        truth = drawn_truth(prior, MOST_SHIPS * seed + ship)
        try:
            twin = TransitTwin(truth, SPEED, 60 * SHORT_MINUTES)
            return DemonstratedLog(prior, truth, transits_of(truth, sensors, transits, MOST_SHIPS * seed + ship, twin))
        except InputError:
            continue
    raise InputError("none of the ships that were drawn comes through the canal; take another seed")


def transits_of(
    truth: Model, sensors: SensorGrade, transits: int, seed: int, twin: TransitTwin | None = None
) -> ShipLog:
    usual = replace(twin, truth=truth) if twin else TransitTwin(truth, SPEED, 60 * MINUTES)
    records = []
    with bar(transits, is_shown(), "transits") as done:
        for number in range(transits):
            voyage = usual.sailed(1000 * seed + number)
            drawn = {"current": 0.0} if usual.waterway else {}  # A waterway has its own.
            records.append(recorded(f"transit {number + 1}", voyage, sensors, 1000 * seed + number, **drawn))
            done(1)
    return ShipLog(tuple(records), usual.waterway)
