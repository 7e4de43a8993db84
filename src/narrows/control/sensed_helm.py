"""A controller with sensors and an estimator."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

import narrows
from narrows.codegen.choices import WATER
from narrows.control.predictive.line_frame import water_ahead
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.controllers import ORDER_TOLERANCE, ControlLaw, Order, VoyageState
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import WATER_PREFIX

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


@dataclass
class LawOrders:
    """Orders of a law in arithmetic, step by step, of one ship or of columns of ships."""

    model: Model
    law: ControlLaw
    dt: float
    waterway: "Waterway | None" = None
    _memory: Mapping[str, Any] | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self._ahead = water_ahead(self.model, self.waterway)
        self._known = {**SimulatedShip(self.model).values(), **self.law.parameters(), "dt": self.dt}
        self._known |= {"water": self._water}

    def __call__(self, t: float, state: VoyageState) -> float:
        return float(self.orders(t, state._asdict())["rudder"])

    def orders(self, t: float, state: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return the orders of a time; they change the memory."""
        at = {**self._known, "t": t, "current": self._along("current", state["x"]), **state}
        at |= {"cos_psi": np.cos(at["psi"]), "sin_psi": np.sin(at["psi"])}
        memory = self.law.memory(at) if self._memory is None else self._memory
        try:
            orders, self._memory = self.law.orders(SimpleNamespace(**{**at, **memory}))
        except AttributeError as lacking:
            raise InputError(f"the {type(self.law).__name__} needs an unknown ({lacking}); take another") from None
        return orders

    def _water(self, name: str, x: Any) -> Any:
        return self._along(WATER[f"{WATER_PREFIX}{name}"], x)

    def _along(self, column: str, x: Any) -> np.ndarray:
        return self._ahead.at(np.ravel(x))[column].reshape(np.shape(x))


@dataclass
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
        """Return the function of orders for one voyage; it replaces that of the previous voyage."""
        estimation, random, helm = narrows.estimation, np.random.default_rng(self.seed), self.controller
        self.estimator = self.estimator or estimation.Estimator(self.model, self.sensors, waterway=self.waterway)
        self.estimator.forget()
        if isinstance(helm, ControlLaw):
            self._inner: Any = LawOrders(self.model, helm, self.dt, self.waterway)
        else:
            self._inner = helm.begin() if hasattr(helm, "begin") else helm
        self._past: list[tuple[float, VoyageState]] = []
        self._due: dict[str, float] = {}
        self._ahead = water_ahead(self.model, self.waterway)
        self._measuring, self._indicator = estimation.ship_filter.split_sensors(self.sensors)
        self._longest = max(sensor.late for sensor in self._measuring.values())
        self._errors = {n: estimation.sensor.ErrorProcess(one, random) for n, one in self._measuring.items()}
        self._bias = self._indicator.bias * random.standard_normal()
        self._random = random
        return self._order

    def _order(self, t: float, state: VoyageState) -> float:
        self._past = [(then, seen) for then, seen in self._past if then > t - self._longest - 2 * self.dt]
        self._past.append((t, state))
        rudder = state.rudder + float(self._indicator.noise * self._random.standard_normal() - self._bias)
        estimate = self.estimator.update(t, {**dict(self._readings(t)), "rudder": rudder})
        if not estimate.ready:
            # No estimate yet: the rudder stays.
            return state.rudder
        seen = {name: estimate[name] for name in ("x", "y", "psi", "u", "v", "r")}
        return float(self._inner(t, VoyageState(**seen, rudder=rudder)))

    def _readings(self, t: float) -> Iterator[tuple[str, Any]]:
        for name, sensor in self._measuring.items():
            if t < self._due.get(name, -math.inf) - ORDER_TOLERANCE * self.dt or t < sensor.late:
                continue
            self._due[name] = t + sensor.period
            yield name, self._errors[name].reading(self._at(t - sensor.late))

    def _at(self, time: float) -> SimpleNamespace:
        """Return the state at a time, linear between stored ones, with further quantities for sensors."""
        times = [then for then, _ in self._past]
        columns = np.array([seen for _, seen in self._past]).T
        then = VoyageState(*(float(np.interp(time, times, column)) for column in columns))
        water = self._ahead.at(np.array([then.x]))
        calm = {"current_across": 0.0, "rudder_bias": 0.0, "bank": 1.0}
        along = {name: float(water[name][0]) for name in ("current", "curvature")}
        return SimpleNamespace(**then._asdict(), **calm, **along)
