"""Twins: ships with known truth, simulated by the same lanes as the estimate, with sensor readings."""

import math
from dataclasses import dataclass

import numpy as np

from narrows.codegen.choices import STAGES
from narrows.control.closed_loop import LawOrders
from narrows.estimation.sensor import Sensor, drawn_reading
from narrows.estimation.settings import STEPS_A_PERIOD, TWIN_SIDE_TIME, TWIN_START_STD
from narrows.estimation.ship_filter import ShipFilter, default_step
from narrows.estimation.states import Columns
from narrows.physics.rudder import gear_motion
from narrows.quantities.arithmetic import COLUMNS
from narrows.simulation.controllers import ControlLaw
from narrows.simulation.grid import sampled
from narrows.simulation.ship_lanes import RUDDER, ShipLanes


@dataclass(frozen=True)
class Twins:
    """True states of ships, and their readings."""

    t: np.ndarray  # (times,) Time [s]
    states: np.ndarray  # (times, twins, states) The truth
    indicated: np.ndarray  # (times, twins, actuators) Indicated positions of the actuators
    readings: dict[str, np.ndarray]  # (times, twins, numbers) Readings of each sensor; NaN where none was due
    aground: np.ndarray  # (twins,) True if a twin met a bank


@dataclass
class _Fleet:
    filter: ShipFilter
    law: ControlLaw | None
    count: int
    excitation: float
    random: np.random.Generator
    coefficients: np.ndarray
    dt: float

    def __post_init__(self) -> None:
        filter = self.filter
        self.lanes = ShipLanes(filter.ship, filter.states.names, self.count, filter.waterway, self.coefficients)
        self.process = filter.process()
        gear = filter.model.configuration.gear
        self.limit, self.stages = gear.limit, list[np.ndarray]()
        self.gear = {name.removeprefix("rudder_"): value for name, value in gear.values().items()}
        self.side = TWIN_SIDE_TIME * STEPS_A_PERIOD * default_step(filter.model)
        self.orders = LawOrders(filter.model, self.law, self.dt, filter.waterway) if self.law else None

    def started(self, x: float, y: float, u: float, psi: float) -> np.ndarray:
        """Draw the initial states of the twins."""
        filter, draw = self.filter, self.random.standard_normal
        means = {"x": x, "y": y, "psi": psi, "u": u, "bank": 1.0}
        means |= {"current": float(filter.waterway.current_at(x)) if filter.waterway else 0.0}
        spreads = {**filter.spreads, "y": TWIN_START_STD[0] * filter.time_scale**2, "psi": TWIN_START_STD[1]}
        size = np.array([spreads.get(name, 0.0) for name in filter.states.names])
        return np.array(filter.states.vector(means) + size * draw((self.count, len(size))))

    def steered(self, states: np.ndarray, positions: np.ndarray, t: float) -> np.ndarray:
        """Return the positions of the actuators a step later."""
        after, names = positions.copy(), self.filter.actuators
        if self.orders is None or RUDDER not in names:
            return after
        place = names.index(RUDDER)
        known = {**dict(zip(self.filter.states.names, states.T, strict=True)), **dict(zip(names, after.T, strict=True))}
        turn = int(t / self.side)
        swing = self.excitation * (turn % 2 * 2 - 1) * (turn % 3 == 0)
        order = np.clip(self.orders.orders(t, known)[RUDDER] + swing, -self.limit, self.limit)
        stages = self.stages or [positions[:, place]] * STAGES
        moved, self.stages = gear_motion(
            order, positions[:, place], stages, self.gear, self.dt, {**COLUMNS, "exp": np.exp}
        )
        after[:, place] += moved
        return after


def sail_twins(
    filter: ShipFilter, law: ControlLaw | None, start: tuple[float, float, float, float], count: int, duration: float,
    drawn: bool, excitation: float, seed: int,
) -> Twins:  # fmt: skip
    """Simulate ships by the model with the process noise of the estimator."""
    many = max(count, 2)  # One lane alone would share its inputs
    random, dt = np.random.default_rng(seed), min(sensor.period for sensor in filter.sensors.values())
    fleet = _Fleet(filter, law, many, excitation, random, _coefficients(filter, many, drawn, seed), dt)
    times = dt * np.arange(math.floor(duration / dt + 1e-9) + 1)
    states, indicated, aground = _sailed(fleet, start, times)
    noisy = indicated.copy()
    if RUDDER in filter.actuators and filter.indicator.noise:
        place = filter.actuators.index(RUDDER)
        noisy[..., place] += filter.indicator.noise * random.standard_normal(noisy.shape[:2])
    readings = {name: _readings(fleet, sensor, times, states)[:, :count] for name, sensor in filter.sensors.items()}
    return Twins(times, states[:, :count], noisy[:, :count], readings, aground[:count])


def _coefficients(filter: ShipFilter, count: int, drawn: bool, seed: int) -> np.ndarray:
    model = filter.model
    if not drawn:
        return np.tile([model.coefficients[name] for name in model.terms.names], (count, 1))
    columns = sampled(model, count, seed)
    return np.stack([columns[name].to_numpy() for name in model.terms.names], axis=1)


def _sailed(fleet: _Fleet, start: tuple[float, ...], times: np.ndarray) -> tuple[np.ndarray, ...]:
    filter, lanes, dt = fleet.filter, fleet.lanes, fleet.dt
    now, positions = fleet.started(*start), np.tile(filter.at_rest, (fleet.count, 1))
    parts = max(1, math.ceil(dt / filter.step - 1e-9))
    states, indicated, aground = [now], [positions], np.zeros(fleet.count, bool)
    for t in times[:-1]:
        after = fleet.steered(now, positions, float(t))
        for part in range(parts):
            here, there = (positions + share * (after - positions) for share in (part / parts, (part + 1) / parts))
            now = lanes.advance(now, dt / parts, here, there)
            aground |= lanes.aground
            now = fleet.process.after(now, dt / parts, fleet.random)
        positions = after
        states.append(now)
        indicated.append(positions)
    return np.array(states), np.array(indicated), aground


def _readings(fleet: _Fleet, sensor: Sensor, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Readings of a sensor by time of arrival, from the state when measured, linear between the times."""
    every = max(1, round(sensor.period / fleet.dt))
    readings = np.full((len(times), fleet.count, len(sensor.fields)), np.nan)
    for number in range(0, len(times), every):
        if times[number] < sensor.late:
            continue
        measured = (times[number] - sensor.late) / fleet.dt
        before = min(int(measured), len(times) - 2)
        then = states[before] + (measured - before) * (states[before + 1] - states[before])
        at = Columns(then, fleet.filter.states, fleet.lanes.bend(float(then[0, 0])))
        readings[number] = np.stack(drawn_reading(sensor, at, vars(at), fleet.random), axis=1)
    return readings
