"""Simulate ship, gear, sensors, estimator and controller as one loop, and linearise that same loop."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

import narrows
from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, needs
from narrows.base.results import BaseSummary
from narrows.codegen.free_motion import COUNTED, TIME, WATER
from narrows.control import settings
from narrows.control.linear_system import loop_margins
from narrows.control.predictive.course_ahead import water_ahead
from narrows.control.steady_course import check_rudder, linearize
from narrows.model.model import Model
from narrows.ship.actuators import SteeringGear
from narrows.simulation.controllers import ORDER_TOLERANCE, ControlLaw, Named, Order, VoyageState
from narrows.simulation.initial_state import VoyageIntegrator, initial_state
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.simulation.ship import MEMORY, PARAMETER, WATER_PREFIX, SimulatedShip, steering_of
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

ORDERED, ASKED = "loop_ordered", "loop_asked"
# States of a voyage that are not states of a loop about a steady course, such as place along the line and time.
LEFT_OUT = ("x", TIME, COUNTED, "sin_psi", "u", MEMORY(ASKED))


@dataclass(frozen=True)
class OpenedLaw:
    """A law whose rudder order goes into the memory, while the rudder gets an external order."""

    law: ControlLaw

    def parameters(self) -> Mapping[str, Any]:
        return {**self.law.parameters(), ORDERED: 0.0}

    def memory(self, start: Named) -> Named:
        return {**self.law.memory(start), ASKED: start["rudder"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        orders, memory = self.law.orders(at)
        return {**orders, "rudder": getattr(at, ORDERED)}, {**memory, ASKED: orders["rudder"]}


@dataclass(frozen=True, repr=False, eq=False)
class ClosedLoop(BaseSummary):
    """A ship under a controller; the result of ``closed_loop``, whose arguments it has as attributes."""

    model: Model
    controller: Any
    y: float
    u: float
    dt: float
    waterway: "Waterway | None" = None
    x: float = 0.0
    sensors: Sequence[Any] = ()
    estimator: Any = None

    @cached_property
    def course(self) -> dict[str, float]:
        """The steady course: psi, rudder [rad], v [m/s], r [rad/s], and the propeller revolutions [1/s]."""
        linear = linearize(self.model, self.y, self.u, waterway=self.waterway, at=self.x)
        names = ("psi", "v", "r", "rudder", *(a.name for a in self.model.terms.actuators if a.name != "rudder"))
        return {name: linear.course[name] for name in names}

    def simulate(self, duration: float | None = None, seed: int = 0, **voyage: Any) -> Voyage:
        """Simulate one voyage as ``simulate`` does, by default for 40 ship lengths from the steady course.

        ``seed`` is that of the sensor noise.
        """
        helm = SensedHelm(self, seed) if self.sensors else self.controller
        begun = {"y": self.y, "u": self.u, "x": self.x, "dt": self.dt, "waterway": self.waterway, **self.course}
        time = settings.LOOP_DURATION * self._passing if duration is None else duration
        return simulate(self.model, **{**begun, "duration": time, "controller": helm, **voyage})

    @property
    def _passing(self) -> float:
        return self.model.configuration.ship.length / self.u

    @cached_property
    def states(self) -> tuple[str, ...]:
        """Names of the states of the loop: ship, gear and memory of the law."""
        kept = self._opened[0].choices.kept
        return tuple("psi" if name == "cos_psi" else name for name in kept if name not in LEFT_OUT)

    @cached_property
    def _opened(self) -> tuple[VoyageIntegrator, dict[str, float]]:
        """The integrator of the opened loop, and its state on the steady course."""
        if not isinstance(self.controller, ControlLaw):
            what = f"a {type(self.controller).__name__} is no law in arithmetic"
            raise InputError(f"{what}, so its loop has no matrices: simulate it with a gear of more dead_time")
        ship = SimulatedShip(self.model)
        steering = steering_of(OpenedLaw(self.controller), ship.actuators)
        numbers = {"x": self.x, "y": self.y, "u": self.u, **self.course}
        integrator, start = initial_state(ship, steering, numbers, self.waterway, False)
        # A dead band has no derivative: the loop is linearised for orders beyond it.
        integrator.set(rudder_dead_band=0.0)
        return integrator, dict(zip(integrator.choices.kept, start, strict=True), psi=self.course["psi"])

    def _stepped(self, both: np.ndarray) -> np.ndarray:
        """Return the state a step later under an order, and the law's order, from a state and that order."""
        integrator, start = self._opened
        values = {**start, **dict(zip(self.states, both, strict=False))}
        values |= {"cos_psi": math.cos(values["psi"]), "sin_psi": math.sin(values["psi"])}
        integrator.set(**{PARAMETER(ORDERED): float(both[-1])})
        after, *_ = integrator.stepped(tuple(values[name] for name in integrator.choices.kept), self.dt)
        later = dict(zip(integrator.choices.kept, after, strict=True))
        later["psi"] = math.atan2(later["sin_psi"], later["cos_psi"])
        return np.array([later[name] for name in (*self.states, MEMORY(ASKED))])

    @cached_property
    def _matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A, B and C of the opened loop about its steady state, found by Newton's method."""
        # By central differences of the engine's own step.
        ship, start = self.model.configuration.ship, self._opened[1]
        known = {"y": ship.beam, "v": self.u, "r": self.u / ship.length, MEMORY("integral"): ship.beam * self._passing}
        sizes = np.array([known.get(name, 1.0) for name in (*self.states, ASKED)])
        both = np.array([*(start[name] for name in self.states), 0.0])
        for _ in range(settings.NEWTON_ROUNDS):
            both[-1] = self.course["rudder"]
            both[-1] = self._stepped(both)[-1]
            off = self._stepped(both)[:-1] - both[:-1]
            steps = np.diag(1e-5 * sizes)
            ends = [(self._stepped(both + step) - self._stepped(both - step)) / (2 * step.max()) for step in steps]
            rows = np.stack(ends, axis=1)
            A, B, C = rows[:-1, :-1], rows[:-1, -1:], rows[-1:, :-1]
            if np.abs(off / sizes[:-1]).max() < settings.SAME_STATE:
                return A, B, C
            both[:-1] += np.linalg.lstsq(np.eye(len(off)) - A - B @ C, off, rcond=None)[0]
        where = f"{self.y:g} m off the middle at {self.u:g} m/s; choose another, or simulate it"
        raise InputError(f"the {type(self.controller).__name__} does not keep this ship on a steady course {where}")

    def state_space(self, opened: bool = False) -> Any:
        """Return the loop as a discrete state space of python-control, at its time step.

        ``opened``: from the gear's order to the law's order, with the sign changed. Otherwise: from an order added to
        the law's to the offset, heading and rudder.
        """
        with needs("control", "state_space"):
            import control
        A, B, C = self._matrices
        named: dict[str, Any] = {"inputs": ["order"], "states": list(self.states), "name": "loop"}
        if opened:
            return control.ss(A, B, -C, 0, self.dt, outputs=["asked"], **named)
        seen = ["y", "psi", "rudder"]
        out = np.eye(len(A))[[self.states.index(name) for name in seen]]
        return control.ss(A + B @ C, B, out, 0, self.dt, outputs=seen, **named)

    def poles(self) -> np.ndarray:
        """Return the growth rates of deviations from the course [1/s], the most unstable first.

        They are the logarithms of the discrete poles over the time step.
        """
        A, B, C = self._matrices
        found = np.linalg.eigvals(A + B @ C)
        rates = np.log(np.where(np.abs(found) > 0, found, np.finfo(float).tiny).astype(complex)) / self.dt
        return np.asarray(rates[np.argsort(-rates.real, kind="stable")])

    def margins(self) -> dict[str, float]:
        """Return the stability margins of the loop, broken at the rudder order.

        ``gain`` and ``gain_down`` [1]: factors of the order; ``phase_deg`` [deg]; ``delay`` [s]: a further delay of the
        order; ``distance`` [1]: the least distance of the Nyquist curve from -1; ``sensitivity_peak`` [1], its inverse.
        """
        A, B, C = self._matrices
        poles = self.poles()
        # An unstable loop has no margins.
        if poles[0].real > 0:
            none = dict.fromkeys(("gain", "gain_down", "phase_deg", "delay", "distance"), 0.0)
            return {**none, "sensitivity_peak": math.inf}
        slowest = float(np.abs(poles)[np.abs(poles) > 0].min(initial=1.0 / self._passing))
        return loop_margins(A, B, -C, 1e-2 * slowest, math.pi / self.dt, self.dt)

    def summary(self) -> str:
        gear = self.model.configuration.gear
        slow = f", {gear.dead_time:g} s of dead time, {gear.lag:g} s of lag" if gear.delay else ""
        sees = f" by {', '.join(sensor.name for sensor in self.sensors)}" if self.sensors else ""
        about = f"{type(self.controller).__name__} at y = {self.y:g} m and u = {self.u:g} m/s"
        return f"{about}{sees}, an order every {self.dt:g} s{slow}"


@accept_aliases
def closed_loop(
    model: Model, controller: Any, *, gear: SteeringGear | None = None, sensors: Sequence[Any] = (),
    estimator: Any = None, waterway: "Waterway | None" = None, y: float | None = None, u: float | None = None,
    x: float = 0.0, dt: float = 1.0,
) -> ClosedLoop:  # fmt: skip
    """Join a ship, its steering gear, its sensors and its controller.

    Parameters
    ----------
    model, gear : Model, SteeringGear, optional
        The ship, with terms of a rudder, and another gear than its own.
    controller : ControlLaw or Controller
        A regulator, a predictive helm, a law or a function of your own.
    sensors, estimator : sequence of Sensor, Estimator, optional
        Sensors of the controller, and what estimates the state from their readings, by default ``Estimator(model,
        sensors)``; without sensors the controller gets the true state.
    waterway : Waterway, optional
        Waterway instead of the model's own canal.
    y, u : float, optional
        Offset [m] and surge velocity through the water [m/s] of the steady course; default: those of the controller.
    x, dt : float
        Place along the waterway [m], time between orders [s].
    """
    check_rudder(model)
    check_waterway(waterway)
    line = controller.lines[0].y if hasattr(controller, "lines") else getattr(controller, "y", None)
    offset, speed = (line if y is None else y), (getattr(controller, "u", None) if u is None else u)
    for name, value in (("y", offset), ("u", speed)):
        if value is None:
            raise InputError(f"the {type(controller).__name__} does not say for which {name} it is; give {name}")
    numbers = finite_numbers(y=offset, u=speed, x=x, dt=dt)
    if not numbers["dt"] > 0:
        raise InputError(f"dt = {dt} s is no time between orders; give seconds over 0")
    if estimator is not None and not sensors:
        raise InputError("an estimator needs the sensors that it was made for; give sensors too")
    if gear is not None:
        model = replace(model, configuration=replace(model.configuration, steering=gear))
    return ClosedLoop(model, controller, waterway=waterway, sensors=tuple(sensors), estimator=estimator, **numbers)


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
        self._known |= {"water": lambda name, x: self._along(WATER[f"{WATER_PREFIX}{name}"], x)}

    def __call__(self, t: float, state: VoyageState) -> float:
        return float(self.orders(t, state._asdict())["rudder"])

    def orders(self, t: float, state: Mapping[str, Any]) -> Mapping[str, Any]:
        at = {**self._known, "t": t, "current": self._along("current", state["x"]), **state}
        at |= {"cos_psi": np.cos(at["psi"]), "sin_psi": np.sin(at["psi"])}
        memory = self.law.memory(at) if self._memory is None else self._memory
        try:
            orders, self._memory = self.law.orders(SimpleNamespace(**{**at, **memory}))
        except AttributeError as lacking:
            raise InputError(f"the {type(self.law).__name__} needs an unknown ({lacking}); take another") from None
        return orders

    def _along(self, column: str, x: Any) -> np.ndarray:
        return self._ahead.at(np.ravel(x))[column].reshape(np.shape(x))


@dataclass
class SensedHelm:
    """A controller of single voyages: readings of the true state, an estimate from them, an order from that."""

    loop: ClosedLoop
    seed: int

    def begin(self) -> Order:
        """Return the function of orders for one voyage; it replaces that of the previous voyage."""
        estimation, random, loop = narrows.estimation, np.random.default_rng(self.seed), self.loop
        self._estimator = loop.estimator or estimation.Estimator(loop.model, loop.sensors, waterway=loop.waterway)
        self._estimator.forget()
        if isinstance(loop.controller, ControlLaw):
            self._inner: Any = LawOrders(loop.model, loop.controller, loop.dt, loop.waterway)
        else:
            self._inner = loop.controller.begin() if hasattr(loop.controller, "begin") else loop.controller
        self._past: list[tuple[float, VoyageState]] = []
        self._ahead = water_ahead(loop.model, loop.waterway)
        measuring, self._indicator = estimation.sensors.split_sensors(loop.sensors)
        self._longest = max(sensor.delay for sensor in measuring.values())
        self._errors = {n: estimation.sensors.ErrorProcess(one, random) for n, one in measuring.items()}
        self._due = dict.fromkeys(measuring, -math.inf)
        self._bias, self._random = self._indicator.bias * random.standard_normal(), random
        return self._order

    def _order(self, t: float, state: VoyageState) -> float:
        self._past = [(then, seen) for then, seen in self._past if then > t - self._longest - 2 * self.loop.dt]
        self._past.append((t, state))
        rudder = state.rudder + float(self._indicator.noise * self._random.standard_normal() - self._bias)
        estimate = self._estimator.update(t, {**dict(self._readings(t)), "rudder": rudder})
        if not estimate.ready:
            # No estimate yet: the rudder stays.
            return state.rudder
        seen = {name: estimate[name] for name in ("x", "y", "psi", "u", "v", "r")}
        return float(self._inner(t, VoyageState(**seen, rudder=rudder)))

    def _readings(self, t: float) -> Iterator[tuple[str, Any]]:
        times, states = zip(*self._past, strict=True)
        for name, errors in self._errors.items():
            if t < max(self._due[name] - ORDER_TOLERANCE * self.loop.dt, errors.sensor.delay):
                continue
            self._due[name] = t + errors.sensor.period
            # The state when measured, linear between stored ones, with further quantities for sensors.
            then = VoyageState(*(np.interp(t - errors.sensor.delay, times, one) for one in zip(*states, strict=True)))
            water = {name: float(one[0]) for name, one in self._ahead.at(np.array([then.x])).items()}
            calm = {"current_across": 0.0, "rudder_bias": 0.0, "bank": 1.0}
            yield name, errors.reading(SimpleNamespace(**then._asdict(), **calm, **water))
