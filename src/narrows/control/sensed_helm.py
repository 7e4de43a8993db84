"""A controller with sensors and an estimator."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

import narrows
from narrows.codegen.choices import WATER
from narrows.control.predictive.line_frame import WaterAhead, water_ahead
from narrows.model.model import Model
from narrows.quantities.arithmetic import COLUMNS
from narrows.simulation.controllers import EARLY, ControlLaw, Order, VoyageState
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import steering_of

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


@dataclass
class LawOrders:
    """Orders of a law in arithmetic, step by step, as a function of time and state."""

    model: Model
    law: ControlLaw
    dt: float
    waterway: "Waterway | None" = None
    _memory: dict[str, Any] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        ship = SimulatedShip(self.model)
        steering = steering_of(self.law, ship.actuators)
        assert steering is not None
        self._tape, self._begin = steering.law.tape, steering.memory
        ahead = water_ahead(self.model, self.waterway)
        self._numbers = {**ship.values(), **steering.parameters, "step_length": self.dt}
        self._functions = {**COLUMNS, **{name: _water(ahead, column) for name, column in WATER.items()}}
        self._current = _water(ahead, "current")

    def __call__(self, t: float, state: VoyageState) -> float:
        at: dict[str, Any] = {**state._asdict(), "t": t, "cos_psi": math.cos(state.psi), "sin_psi": math.sin(state.psi)}
        at["current"] = float(self._current(state.x))
        self._memory = self._memory or dict(self._begin(at))
        found = self._tape.replay({**self._numbers, **at, **self._memory}, functions=self._functions)
        self._memory = {name: found[name] for name in self._memory}
        return float(found["rudder"])


def _water(ahead: WaterAhead, column: str) -> Any:
    return lambda x: ahead.at(np.atleast_1d(x))[column][0]


@dataclass(frozen=True)
class SensedHelm:
    """A controller of single voyages: readings of the true state, an estimate from them, an order from that."""

    model: Model
    controller: Any
    sensors: Sequence[Any]
    estimator: Any
    dt: float
    waterway: "Waterway | None" = None
    seed: int = 0

    def begin(self) -> Order:
        """Return what gives the orders of one voyage."""
        estimator = self.estimator
        if estimator is None:
            estimator = narrows.estimation.Estimator(self.model, self.sensors, waterway=self.waterway)
        estimator.forget()
        helm = self.controller
        if isinstance(helm, ControlLaw):
            inner: Any = LawOrders(self.model, helm, self.dt, self.waterway)
        else:
            inner = helm.begin() if hasattr(helm, "begin") else helm
        return _SensedOrders(self, estimator, inner, np.random.default_rng(self.seed))


@dataclass
class _SensedOrders:
    helm: SensedHelm
    estimator: Any
    inner: Order
    random: np.random.Generator
    _past: list[tuple[float, VoyageState]] = field(default_factory=list)
    _due: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._ahead = water_ahead(self.helm.model, self.helm.waterway)
        self._measuring = [sensor for sensor in self.helm.sensors if hasattr(sensor, "measured")]
        self._indicator = next((one for one in self.helm.sensors if not hasattr(one, "measured")), None)
        self._longest = max((sensor.late for sensor in self._measuring), default=0.0)
        # Declared errors of the sensors, drawn: component, standard deviation, correlation time [s]; and their values.
        self._errors = {one.name: narrows.estimation.sensor.error_states(one).values() for one in self._measuring}
        draw = self.random.standard_normal
        self._slow = {name: [std * draw() for _, std, _ in errors] for name, errors in self._errors.items()}
        self._bias = self._indicator.bias * draw() if self._indicator is not None else 0.0

    def __call__(self, t: float, state: VoyageState) -> float:
        self._past = [(then, seen) for then, seen in self._past if then > t - self._longest - 2 * self.helm.dt]
        self._past.append((t, state))
        readings = dict(self._readings(t)) | {"rudder": self._indicated(state.rudder)}
        estimate = self.estimator.update(t, readings)
        if not estimate.ready:
            # No estimate yet: the rudder stays.
            return state.rudder
        seen = {name: estimate[name] for name in ("x", "y", "psi", "u", "v", "r")}
        return self.inner(t, VoyageState(**seen, rudder=readings["rudder"]))

    def _indicated(self, rudder: float) -> float:
        noise = self._indicator.noise if self._indicator is not None else 0.0
        return rudder + float(noise * self.random.standard_normal() - self._bias)

    def _readings(self, t: float) -> Mapping[str, Any]:
        readings = {}
        for sensor in self._measuring:
            if t < self._due.get(sensor.name, -math.inf) - EARLY * self.helm.dt or t < sensor.late:
                continue
            self._due[sensor.name] = t + sensor.period
            true = sensor.measured(self._at(t - sensor.late))
            noise = np.asarray(sensor.sigma) * self.random.standard_normal(len(sensor.fields))
            slow = self._slow[sensor.name]
            for number, (place, std, time) in enumerate(self._errors[sensor.name]):
                left = math.exp(-sensor.period / time)
                slow[number] = left * slow[number] + std * math.sqrt(1.0 - left**2) * self.random.standard_normal()
                noise[place] += slow[number]
            told = sensor.reading(tuple(float(value) + off for value, off in zip(true, noise, strict=True)))
            readings[sensor.name] = tuple(map(float, told)) if len(told) > 1 else float(told[0])
        return readings

    def _at(self, time: float) -> SimpleNamespace:
        """Return the state at a time, linear between stored ones, with further quantities for sensors."""
        times = [then for then, _ in self._past]
        columns = np.array([seen for _, seen in self._past]).T
        then = VoyageState(*(float(np.interp(time, times, column)) for column in columns))
        water = self._ahead.at(np.array([then.x]))
        calm = {"current_across": 0.0, "rudder_bias": 0.0, "bank": 1.0}
        along = {name: float(water[name][0]) for name in ("current", "curvature")}
        return SimpleNamespace(**then._asdict(), **calm, **along)
