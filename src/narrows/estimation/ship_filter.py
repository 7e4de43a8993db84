"""A ship with its sensors as a filter asks for them: which states there are, how they move, what corrects them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from narrows.codegen.free_motion import Surge
from narrows.errors import InputError
from narrows.estimation.recursion import DriftMonitor, Recursion
from narrows.estimation.sensor import Sensor
from narrows.estimation.sensors import SENSORS, Gyro, RudderIndicator
from narrows.estimation.settings import STEPS_A_PERIOD
from narrows.estimation.ship_lanes import RUDDER, ShipLanes, directions, lanes_of_directions
from narrows.estimation.states import MOTION_STATES, STATES, Columns, Prior, ProcessNoise, StateNames
from narrows.estimation.unscented import Gaussian, Transformed, sigma_point_weights
from narrows.model.model import Model
from narrows.quantities.names import GRAVITY
from narrows.simulation.inputs import Contact
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

Coefficients = Literal["considered", "certain", "estimated"]


class MotionStep(NamedTuple):
    normal: Gaussian  # After it
    how: Transformed  # How the root was moved
    aground: bool  # Whether the mean met a bank, or is no number


# What there must be to start from, and what it is called; the other states begin at their priors.
NEEDED = {"x": "a place", "y": "a place", "psi": "a heading", "u": "a speed through the water"}


@dataclass
class Start:
    """Readings as they come, until there are enough to start from."""

    states: StateNames  # What is estimated
    sensors: Mapping[str, Sensor]  # By the names of their readings
    prior: Prior  # What is believed without readings
    biases: Mapping[str, float]  # Standard deviations of the biases, by the names of states
    current: float = 0.0  # Along the waterway, as it is known [m/s]
    readings: dict[str, Sequence[float]] = field(default_factory=dict)  # What came in so far

    def told(self) -> dict[str, tuple[float, float]]:
        """Return what the readings tell, with standard deviations: of two that tell the same, the better."""
        told: dict[str, tuple[float, float]] = {}
        for name, reading in self.readings.items():
            for state, (value, size) in self.sensors[name].start(reading).items():
                if state not in told or size < told[state][1]:
                    told[state] = (float(value), size)
        return told

    @property
    def lacking(self) -> str:
        """What is not known yet, in words; empty where there is enough."""
        told = self.told()
        return " and ".join(dict.fromkeys(what for state, what in NEEDED.items() if state not in told))

    def normal(self, considered: int, bend: float) -> Gaussian:
        """Return the state by the readings and the priors; bend is the curvature of the line [1/m]."""
        told, prior = self.told(), self.prior
        believed = {
            "v": (0.0, prior.sway), "r": (0.0, prior.yaw_rate), "bank": (1.0, prior.bank),
            "current": (self.current, prior.current), "current_across": (0.0, prior.current_across),
            **{name: (0.0, size) for name, size in self.biases.items()}, **told,
        }  # fmt: skip
        mean = self.states.vector({name: value for name, (value, _) in believed.items()})
        root = np.diag([believed[name][1] for name in self.states.names])
        places = self.states.places
        if "heading_bias" in places:  # What the compass indicates is the heading and its bias together.
            root[places["psi"], places["heading_bias"]] = -root[places["heading_bias"], places["heading_bias"]]
        return Gaussian(self._at_midship(mean, root, bend), np.hstack([np.zeros((len(mean), considered)), root]))

    def _at_midship(self, mean: np.ndarray, root: np.ndarray, bend: float) -> np.ndarray:
        """Bring the place of an antenna to midship, in the mean and, as far as the heading is unsure, in the root."""
        name = next(name for name, reading in self.readings.items() if "x" in self.sensors[name].start(reading))
        sensor, told = self.sensors[name], np.array(self.readings[name], float)

        def measured(state: np.ndarray) -> np.ndarray:
            found = sensor.measured(Columns(state[None], self.states, bend))
            return np.array([float(np.ravel(number)[0]) for number in found])

        for _ in range(6):  # Along a bend each round leaves a small share of the error.
            mean = mean.copy()
            mean[:2] += told - measured(mean)
        small = 1e-4  # [rad]
        turned = mean.copy()
        turned[2] += small
        root[:2] -= np.outer((measured(turned) - measured(mean)) / small, root[2])
        return mean


@dataclass(frozen=True)
class ShipFilter:
    """What an estimator and a smoother share."""

    model: Model  # The ship in its canal
    sensors: Mapping[str, Sensor]  # By the names of their readings
    indicator: RudderIndicator  # What is known of the rudder
    waterway: "Waterway | None"  # Where it sails instead of the model's own canal
    noise: ProcessNoise  # How fast the motion wanders from the model
    prior: Prior  # What is believed before any reading
    coefficients: Coefficients  # Whether their uncertainty is carried, left out, or corrected by the readings
    refusing: float  # Probability with which a gate refuses a sound reading [1]
    step: float  # Longest step of the motion [s]
    memory: float = math.inf  # Time in which what readings tell of the coefficients fades [s]
    surge: Surge = "held"  # Whether the model moves the speed
    surge_inertia: float | None = None  # Mass in surge with its added mass [kg]
    coriolis: bool = False  # Add the rigid body's Coriolis force

    def __post_init__(self) -> None:
        if not (math.isfinite(self.step) and self.step > 0.0):
            raise InputError(f"step = {self.step} is no length of a step; give seconds over 0")
        if not self.memory > 0.0:
            raise InputError(f"memory = {self.memory} is no length of time; give seconds over 0, or math.inf")
        if not 0.0 <= self.refusing < 1.0:
            raise InputError(f"refusing = {self.refusing} is no probability; give 0 to 1, and 0 for no gates")

    @cached_property
    def ship(self) -> SimulatedShip:
        open_water = self.waterway is None and not self.model.terms.feels_bank
        contact: Contact = "none" if open_water else "corners"
        return SimulatedShip(self.model, self.surge, self.surge_inertia, self.coriolis, contact)

    @cached_property
    def actuators(self) -> tuple[str, ...]:
        return tuple(actuator.name for actuator in self.ship.actuators)

    @cached_property
    def biases(self) -> dict[str, float]:
        compasses = [sensor.bias for sensor in self.sensors.values() if isinstance(sensor, Gyro)]
        rudder = self.indicator.bias if RUDDER in self.actuators else 0.0
        return {"rudder_bias": rudder, "heading_bias": max(compasses, default=0.0)}

    @cached_property
    def states(self) -> StateNames:
        """What is estimated: what can be other than it is at rest."""
        can = dict.fromkeys(MOTION_STATES, True) | {name: size > 0.0 for name, size in self.biases.items()}
        for name in ("bank", "current", "current_across"):
            can[name] = getattr(self.prior, name) > 0.0 or getattr(self.noise, name) > 0.0
        can["bank"] &= self.model.terms.feels_bank
        return StateNames(tuple(name for name in STATES if can[name]))

    @cached_property
    def root(self) -> np.ndarray:
        """A root of the covariance of the coefficients that move the ship, (coefficients, k)."""
        terms, covariance = self.model.terms, self.model.covariance
        if self.coefficients == "certain" or covariance is None:
            return np.zeros((len(terms.names), 0))
        solved = [force for force in terms.forces if force != "X" or self.surge == "free"]
        felt = {term.name for force in solved for term in terms.forces[force]}
        counts = np.array([name in felt for name in terms.names])
        return directions(np.where(np.outer(counts, counts), covariance, 0.0))

    @property
    def considered(self) -> int:
        """Directions of the coefficients that are carried."""
        return self.root.shape[1] if self.coefficients == "considered" else 0

    @property
    def estimated(self) -> int:
        """Directions of the coefficients that are corrected: states after the others, standard normal before."""
        return self.root.shape[1] if self.coefficients == "estimated" else 0

    @cached_property
    def recursion(self) -> Recursion:
        noise = self.indicator.noise if RUDDER in self.actuators else 0.0
        fresh = math.sqrt(2.0 / self.memory)  # as much as fades: the fit's spread is where a coefficient comes to rest
        walks = [*(self.noise.by_state()[name] for name in self.states.names), *(fresh,) * self.estimated]
        size = len(self.states) + self.estimated
        moving = sigma_point_weights(size + (noise > 0.0), self.considered)
        measuring = sigma_point_weights(size, self.considered)
        return Recursion(
            self._lanes(moving.distance), self.states, self.sensors, np.array(walks), moving, measuring, noise,
            self.refusing, self._middle, self.root[:, : self.estimated], self.memory,
        )  # fmt: skip

    @property
    def _middle(self) -> np.ndarray:
        return np.array([self.model.coefficients[name] for name in self.model.terms.names])

    def _lanes(self, distance: np.ndarray) -> ShipLanes:
        p = self.considered
        coefficients = lanes_of_directions(self._middle, self.root[:, :p], distance[:p], len(distance) - p)
        return ShipLanes(self.ship, self.states, len(coefficients), self.waterway, coefficients)

    def start(self) -> Start:
        current = self.waterway.current if self.waterway else 0.0
        return Start(self.states, self.sensors, self.prior, self.biases, current)

    def begin(self, start: Start) -> Gaussian:
        bend = self.recursion.lanes.bend(start.told()["x"][0])
        first = start.normal(self.considered, bend)
        if not self.estimated:
            return first
        size, more = len(self.states), self.estimated
        root = np.zeros((size + more, size + more))
        root[:size, :size], root[size:, size:] = first.root, np.eye(more)
        return Gaussian(np.concatenate([first.mean, np.zeros(more)]), root)

    def steps(self, now: Gaussian, duration: float, start: np.ndarray, end: np.ndarray) -> list[MotionStep]:
        """Move a state on, and return every step until the last or until it is aground; start and end (actuators,)."""
        count = max(1, math.ceil(duration / self.step - 1e-9))
        taken: list[MotionStep] = []
        for number in range(count):
            here, there = start, end
            if count > 1:
                here, there = (start + share * (end - start) for share in (number / count, (number + 1) / count))
            after, how, met = self.recursion.predict(now, duration / count, here, there)
            aground = met or not math.isfinite(after.mean.sum())
            taken.append(MotionStep(after, how, aground))
            if aground:
                break
            now = after
        return taken

    def monitor(self) -> DriftMonitor:
        return DriftMonitor(self.recursion.size, self.considered)


def default_step(model: Model) -> float:
    """Return the longest step of a motion that is followed [s]."""
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
        raise InputError("an estimator without a sensor knows nothing; give Gnss, Gyro and Log at least")
    return dict(zip(names, measuring, strict=True)), indicators[0] if indicators else RudderIndicator(bias=0.0)
