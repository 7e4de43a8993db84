"""The filter of a ship with its sensors: states, motion by lanes of the kernel, update by gated readings.

Source: van der Merwe and Wan (2001), The square-root unscented Kalman filter for state and parameter estimation.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from scipy.special import chdtri

from narrows.base.errors import InputError
from narrows.codegen.cache import compiled_loops
from narrows.estimation import settings, square_roots
from narrows.estimation.sensors import RudderIndicator, Sensor, error_states
from narrows.estimation.states import (
    MOTION_STATES,
    STATES,
    Columns,
    Gaussian,
    MarkovProcess,
    Prior,
    ProcessNoise,
    StateNames,
)
from narrows.model.model import Model
from narrows.ship.checks import check_sizes
from narrows.simulation.kernel_run import RUDDER, ShipLanes
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

MODEL = "model"
Coefficients = Literal["certain", "estimated"]
Readings = Mapping[str, Sequence[float]]
MEMORIES = np.array(settings.DRIFT_MEMORIES)


class SigmaPointWeights(NamedTuple):
    distance: float  # Distance of each pair, in standard deviations
    mean: float  # Weight of each pair in the mean
    bend: float  # Share of the sum of all second differences in the nonlinear part of each pair
    pairs: int

    def transform(
        self, now: Gaussian, function: Callable[[np.ndarray], np.ndarray], noise: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and rows of a function's values: changes along the root's columns, nonlinear parts, noise."""
        loops = compiled_loops(square_roots)
        points = loops.sigma_points(*now, self.distance, self.pairs)
        mean, rows = loops.transform(function(points), noise, self.distance, self.mean, self.bend)
        return mean, rows


# Julier and Uhlmann (1997), A new extension of the Kalman filter to nonlinear systems. van der Merwe (2004),
# Sigma-point Kalman filters for probabilistic inference in dynamic state-space models, chapter 3.
@lru_cache(maxsize=64)
def sigma_point_weights(
    size: int, alpha: float = 0.5, beta: float = 2.0, kappa: float | None = None
) -> SigmaPointWeights:
    """Return the weights of van der Merwe's scaled points."""
    squared = settings.SQUARED_DISTANCE if kappa is None else alpha * alpha * (size + kappa)
    # The covariance has the pairs' second differences d about the mean, and the central point by the weight 1 - n/h^2 +
    # 1 - alpha^2 + beta, which may be negative. Both together are sums of squares of (d_i + bend sum d) / 2 h.
    bend = (math.sqrt(max(1.0 + (beta - alpha * alpha) * size / squared, 0.0)) - 1.0) / size
    return SigmaPointWeights(math.sqrt(squared), 0.5 / squared, bend, size)


def predict(
    now: Gaussian, move: Callable[[np.ndarray], np.ndarray], noise: np.ndarray, weights: SigmaPointWeights
) -> tuple[Gaussian, np.ndarray]:
    """Return the distribution after a motion with noise (j, n), and its slopes along the root's columns, (k, n)."""
    mean, rows = weights.transform(now, move, noise)
    return Gaussian(mean, compiled_loops(square_roots).triangular_root(rows)), rows[: weights.pairs]


class MotionStep(NamedTuple):
    before: Gaussian  # State before the step
    state: Gaussian  # State after the step
    slopes: np.ndarray  # (k, n) Change of the state along each column of the root
    aground: bool  # True if the mean met a bank, or is NaN


class UpdateResult(NamedTuple):
    t: float  # Time of the readings [s]
    nis: dict[str, float]  # Normalised innovation squared, by sensor [1]
    refused: tuple[str, ...]  # Sensors with a refused reading
    suspects: tuple[str, ...]  # Sensors with biased innovations
    surprising: tuple[str, ...]  # Sensors of several kinds that contradict the model at once; they are used
    log_likelihood: float  # Log-likelihood of the readings; refused ones count as at the gate
    drift_statistic: float  # Largest fading sum of innovations [standard deviations]


class NumberLayout(NamedTuple):
    parts: dict[str, slice]  # Components of each sensor
    # End of the components, largest NIS and source of each sensor; places of the components among those of all sensors.
    tests: tuple[np.ndarray, ...]
    noise: np.ndarray  # (numbers, numbers) Root of the covariance of the white errors
    angles: tuple[int, ...]  # Components that are angles
    errors: tuple[tuple[int, int], ...]  # Components, and places of their errors among the states
    seen: np.ndarray | None  # (numbers, states) Derivatives, if all are linear in the state


@dataclass(frozen=True)
class ShipFilter:
    """A filter of one hypothesis on faults; the estimator and the smoother run it."""

    model: Model  # The ship in its canal
    sensors: Mapping[str, Sensor]  # Sensors by the names of their readings
    indicator: RudderIndicator  # Errors of the rudder's indication
    waterway: "Waterway | None"  # Waterway instead of the model's own canal
    noise: ProcessNoise  # Random walks of the motion about the model
    prior: Prior  # Uncertainty before any reading
    coefficients: Coefficients  # Whether the readings correct them, or their uncertainty is ignored
    refusing: float  # Probability that a gate refuses a valid reading [1]
    step: float  # Longest step of the motion [s]
    memory: float = math.inf  # Time in which corrections of the coefficients fade [s]
    faults: frozenset[str] = frozenset()  # Sensors, "rudder" or "model" that count as faulty
    _others: dict[frozenset[str], "ShipFilter"] = field(default_factory=dict, init=False)
    _layouts: dict[tuple[str, ...], NumberLayout] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        check_sizes(self, ("step",), ("step",))
        if not self.memory > 0.0:
            raise InputError(f"memory = {self.memory} is no length of time; give seconds over 0, or math.inf")
        if not 0.0 <= self.refusing < 1.0:
            raise InputError(f"refusing = {self.refusing} is no probability; give 0 to 1, and 0 for no gates")

    @cached_property
    def ship(self) -> SimulatedShip:
        banks = self.waterway or self.model.terms.has_bank
        return SimulatedShip(self.model, contact="corners" if banks else "none")

    @cached_property
    def actuators(self) -> tuple[str, ...]:
        return tuple(actuator.name for actuator in self.ship.actuators)

    @cached_property
    def at_rest(self) -> np.ndarray:  # (actuators,)
        values = self.ship.values()
        return np.array([float(values.get(name) or 0.0) for name in self.actuators])

    @cached_property
    def errors(self) -> dict[str, tuple[int, float, float]]:
        """Errors of the sensors: component, standard deviation, correlation time [s]."""
        known = (error_states(sensor, name in self.faults) for name, sensor in self.sensors.items())
        return {state: error for own in known for state, error in own.items()}

    @cached_property
    def spreads(self) -> dict[str, float]:
        prior, rudder = self.prior, self.indicator.bias if RUDDER in self.actuators else 0.0
        return {
            "v": prior.sway, "r": prior.yaw_rate, "bank": prior.bank, "current": prior.current,
            "current_across": prior.current_across,
            "rudder_bias": settings.RUDDER_FAULT_STD if RUDDER in self.faults else rudder,
            **{name: std for name, (_, std, _) in self.errors.items()},
        }  # fmt: skip

    @cached_property
    def walks(self) -> dict[str, tuple[float, float]]:
        """Random walk of each state per root second, and its correlation time [s]."""
        walks = {name: (walk, math.inf) for name, walk in self.noise.by_state().items()}
        if MODEL in self.faults:
            walks |= {name: (settings.MODEL_FAULT * walks[name][0], math.inf) for name in ("u", "v", "r")}
        slow = {name: (std, time) for name, (_, std, time) in self.errors.items()}
        if RUDDER in self.faults:
            slow["rudder_bias"] = (settings.RUDDER_FAULT_STD, settings.RUDDER_FAULT_TIME * self.time_scale)
        return walks | {name: (std * math.sqrt(2.0 / time), time) for name, (std, time) in slow.items()}

    @property
    def time_scale(self) -> float:
        """Times of this ship over those of the reference ship [1]."""
        return math.sqrt(self.model.configuration.ship.length / settings.REFERENCE_LENGTH)

    @cached_property
    def states(self) -> StateNames:
        """States that can deviate from their defaults."""
        can = {name: self.spreads.get(name, 0.0) > 0.0 for name in STATES}
        can |= {name: can[name] or self.walks[name][0] > 0.0 for name in ("bank", "current", "current_across")}
        can |= dict.fromkeys(MOTION_STATES, True)
        can["bank"] &= self.model.terms.has_bank
        return StateNames((*(name for name in STATES if can[name]), *self.errors))

    @cached_property
    def middle(self) -> np.ndarray:  # (coefficients,)
        return np.array([self.model.coefficients[name] for name in self.model.terms.names])

    @cached_property
    def root(self) -> np.ndarray:
        """A root of the covariance of the coefficients that move the ship, (coefficients, k)."""
        terms, covariance = self.model.terms, self.model.covariance
        if self.coefficients == "certain" or covariance is None:
            return np.zeros((len(terms.names), 0))
        acting = {term.name for force in terms.forces if force != "X" for term in terms.forces[force]}
        counts = np.array([name in acting for name in terms.names])
        size = np.where(counts & (covariance.diagonal() > 0.0), np.sqrt(covariance.diagonal()), np.inf)
        scale = np.where(np.isfinite(size), size, 1.0)
        share, axes = np.linalg.eigh(covariance / np.outer(size, size))
        certain = share <= 1e-9 * share.max()
        return np.asarray(scale[:, None] * axes[:, ~certain] * np.sqrt(share[~certain]))

    @cached_property
    def estimated(self) -> int:
        """Directions of the coefficients that are corrected: states after the others, standard normal a priori."""
        return int(self.root.shape[1])

    @cached_property
    def disturbances(self) -> MarkovProcess:
        """Walks of the states and of the coefficients: corrections fade, and the stationary spread is the fit's."""
        fading = [(math.sqrt(2.0 / self.memory), self.memory)] * self.estimated
        walks, times = np.array([*(self.walks[name] for name in self.states.names), *fading]).T
        places, water = self.states.places, {"current": "u", "current_across": "v"}
        # A ship keeps its way over the ground when the current changes; that through the water takes the change.
        pairs = [(places[one], places[other]) for one, other in water.items() if one in places]
        return MarkovProcess(walks, times, pairs)

    @cached_property
    def pairs(self) -> int:
        """Pairs of sigma points of the motion: of the states, and of the noise of the rudder's indication if any."""
        return len(self.disturbances.walks) + (RUDDER in self.actuators and self.indicator.noise > 0.0)

    @cached_property
    def lanes(self) -> ShipLanes:
        return ShipLanes(self.ship, self.states.names, 1 + 2 * self.pairs, self.waterway)

    @cached_property
    def rudder_noise(self) -> np.ndarray:
        """Additions to the positions of the actuators at the sigma points, (1 or points, actuators)."""
        # The last pair has the noise of the rudder's indication.
        added = np.zeros((self.lanes.lanes, len(self.actuators)))
        if self.pairs == len(self.disturbances.walks):
            return added[:1]
        size = self.indicator.noise * sigma_point_weights(self.pairs).distance
        added[[self.pairs, 2 * self.pairs], self.actuators.index(RUDDER)] = size, -size
        return added

    def with_faults(self, faults: frozenset[str]) -> "ShipFilter":
        if faults and faults not in self._others:
            self._others[faults] = replace(self, faults=faults)
        return self._others.get(faults, self)

    def monitor(self) -> np.ndarray:
        """Return empty sums of innovations: they grow for a drifting sensor, although each one passes its gate."""
        return np.zeros((2, len(MEMORIES), sum(len(one.fields) for one in self.sensors.values())))

    def adopt(self, now: Gaussian, other: "ShipFilter", size: float = 1.0) -> Gaussian:
        """Return the state of a filter with other faults for this one; new states have a share of their prior."""
        if self.states == other.states and self.faults == other.faults:
            return now
        more, known = self.estimated, dict(other.states.places)
        if RUDDER in self.faults ^ other.faults:
            known.pop("rudder_bias", None)
        names = self.states.names
        places = [known.get(name, -1) for name in names] + [len(other.states) + k for k in range(more)]
        fresh = np.array([place < 0 for place in places])
        mean = np.where(fresh, np.append(self.states.vector({}), np.zeros(more)), now.mean[places])
        root = np.where(fresh[:, None], 0.0, now.root[places])
        prior = np.diag([size * self.spreads.get(name, 0.0) for name in names] + [0.0] * more)[fresh]
        rows = np.concatenate([root.T, prior]).copy()  # By rows like all others: each layout is compiled anew
        return Gaussian(mean, compiled_loops(square_roots).triangular_root(rows))

    def advance(self, now: Gaussian, duration: float, start: np.ndarray, end: np.ndarray) -> list[MotionStep]:
        """Advance a state, and return every step until the last or until it is aground; start and end (actuators,)."""
        count = max(1, math.ceil(duration / self.step - 1e-9))
        taken: list[MotionStep] = []
        for here, there in pairwise(np.linspace(start, end, count + 1)):
            taken.append(self.predict(now, duration / count, here, there))
            now = taken[-1].state
            if taken[-1].aground:
                break
        return taken

    def predict(self, now: Gaussian, duration: float, start: np.ndarray, end: np.ndarray) -> MotionStep:
        """Return one step of the motion; actuators move from start to end (actuators,)."""
        lanes, size, weights = self.lanes, len(self.states), sigma_point_weights(self.pairs)
        left, noise = self.disturbances.over(duration)

        def move(points: np.ndarray) -> np.ndarray:
            columns = None
            if self.estimated:
                bank = points[:, self.states.places["bank"]] if "bank" in self.states.places else np.ones(len(points))
                columns = lanes.columns_of(self.middle + points[:, size:] @ self.root.T, bank)
            after: np.ndarray = left * lanes.advance(points, duration, start, end + self.rudder_noise, columns)
            return after

        after, slopes = predict(now, move, noise, weights)
        aground = bool(lanes.prepared.codes[0, 0]) or not math.isfinite(sum(after.mean.tolist()))
        return MotionStep(now, after, slopes, aground)

    def update(self, t: float, now: Gaussian, readings: Readings, monitor: np.ndarray) -> tuple[Gaussian, UpdateResult]:
        """Return the state after the readings of one time that pass the gates; the monitor's sums change."""
        layout = self.layout(tuple(readings))
        if layout.seen is not None:
            expected, rows = layout.seen @ now.mean, np.concatenate((now.root.T @ layout.seen.T, layout.noise))
        else:
            expected, rows = sigma_point_weights(len(now.mean)).transform(
                now, lambda points: self.measured(points, layout), layout.noise
            )
        numbers = [number for name in readings for number in self.sensors[name].numbers(readings[name])]
        innovation = np.array(numbers) - expected
        for angle in layout.angles:
            innovation[angle] = math.remainder(innovation[angle], 2.0 * math.pi)
        mean, root, tests, agree, likelihood = compiled_loops(square_roots).update(
            *now, rows, innovation, *layout.tests, monitor, MEMORIES,
            settings.DRIFT_MOST_INNOVATION, settings.GROSS_ERROR_NIS,
        )  # fmt: skip
        nis, odd, drift = tests.tolist()
        wrong = tuple(name for name, exceeds in zip(readings, odd, strict=True) if exceeds)
        suspects = tuple(name for name, one in zip(readings, drift, strict=True) if one > settings.DRIFT_THRESHOLD)
        squared = dict(zip(readings, nis, strict=True))
        refused, surprising = ((), wrong) if agree else (wrong, ())
        return Gaussian(mean, root), UpdateResult(t, squared, refused, suspects, surprising, likelihood, max(drift))

    def layout(self, names: tuple[str, ...]) -> NumberLayout:
        if names not in self._layouts:
            sensors = [self.sensors[name] for name in names]
            every = np.cumsum([0, *(len(sensor.fields) for sensor in self.sensors.values())])
            places = [np.arange(*every[k : k + 2]) for k in map(list(self.sensors).index, names)]
            ends = np.cumsum([len(own) for own in places])
            parts = {name: slice(end - len(own), end) for name, own, end in zip(names, places, ends, strict=True)}
            sources = [getattr(sensor, "source", name) for name, sensor in zip(names, sensors, strict=True)]
            gates = [gate(self.refusing, len(own)) for own in places]
            tests = ends, np.array(gates), np.array([sources.index(one) for one in sources]), np.concatenate(places)
            noise = np.diag(np.concatenate([np.array(sensor.sigma, float) for sensor in sensors]))
            angles = tuple(np.flatnonzero(np.concatenate([sensor.angles for sensor in sensors])).tolist())
            errors = tuple(
                (parts[name].start + place, self.states.places[state])
                for name in names
                for state, (place, _, _) in error_states(self.sensors[name], name in self.faults).items()
            )
            layout = NumberLayout(parts, tests, noise, angles, errors, None)
            if all(sensor.is_linear for sensor in sensors):
                layout = layout._replace(seen=self.measured(np.eye(len(self.disturbances.walks)), layout).T.copy())
            self._layouts[names] = layout
        return self._layouts[names]

    def measured(self, points: np.ndarray, layout: NumberLayout) -> np.ndarray:  # (points, numbers)
        at = Columns(points, self.states, self.lanes.bend(float(points[0, 0])))
        values = np.empty((len(points), len(layout.noise)))
        columns = (column for name in layout.parts for column in self.sensors[name].measured(at))
        for number, column in enumerate(columns):
            values[:, number] = column
        for number, place in layout.errors:
            values[:, number] += points[:, place]
        return values


def gate(probability: float, size: int) -> float:
    """Return the normalised innovation squared that a valid measurement exceeds with a probability [1]."""
    return float(chdtri(size, probability))
