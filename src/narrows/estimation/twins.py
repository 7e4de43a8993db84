"""Twins: ships with known truth, simulated by the same lanes as the estimate, with sensor readings."""

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from narrows.codegen.choices import STAGES, WATER
from narrows.control.predictive.line_frame import water_ahead
from narrows.errors import InputError
from narrows.estimation.recursion import MarkovProcess
from narrows.estimation.sensor import Sensor, error_states
from narrows.estimation.settings import STEPS_A_PERIOD, TWIN_SIDE_TIME, TWIN_START_STD
from narrows.estimation.ship_filter import ShipFilter, default_step
from narrows.estimation.ship_lanes import RUDDER, ShipLanes
from narrows.estimation.states import Columns
from narrows.physics.rudder import gear_motion
from narrows.quantities.arithmetic import COLUMNS
from narrows.simulation.controllers import ControlLaw
from narrows.simulation.grid import sampled
from narrows.simulation.steering import WATER_PREFIX


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

    def __post_init__(self) -> None:
        filter = self.filter
        self.lanes = ShipLanes(filter.ship, filter.states, self.count, filter.waterway, self.coefficients)
        self.process = MarkovProcess(*np.array([filter.walks[name] for name in filter.states.names]).T)
        gear = filter.model.configuration.gear
        self.limit, self.rate = gear.limit, gear.rate
        self.gear = {name.removeprefix("rudder_"): value for name, value in gear.values().items()}
        self.stages: list[np.ndarray] = []
        self.side = TWIN_SIDE_TIME * STEPS_A_PERIOD * default_step(filter.model)
        self.ahead = water_ahead(filter.model, filter.waterway)

    def water(self, name: str, x: np.ndarray) -> np.ndarray:
        """Return the water quantities of a control law at places along it, by the names of ``steering.water``."""
        return self.ahead.at(x)[WATER[f"{WATER_PREFIX}{name}"]]

    def started(self, x: float, y: float, u: float, psi: float) -> np.ndarray:
        """Draw the initial states of the twins."""
        filter, draw = self.filter, self.random.standard_normal
        means = {"x": x, "y": y, "psi": psi, "u": u, "bank": 1.0}
        means |= {"current": float(self.ahead.at(np.array([x]))["current"][0])}
        spreads = {**filter.spreads, "y": TWIN_START_STD[0] * filter.time_scale**2, "psi": TWIN_START_STD[1]}
        size = np.array([spreads.get(name, 0.0) for name in filter.states.names])
        return np.array(filter.states.vector(means) + size * draw((self.count, len(size))))

    def steered(self, states: np.ndarray, positions: np.ndarray, t: float, dt: float, memory: Any) -> tuple[Any, Any]:
        after, names = positions.copy(), self.filter.actuators
        if self.law is None or RUDDER not in names:
            return after, memory
        place = names.index(RUDDER)
        columns = dict(zip(self.filter.states.names, states.T, strict=True))
        at = {**columns, "cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"]), "t": t, "dt": dt}
        at |= {**dict(zip(names, positions.T, strict=True)), **self.law.parameters()}
        at |= {"rudder_limit": self.limit, "rudder_rate": self.rate, "water": self.water}
        at.setdefault("current", self.ahead.at(columns["x"])["current"])
        if memory is None:
            memory = self.law.memory(at)
        try:
            orders, memory = self.law.orders(SimpleNamespace(**{**at, **memory}))
        except AttributeError as lacking:
            raise InputError(
                f"the {type(self.law).__name__} asks for more than twins have ({lacking}); take another"
            ) from None
        turn = int(t / self.side)
        swing = self.excitation * (turn % 2 * 2 - 1) * (turn % 3 == 0)
        order = np.clip(orders[RUDDER] + swing, -self.limit, self.limit)
        stages = self.stages or [positions[:, place]] * STAGES
        moved, self.stages = gear_motion(order, positions[:, place], stages, self.gear, dt, {**COLUMNS, "exp": np.exp})
        after[:, place] += moved
        return after, memory


def sail_twins(
    filter: ShipFilter, law: ControlLaw | None, start: tuple[float, float, float, float], count: int, duration: float,
    drawn: bool, excitation: float, seed: int,
) -> Twins:  # fmt: skip
    """Simulate ships by the model with the process noise of the estimator."""
    many = max(count, 2)  # One lane alone would share its inputs
    random = np.random.default_rng(seed)
    fleet = _Fleet(filter, law, many, excitation, random, _coefficients(filter, many, drawn, seed))
    dt = min(sensor.period for sensor in filter.sensors.values())
    times = dt * np.arange(math.floor(duration / dt + 1e-9) + 1)
    states, indicated, aground = _sailed(fleet, start, times, dt)
    noisy = indicated.copy()
    if RUDDER in filter.actuators and filter.indicator.noise:
        place = filter.actuators.index(RUDDER)
        noisy[..., place] += filter.indicator.noise * random.standard_normal(noisy.shape[:2])
    readings = {name: _told(fleet, sensor, times, states)[:, :count] for name, sensor in filter.sensors.items()}
    return Twins(times, states[:, :count], noisy[:, :count], readings, aground[:count])


def _coefficients(filter: ShipFilter, count: int, drawn: bool, seed: int) -> np.ndarray:
    model = filter.model
    if not drawn:
        return np.tile([model.coefficients[name] for name in model.terms.names], (count, 1))
    columns = sampled(model, count, seed)
    return np.stack([columns[name].to_numpy() for name in model.terms.names], axis=1)


def _sailed(fleet: _Fleet, start: tuple[float, ...], times: np.ndarray, dt: float) -> tuple[np.ndarray, ...]:
    filter, lanes, count = fleet.filter, fleet.lanes, fleet.count
    x, y, u, psi = start
    now = fleet.started(x, y, u, psi)
    values = filter.ship.values()
    positions = np.tile([float(values.get(name) or 0.0) for name in filter.actuators], (count, 1))
    parts = max(1, math.ceil(dt / filter.step - 1e-9))
    states, indicated = [now], [positions]
    aground, memory = np.zeros(count, bool), None
    for t in times[:-1]:
        after, memory = fleet.steered(now, positions, float(t), dt, memory)
        for part in range(parts):
            here, there = (positions + share * (after - positions) for share in (part / parts, (part + 1) / parts))
            now = lanes.advance(now, dt / parts, here, there)
            aground |= lanes.aground
            left, noise = fleet.process.over(dt / parts)
            now[:, fleet.process.places] *= left
            now = now + fleet.random.standard_normal((len(now), len(noise))) @ noise
        positions = after
        states.append(now)
        indicated.append(positions)
    return np.array(states), np.array(indicated), aground


def _told(fleet: _Fleet, sensor: Sensor, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Readings of a sensor at their arrival: of the state when measured, linear between the times."""
    dt = times[1] - times[0]
    every = max(1, round(sensor.period / dt))
    told = np.full((len(times), fleet.count, len(sensor.fields)), np.nan)
    for number in range(0, len(times), every):
        measured = max(0.0, times[number] - sensor.late) / dt
        before = min(int(measured), len(times) - 2)
        share = measured - before
        if times[number] < sensor.late:
            continue
        then = (1.0 - share) * states[before] + share * states[before + 1]
        at = Columns(then, fleet.filter.states, fleet.lanes.bend(float(then[0, 0])))
        noise = np.array(sensor.sigma) * fleet.random.standard_normal((fleet.count, len(sensor.fields)))
        numbers = [np.asarray(value) for value in sensor.measured(at)]
        for state, (place, _, _) in error_states(sensor).items():
            noise[:, place] += then[:, fleet.filter.states.places[state]]
        told[number] = np.stack(sensor.reading(tuple(np.stack(numbers) + noise.T)), axis=1)
    return told


def check_law(law: Any) -> None:
    if law is not None and not isinstance(law, ControlLaw):
        raise InputError(f"a {type(law).__name__} cannot steer twins; give a law in arithmetic, such as Autopilot")
