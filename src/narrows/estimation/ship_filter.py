"""The filter's view of a ship with its sensors: states, motion, measurements."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from narrows.codegen.free_motion import Surge
from narrows.errors import InputError
from narrows.estimation.recursion import DriftMonitor, Recursion
from narrows.estimation.sensor import MarkovProcess, Sensor, error_states
from narrows.estimation.sensors import SENSORS, RudderIndicator
from narrows.estimation.settings import (
    MODEL_FAULT,
    REFERENCE_LENGTH,
    RUDDER_FAULT_STD,
    RUDDER_FAULT_TIME,
    START_READINGS,
    STEPS_A_PERIOD,
)
from narrows.estimation.states import MOTION_STATES, STATES, Columns, Prior, ProcessNoise, StateNames
from narrows.estimation.unscented import Gaussian, Transformed, sigma_point_weights, triangular_root
from narrows.model.model import Model
from narrows.quantities.names import GRAVITY
from narrows.simulation.inputs import Contact
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.ship_lanes import RUDDER, ShipLanes

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

MODEL = "model"
Coefficients = Literal["considered", "certain", "estimated"]


class MotionStep(NamedTuple):
    before: Gaussian  # State before the step
    state: Gaussian  # State after the step
    how: Transformed  # Transformation of the root
    aground: bool  # True if the mean met a bank, or is NaN


# States needed for a start, in words; the other states begin at their priors.
NEEDED = {"x": "a place", "y": "a place", "psi": "a heading", "u": "a speed through the water"}
# Velocity through the water that a change of each current makes.
WATER_VELOCITIES = {"current": "u", "current_across": "v"}


class StartValue(NamedTuple):
    value: float  # Value of a state
    std: float  # Standard deviation of its white error
    errors: dict[str, float]  # Derivatives by the states of its sensor's errors, times their standard deviations


@dataclass
class Start:
    """The latest readings of each sensor, collected for a start: their median, not the first."""

    filter: "ShipFilter"
    readings: dict[str, list[tuple[float, Sequence[float]]]] = field(default_factory=dict)  # With their times [s]

    def add(self, t: float, readings: Mapping[str, Sequence[float]]) -> None:
        for name, reading in readings.items():
            self.readings[name] = [*self.readings.get(name, ())[1 - START_READINGS :], (t, reading)]

    def values(self) -> dict[str, StartValue]:
        """Return the states from the readings; of two sensors of the same state, the better."""
        found: dict[str, StartValue] = {}
        for name, rows in self.readings.items():
            if len(rows) < START_READINGS:
                continue
            sensor = self.filter.sensors[name]
            starts = [sensor.start(reading) for _, reading in rows]
            for state, (last, std) in starts[-1].items():
                values = [start[state][0] for start in starts]
                if state == "psi":
                    values = [last + math.remainder(value - last, 2.0 * math.pi) for value in values]
                value = StartValue(float(np.median(values)), std, self._slopes(name, rows[-1][1], state))
                if state not in found or _width(value) < _width(found[state]):
                    found[state] = value
        return found

    def _slopes(self, name: str, reading: Sequence[float], state: str) -> dict[str, float]:
        sensor, slopes = self.filter.sensors[name], {}
        for error, (place, std, _) in error_states(sensor, name in self.filter.faults).items():
            moved = [number + (place == number_place) for number_place, number in enumerate(reading)]
            slopes[error] = std * (sensor.start(moved)[state][0] - sensor.start(reading)[state][0])
        return slopes

    @property
    def missing(self) -> str:
        """Return what is missing, in words; empty if there are enough readings."""
        known = self.values()
        return " and ".join(dict.fromkeys(what for state, what in NEEDED.items() if state not in known))

    def state(self, t: float) -> Gaussian:
        """Return the state at a time from the readings and the priors."""
        filter, known = self.filter, self.values()
        names, places = filter.states.names, filter.states.places
        current = float(filter.waterway.current_at(known["x"].value)) if filter.waterway else 0.0
        mean = filter.states.vector({"current": current, **{name: one.value for name, one in known.items()}})
        root = np.diag([known[name].std if name in known else filter.spreads[name] for name in names])
        for name, one in known.items():
            for error, slope in one.errors.items():
                root[places[name], places[error]] -= slope
        p, size, more = filter.considered, len(names), filter.estimated
        full = np.zeros((size + more, p + size + more))
        full[:size, p : p + size], full[size:, p + size :] = root, np.eye(more)
        mean = self._at_midship(t, mean, full[:size, p:])
        return Gaussian(np.concatenate([mean, np.zeros(more)]), full)

    def _at_midship(self, t: float, mean: np.ndarray, root: np.ndarray) -> np.ndarray:
        """Convert antenna positions to one time and to midship, in the root too, since the heading is uncertain."""
        filter = self.filter
        name = next(name for name, rows in self.readings.items() if "x" in filter.sensors[name].start(rows[-1][1]))
        sensor, way = filter.sensors[name], mean[3] * np.array([math.cos(mean[2]), math.sin(mean[2])])
        place = np.median([np.array(reading) + (t - then) * way for then, reading in self.readings[name]], axis=0)
        bend = filter.recursion.lanes.bend(float(place[0]))

        def measured(state: np.ndarray) -> np.ndarray:
            found = sensor.measured(Columns(state[None], filter.states, bend))
            return np.array([float(np.ravel(number)[0]) for number in found])

        for _ in range(6):  # In a bend each round leaves a small share of the error
            mean = mean.copy()
            mean[:2] += place - measured(mean)
        small = 1e-4  # [rad]
        turned = mean.copy()
        turned[2] += small
        root[:2] -= np.outer((measured(turned) - measured(mean)) / small, root[2])
        return mean


def _width(value: StartValue) -> float:
    return math.hypot(value.std, *value.errors.values())


@dataclass(frozen=True)
class ShipFilter:
    """Parts shared by the estimator and the smoother."""

    model: Model  # The ship in its canal
    sensors: Mapping[str, Sensor]  # Sensors by the names of their readings
    indicator: RudderIndicator  # Errors of the rudder's indication
    waterway: "Waterway | None"  # Waterway instead of the model's own canal
    noise: ProcessNoise  # Random walks of the motion about the model
    prior: Prior  # Uncertainty before any reading
    coefficients: Coefficients  # Treatment of their uncertainty: carried, ignored, or corrected by the readings
    refusing: float  # Probability that a gate refuses a valid reading [1]
    step: float  # Longest step of the motion [s]
    memory: float = math.inf  # Time in which corrections of the coefficients fade [s]
    surge: Surge = "held"  # Whether the speed follows the model
    surge_inertia: float | None = None  # Mass in surge with its added mass [kg]
    coriolis: bool = False  # Add the rigid body's Coriolis force
    faults: frozenset[str] = frozenset()  # Sensors, "rudder" or "model" that count as faulty

    def __post_init__(self) -> None:
        if not (math.isfinite(self.step) and self.step > 0.0):
            raise InputError(f"step = {self.step} is no length of a step; give seconds over 0")
        if not self.memory > 0.0:
            raise InputError(f"memory = {self.memory} is no length of time; give seconds over 0, or math.inf")
        if not 0.0 <= self.refusing < 1.0:
            raise InputError(f"refusing = {self.refusing} is no probability; give 0 to 1, and 0 for no gates")

    @cached_property
    def ship(self) -> SimulatedShip:
        open_water = self.waterway is None and not self.model.terms.has_bank
        contact: Contact = "none" if open_water else "corners"
        return SimulatedShip(self.model, self.surge, self.surge_inertia, self.coriolis, contact)

    @cached_property
    def actuators(self) -> tuple[str, ...]:
        return tuple(actuator.name for actuator in self.ship.actuators)

    @cached_property
    def at_rest(self) -> np.ndarray:
        """Positions of the actuators before any reading, (actuators,)."""
        values = self.ship.values()
        return np.array([float(values.get(name) or 0.0) for name in self.actuators])

    @cached_property
    def errors(self) -> dict[str, tuple[int, float, float]]:
        """Errors of the sensors: component, standard deviation, correlation time [s]."""
        known = (error_states(sensor, name in self.faults) for name, sensor in self.sensors.items())
        return {state: error for own in known for state, error in own.items()}

    @cached_property
    def spreads(self) -> dict[str, float]:
        """Standard deviations of the states before any reading."""
        prior, rudder = self.prior, self.indicator.bias if RUDDER in self.actuators else 0.0
        spreads = {"v": prior.sway, "r": prior.yaw_rate, "bank": prior.bank, "current": prior.current}
        spreads |= {"current_across": prior.current_across}
        spreads |= {"rudder_bias": RUDDER_FAULT_STD if RUDDER in self.faults else rudder}
        return spreads | {name: std for name, (_, std, _) in self.errors.items()}

    @cached_property
    def walks(self) -> dict[str, tuple[float, float]]:
        """Random walk of each state per root second, and its correlation time [s]."""
        walks = {name: (walk, math.inf) for name, walk in self.noise.by_state().items()}
        if MODEL in self.faults:
            walks |= {name: (MODEL_FAULT * walks[name][0], math.inf) for name in ("u", "v", "r")}
        slow = {name: (std, time) for name, (_, std, time) in self.errors.items()}
        if RUDDER in self.faults:
            slow["rudder_bias"] = (RUDDER_FAULT_STD, RUDDER_FAULT_TIME * self.time_scale)
        return walks | {name: (std * math.sqrt(2.0 / time), time) for name, (std, time) in slow.items()}

    @property
    def time_scale(self) -> float:
        """Times of this ship over those of the reference ship [1]."""
        return math.sqrt(self.model.configuration.ship.length / REFERENCE_LENGTH)

    @cached_property
    def states(self) -> StateNames:
        """States that can deviate from their defaults."""
        can = {name: self.spreads.get(name, 0.0) > 0.0 for name in STATES}
        can |= {name: can[name] or self.walks[name][0] > 0.0 for name in ("bank", "current", "current_across")}
        can |= dict.fromkeys(MOTION_STATES, True)
        can["bank"] &= self.model.terms.has_bank
        return StateNames((*(name for name in STATES if can[name]), *self.errors))

    @cached_property
    def root(self) -> np.ndarray:
        """A root of the covariance of the coefficients that move the ship, (coefficients, k)."""
        terms, covariance = self.model.terms, self.model.covariance
        if self.coefficients == "certain" or covariance is None:
            return np.zeros((len(terms.names), 0))
        solved = [force for force in terms.forces if force != "X" or self.surge == "free"]
        acting = {term.name for force in solved for term in terms.forces[force]}
        counts = np.array([name in acting for name in terms.names])
        size = np.where(counts & (covariance.diagonal() > 0.0), np.sqrt(covariance.diagonal()), np.inf)
        scale = np.where(np.isfinite(size), size, 1.0)
        share, axes = np.linalg.eigh(covariance / np.outer(size, size))
        certain = share <= 1e-9 * max(float(share.max()), 0.0)
        return np.asarray(scale[:, None] * axes[:, ~certain] * np.sqrt(share[~certain]))

    @property
    def considered(self) -> int:
        """Directions of the coefficients whose uncertainty is carried."""
        return self.root.shape[1] if self.coefficients == "considered" else 0

    @property
    def estimated(self) -> int:
        """Directions of the coefficients that are corrected: states after the others, standard normal a priori."""
        return self.root.shape[1] if self.coefficients == "estimated" else 0

    def process(self, more: Sequence[tuple[float, float]] = ()) -> MarkovProcess:
        """Return the walks of the states, then more by walk and correlation time [s]."""
        walks, times = np.array([*(self.walks[name] for name in self.states.names), *more]).T
        places = self.states.places
        # A ship keeps its way over the ground when the current changes; that through the water takes the change.
        pairs = [(places[one], places[other]) for one, other in WATER_VELOCITIES.items() if one in places]
        return MarkovProcess(walks, times, pairs)

    @cached_property
    def recursion(self) -> Recursion:
        noise = self.indicator.noise if RUDDER in self.actuators else 0.0
        # Corrections of a coefficient fade: its stationary spread is that of the fit.
        fading = [(math.sqrt(2.0 / self.memory), self.memory)] * self.estimated
        process = self.process(fading)
        moving = sigma_point_weights(len(process.walks) + (noise > 0.0), self.considered)
        measuring = sigma_point_weights(len(process.walks), self.considered)
        lanes = self._lanes(moving.distance[: self.considered], len(moving.distance))
        return Recursion(
            lanes, self.states, self.sensors, self.faults, process, moving, measuring, noise,
            self.refusing, self._middle, self.root[:, : self.estimated],
        )  # fmt: skip

    @property
    def _middle(self) -> np.ndarray:
        return np.array([self.model.coefficients[name] for name in self.model.terms.names])

    def _lanes(self, distance: np.ndarray, pairs: int) -> ShipLanes:
        """Lanes of the sigma points; the first pairs have coefficients on either side of the fit's."""
        steps = np.zeros((pairs, len(self._middle)))
        steps[: len(distance)] = self.root[:, : len(distance)].T * distance[:, None]
        coefficients = self._middle + np.concatenate([np.zeros_like(steps[:1]), steps, -steps])
        return ShipLanes(self.ship, self.states.names, len(coefficients), self.waterway, coefficients)

    def adopt(self, now: Gaussian, other: "ShipFilter", size: float = 1.0) -> Gaussian:
        """Return the state of a filter with other faults for this one; new states have a share of their prior."""
        if self.states == other.states and self.faults == other.faults:
            return now
        p, more = self.considered, self.estimated
        known = dict(other.states.places)
        if RUDDER in self.faults ^ other.faults:
            known.pop("rudder_bias", None)
        names = self.states.names
        rows = [known.get(name, -1) for name in names] + [len(other.states) + k for k in range(more)]
        fresh = np.array([row < 0 for row in rows])
        mean = np.where(fresh, np.append(self.states.vector({}), np.zeros(more)), now.mean[rows])
        root = np.where(fresh[:, None], 0.0, now.root[rows])
        prior = np.diag([size * self.spreads.get(name, 0.0) for name in names] + [0.0] * more)[fresh]
        squared = triangular_root(np.concatenate([root[:, p:].T, prior]))
        return Gaussian(mean, np.concatenate([root[:, :p], squared], axis=1))

    def steps(self, now: Gaussian, duration: float, start: np.ndarray, end: np.ndarray) -> list[MotionStep]:
        """Advance a state, and return every step until the last or until it is aground; start and end (actuators,)."""
        count = max(1, math.ceil(duration / self.step - 1e-9))
        taken: list[MotionStep] = []
        for number in range(count):
            here, there = start, end
            if count > 1:
                here, there = (start + share * (end - start) for share in (number / count, (number + 1) / count))
            after, how, met = self.recursion.predict(now, duration / count, here, there)
            aground = met or not math.isfinite(after.mean.sum())
            taken.append(MotionStep(now, after, how, aground))
            if aground:
                break
            now = after
        return taken

    def monitor(self) -> DriftMonitor:
        return DriftMonitor(self.recursion.size, self.considered)


def default_step(model: Model) -> float:
    """Return the longest step that resolves the motion [s]."""
    return math.sqrt(model.configuration.ship.length / GRAVITY) / STEPS_A_PERIOD


def split_sensors(sensors: Sequence[Any]) -> tuple[dict[str, Sensor], RudderIndicator]:
    if isinstance(sensors, str) or not isinstance(sensors, Sequence):
        raise InputError("sensors are a list, as [Gnss(), Gyro(), Log(), RudderIndicator()]; give one")
    indicators = [sensor for sensor in sensors if isinstance(sensor, RudderIndicator)]
    measuring = [sensor for sensor in sensors if not isinstance(sensor, RudderIndicator)]
    if len(indicators) > 1:
        raise InputError("a ship has one rudder here, and these are several RudderIndicators; leave one")
    for sensor in measuring:
        if isinstance(sensor, type) or not isinstance(sensor, Sensor):
            what = sensor.__name__ if isinstance(sensor, type) else type(sensor).__name__
            known = ", ".join(f"{own.__name__}()" for own in SENSORS.values())
            raise InputError(f"{what} is no sensor; give objects such as {known}, or of your own that keep to Sensor")
    names = [sensor.name for sensor in measuring]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two sensors are called {name!r}; give one another name, as Gnss(name='gnss_aft')")
    if not names:
        raise InputError("an estimator needs sensors; give Gnss, Gyro and Log at least")
    return dict(zip(names, measuring, strict=True)), indicators[0] if indicators else RudderIndicator(bias=0.0)
