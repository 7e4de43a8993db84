"""The filter's two steps for a ship: predict by lanes of the kernel, and update by gated sensor readings."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.estimation import square_roots
from narrows.estimation.sensor import MarkovProcess, Sensor, error_states
from narrows.estimation.settings import DRIFT_MEMORIES, DRIFT_MOST_INNOVATION, DRIFT_THRESHOLD, GROSS_ERROR_NIS
from narrows.estimation.states import Columns, StateNames
from narrows.estimation.unscented import (
    Gaussian,
    SigmaPointWeights,
    Transformed,
    predict,
    sigma_points,
    unscented_transform,
    update,
)
from narrows.simulation.ship_lanes import RUDDER, ShipLanes


class UpdateResult(NamedTuple):
    """Result of an update."""

    state: Gaussian  # State after the readings
    nis: dict[str, float]  # Normalised innovation squared, by sensor [1]
    whitened: dict[str, np.ndarray]  # Innovations over their standard deviations [1], 0 for gross errors, by sensor
    refused: tuple[str, ...]  # Sensors with a refused reading
    suspects: tuple[str, ...]  # Sensors with biased innovations
    surprising: tuple[str, ...] = ()  # Sensors of several kinds that contradict the model at once; they are used
    log_likelihood: float = 0.0  # Log-likelihood of the readings, if requested; refused ones count as at the gate
    drift_statistic: float = 0.0  # Largest fading sum of innovations [standard deviations]


class NumberLayout(NamedTuple):
    names: tuple[str, ...]  # Names of the sensors
    parts: tuple[slice, ...]  # Components of each sensor
    places: np.ndarray  # Places of the components among those of all sensors
    gates: tuple[float, ...]  # Largest normalised innovation squared of each sensor [1]
    sigma: np.ndarray  # Standard deviations
    angles: tuple[int, ...]  # Components that are angles
    seen: np.ndarray | None  # (numbers, states) Derivatives, if all are linear in the state
    none: np.ndarray  # (0, numbers) The nonlinear part of a linear measurement
    errors: tuple[tuple[int, int], ...]  # Components, and places of their errors among the states


MEMORIES = np.array(DRIFT_MEMORIES)


@dataclass
class DriftMonitor:
    """Fading sums of innovations: those of a drifting sensor grow, although each passes the gate."""

    size: int  # Number of components of all sensors
    considered: int = 0  # Number of considered coefficient errors
    sums: np.ndarray = field(init=False)  # (2, memories, size) The sums, and their variances
    common: np.ndarray = field(init=False)  # (memories, considered, size) Sums of the errors in common

    def __post_init__(self) -> None:
        self.sums = np.zeros((2, len(DRIFT_MEMORIES), self.size))
        self.common = np.zeros((len(DRIFT_MEMORIES), self.considered, self.size))

    def statistics(self, whitened: np.ndarray, places: np.ndarray, shared: np.ndarray) -> np.ndarray:
        """Add whitened innovations (numbers,); return the distance of the sums from zero [standard deviations]."""
        return np.asarray(
            compiled_loops(square_roots).drift_statistics(
                self.sums, self.common, MEMORIES, places, whitened, shared, DRIFT_MOST_INNOVATION
            )
        )

    def copy(self) -> "DriftMonitor":
        other = DriftMonitor(self.size, self.considered)
        other.sums, other.common = self.sums.copy(), self.common.copy()
        return other


class Recursion:
    def __init__(
        self, lanes: ShipLanes, states: StateNames, sensors: Mapping[str, Sensor], faults: frozenset[str],
        process: MarkovProcess, moving: SigmaPointWeights, measuring: SigmaPointWeights, rudder_noise: float,
        refusing: float, coefficients: np.ndarray, root: np.ndarray,
    ) -> None:  # fmt: skip
        self.lanes, self.states, self.sensors, self.faults, self.refusing = lanes, states, sensors, faults, refusing
        self.moving, self.measuring, self.coefficients, self.root = moving, measuring, coefficients, root
        self.process = process
        self._no_disturbance = np.zeros((len(process.walks), 1))
        self._displaced = rudder_noise * moving.distance[-1]
        ends = np.cumsum([len(sensor.fields) for sensor in sensors.values()])
        self.size = int(ends[-1])
        self._places = dict(zip(sensors, np.split(np.arange(self.size), ends[:-1]), strict=True))
        self._layouts: dict[tuple[str, ...], NumberLayout] = {}

    def predict(
        self, now: Gaussian, duration: float, start: np.ndarray, end: np.ndarray
    ) -> tuple[Gaussian, Transformed, bool]:
        """Return the state a step later, the transformation of its root, and whether the mean met a bank."""
        lanes, pairs = self.lanes, len(self.moving.distance)
        if self._displaced:
            rudder = lanes.actuators.index(RUDDER)
            ends = np.repeat(end[None], lanes.lanes, axis=0)
            ends[pairs, rudder] += self._displaced
            ends[2 * pairs, rudder] -= self._displaced
            now, end = Gaussian(now.mean, np.concatenate([now.root, self._no_disturbance], axis=1)), ends
        left, noise = self.process.over(duration)
        after, how = predict(now, lambda points: self._moved(points, duration, start, end, left), noise, self.moving)
        return after, how, bool(lanes.prepared.codes[0, 0])

    def _moved(
        self, points: np.ndarray, duration: float, start: np.ndarray, end: np.ndarray, left: np.ndarray
    ) -> np.ndarray:
        size, columns = len(self.states), None
        if self.root.shape[1]:
            bank = points[:, self.states.places["bank"]] if "bank" in self.states else np.ones(len(points))
            columns = self.lanes.columns_of(self.coefficients + points[:, size:] @ self.root.T, bank)
        after = self.lanes.advance(points, duration, start, end, columns)
        if len(left):
            after[:, self.process.places] *= left
        return after

    def update(
        self, now: Gaussian, readings: Mapping[str, Sequence[float]], monitor: DriftMonitor, weigh: bool = False
    ) -> UpdateResult:
        """Return the state after the readings of one moment that pass the gates, with their log-likelihood."""
        layout = self._layout(tuple(readings))
        expected, sigma = self._expected(now, layout), layout.sigma
        covariance = compiled_loops(square_roots).innovation_covariance(expected.slopes, expected.bends, sigma)
        innovation = self._innovation(layout, readings, expected.mean)
        spread = np.sqrt(covariance.diagonal())
        whitened = innovation / spread
        # Normalised innovations squared by sensor: those of one component all at once.
        single = (whitened * whitened).tolist()
        named = tuple(zip(layout.names, layout.parts, layout.gates, strict=True))
        nis = {
            name: single[part.start]
            if part.stop - part.start == 1
            else normalised_innovation_squared(innovation[part], covariance[part, part])
            for name, part, _ in named
        }
        odd = tuple(name for name, _, most in named if not nis[name] <= most)
        surprising = odd if self._agree(odd, nis) else ()
        refused = () if surprising else odd
        kept = np.ones(len(sigma), bool)
        for name, part, _ in named if odd else ():
            whitened[part] *= name not in odd  # Gross errors are left to the gate
            kept[part] = name not in refused
        statistics = monitor.statistics(whitened, layout.places, expected.slopes[: self.measuring.considered] / spread)
        drift = float(statistics.max())
        drifting = named if drift > DRIFT_THRESHOLD else ()
        suspects = tuple(name for name, part, _ in drifting if statistics[part].max() > DRIFT_THRESHOLD)
        likelihood = 0.0
        if weigh:
            likelihood -= 0.5 * float(np.linalg.slogdet(covariance)[1])
            likelihood -= 0.5 * sum(most for name, _, most in named if name in refused)
        if refused:
            expected = Transformed(*(np.ascontiguousarray(part[..., kept]) for part in expected))
            innovation, sigma, covariance = innovation[kept], sigma[kept], covariance[np.ix_(kept, kept)]
        if len(innovation):
            likelihood -= 0.5 * normalised_innovation_squared(innovation, covariance) if weigh else 0.0
            now = update(now, expected, innovation, covariance, sigma, self.measuring)
        by_sensor = {name: whitened[part] for name, part, _ in named}
        return UpdateResult(now, nis, by_sensor, refused, suspects, surprising, likelihood, drift)

    def _agree(self, odd: tuple[str, ...], nis: Mapping[str, float]) -> bool:
        """Return whether sensors of several kinds agree against the prediction: then the model is wrong."""
        kinds = {getattr(self.sensors[name], "source", name) for name in odd}
        return len(kinds) > 1 and all(nis[name] <= GROSS_ERROR_NIS for name in odd)

    def _layout(self, names: tuple[str, ...]) -> NumberLayout:
        if names not in self._layouts:
            sensors = [self.sensors[name] for name in names]
            ends = np.cumsum([len(sensor.fields) for sensor in sensors]).tolist()
            parts = tuple(slice(a, b) for a, b in zip([0, *ends], ends, strict=False))
            places = np.concatenate([self._places[name] for name in names])
            gates = tuple(gate(self.refusing, len(sensor.fields)) for sensor in sensors)
            sigma = np.concatenate([np.array(sensor.sigma, float) for sensor in sensors])
            angles = np.concatenate([np.array(sensor.angles, bool) for sensor in sensors])
            known = [error_states(sensor, name in self.faults) for name, sensor in zip(names, sensors, strict=True)]
            errors = tuple(
                (part.start + place, self.states.places[state])
                for part, own in zip(parts, known, strict=True)
                for state, (place, _, _) in own.items()
            )
            turns, none = tuple(np.flatnonzero(angles).tolist()), np.zeros((0, len(sigma)))
            layout = NumberLayout(names, parts, places, gates, sigma, turns, None, none, errors)
            if all(sensor.straight for sensor in sensors):
                unit = np.eye(len(self.process.walks))
                layout = layout._replace(seen=self._measured(unit, layout).T.copy())
            self._layouts[names] = layout
        return self._layouts[names]

    def _expected(self, now: Gaussian, layout: NumberLayout) -> Transformed:
        """Predicted measurement by the sigma points; by the root itself if the measurement is linear."""
        if layout.seen is not None:
            return Transformed(layout.seen @ now.mean, now.root.T @ layout.seen.T, layout.none)
        points = sigma_points(now.mean, now.root, self.measuring)
        return unscented_transform(self._measured(points, layout), self.measuring)

    def _measured(self, points: np.ndarray, layout: NumberLayout) -> np.ndarray:
        """Components of the sensors with their errors, (points, numbers)."""
        at = Columns(points, self.states, self.lanes.bend(float(points[0, 0])))
        values = np.empty((len(points), len(layout.sigma)))
        columns = (column for name in layout.names for column in self.sensors[name].measured(at))
        for number, column in enumerate(columns):
            values[:, number] = column
        for number, place in layout.errors:
            values[:, number] += points[:, place]
        return values

    def _innovation(
        self, layout: NumberLayout, readings: Mapping[str, Sequence[float]], expected: np.ndarray
    ) -> np.ndarray:
        numbers = [number for name in layout.names for number in self.sensors[name].numbers(readings[name])]
        off = [number - mean for number, mean in zip(numbers, expected.tolist(), strict=True)]
        for angle in layout.angles:
            off[angle] = math.remainder(off[angle], 2.0 * math.pi)
        return np.array(off, float)


@lru_cache(maxsize=64)
def gate(probability: float, size: int) -> float:
    """Return the normalised innovation squared that a valid measurement exceeds with a probability [1]."""
    from scipy.stats import chi2

    return float(chi2.isf(probability, size)) if probability > 0.0 else float("inf")


def normalised_innovation_squared(innovation: np.ndarray, covariance: np.ndarray) -> float:
    """Return the innovation squared over its covariance [1]: chi-squared for a consistent filter."""
    if len(innovation) == 1:
        return float(innovation[0] * innovation[0] / covariance[0, 0])
    if len(innovation) == 2:
        ((a, b), (_, d)), (e, f) = covariance.tolist(), innovation.tolist()
        return float((d * e * e - 2.0 * b * e * f + a * f * f) / (a * d - b * b))
    return float(innovation @ np.linalg.solve(covariance, innovation))
