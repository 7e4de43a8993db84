"""The filter's two steps for a ship: its motion by lanes of the kernel, and readings of its sensors behind gates."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from narrows.estimation.sensor import Sensor
from narrows.estimation.settings import DRIFT_MEMORIES, DRIFT_MOST_INNOVATION, DRIFT_THRESHOLD, GROSS_ERROR_NIS
from narrows.estimation.ship_lanes import ShipLanes
from narrows.estimation.states import Columns, StateNames
from narrows.estimation.unscented import (
    Gaussian,
    SigmaPointWeights,
    Transformed,
    innovation_covariance,
    linear_transform,
    predict,
    sigma_points,
    unscented_transform,
    update,
)

RUDDER = "rudder"


class UpdateResult(NamedTuple):
    """What became of readings."""

    normal: Gaussian  # The state after them
    nis: dict[str, float]  # Normalised innovation squared, by sensor [1]
    refused: tuple[str, ...]  # Sensors whose reading the gate refused
    suspects: tuple[str, ...]  # Sensors whose innovations lean to one side
    surprising: tuple[str, ...] = ()  # Sensors of several kinds that all told what was not expected, and were believed


class NumberLayout(NamedTuple):
    names: tuple[str, ...]  # Of the sensors
    parts: tuple[slice, ...]  # Of the numbers, those of each sensor
    places: np.ndarray | slice  # Of the numbers among those of all sensors
    gates: tuple[float, ...]  # Largest normalised innovation squared of each sensor [1]
    sigma: np.ndarray  # Standard deviations
    angles: np.ndarray  # Which are angles
    straight: bool  # Whether all are linear in the state


# Share of a sum that is left after each reading, (memories, 1).
FADING = 1.0 - 1.0 / np.array(DRIFT_MEMORIES)[:, None]
SQUARED = FADING * FADING


@dataclass
class DriftMonitor:
    """Fading sums of innovations: those of a drifting sensor lean to one side, each too small for the gate."""

    size: int  # Numbers that the sensors measure, all together
    considered: int = 0  # Errors of coefficients that the filter carries
    sums: np.ndarray = field(init=False)
    variances: np.ndarray = field(init=False)
    common: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.sums, self.variances = np.zeros((2, len(DRIFT_MEMORIES), self.size))
        self.common = np.zeros((len(DRIFT_MEMORIES), self.considered, self.size))

    def lean(self, whitened: np.ndarray, places: np.ndarray | slice, shared: np.ndarray) -> np.ndarray:
        """Take whitened innovations (numbers,); return the distance of the sums from zero [standard deviations]."""
        # Errors of considered coefficients, (considered, numbers), are common to all readings: they add up as a bias
        # does and are no sign of a drift.
        sums = FADING * self.sums[:, places]
        sums += np.minimum(np.maximum(whitened, -DRIFT_MOST_INNOVATION), DRIFT_MOST_INNOVATION)
        variances = SQUARED * self.variances[:, places] + 1.0
        if self.considered:
            variances -= np.minimum((shared * shared).sum(axis=0), 1.0)
        self.sums[:, places], self.variances[:, places] = sums, variances
        if self.considered:
            common = FADING[:, :, None] * self.common[..., places] + shared
            self.common[..., places] = common
            variances = variances + (common * common).sum(axis=1)
        return np.asarray((np.abs(sums) / np.sqrt(variances)).max(axis=0))

    def copy(self) -> "DriftMonitor":
        other = DriftMonitor(self.size, self.considered)
        other.sums, other.variances, other.common = self.sums.copy(), self.variances.copy(), self.common.copy()
        return other


class Recursion:
    def __init__(
        self, lanes: ShipLanes, states: StateNames, sensors: Mapping[str, Sensor], walks: np.ndarray,
        moving: SigmaPointWeights, measuring: SigmaPointWeights, rudder_noise: float, refusing: float,
        coefficients: np.ndarray, root: np.ndarray, memory: float = math.inf,
    ) -> None:  # fmt: skip
        self.lanes, self.states, self.sensors, self.refusing = lanes, states, sensors, refusing
        self.moving, self.measuring, self.coefficients, self.root = moving, measuring, coefficients, root
        self.memory = memory
        self._walk = np.diag(walks)[walks > 0.0]
        self._no_disturbance = np.zeros((len(walks), 1))
        self._displaced = rudder_noise * moving.distance[-1]
        ends = np.cumsum([len(sensor.fields) for sensor in sensors.values()])
        self.size = int(ends[-1])
        self._places = dict(zip(sensors, np.split(np.arange(self.size), ends[:-1]), strict=True))
        self._layouts: dict[tuple[str, ...], NumberLayout] = {}

    def predict(
        self, now: Gaussian, duration: float, start: np.ndarray, end: np.ndarray
    ) -> tuple[Gaussian, Transformed, bool]:
        """Return the state a step later, how its root was moved, and whether the mean met a bank."""
        lanes, pairs = self.lanes, len(self.moving.distance)
        if self._displaced:
            rudder = lanes.actuators.index(RUDDER)
            ends = np.repeat(end[None], lanes.lanes, axis=0)
            ends[pairs, rudder] += self._displaced
            ends[2 * pairs, rudder] -= self._displaced
            now, end = Gaussian(now.mean, np.concatenate([now.root, self._no_disturbance], axis=1)), ends
        after, how = predict(
            now, lambda points: self._advance_lanes(points, duration, start, end), math.sqrt(duration) * self._walk,
            self.moving,
        )  # fmt: skip
        return after, how, bool(lanes.prepared.codes[0, 0])

    def _advance_lanes(self, points: np.ndarray, duration: float, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        size = len(self.states)
        if not self.root.shape[1]:
            return self.lanes.advance(points, duration, start, end)
        bank = points[:, self.states.places["bank"]] if "bank" in self.states else np.ones(len(points))
        columns = self.lanes.columns_of(self.coefficients + points[:, size:] @ self.root.T, bank)
        states = self.lanes.advance(points[:, :size], duration, start, end, columns)
        return np.concatenate([states, math.exp(-duration / self.memory) * points[:, size:]], axis=1)

    def update(self, now: Gaussian, readings: Mapping[str, Sequence[float]], monitor: DriftMonitor) -> UpdateResult:
        """Return the state by readings of one moment, those that no gate refuses."""
        layout = self._layout(tuple(readings))
        expected = self._expected(now, layout)
        covariance = innovation_covariance(expected, layout.sigma, self.measuring)
        innovation = self._innovation(layout, readings, expected.mean)
        # Normalised innovations squared by sensor: those of one number all at once.
        single = (innovation * innovation / covariance.diagonal()).tolist()
        nis = {
            name: single[part.start]
            if part.stop - part.start == 1
            else normalised_innovation_squared(innovation[part], covariance[part, part])
            for name, part in zip(layout.names, layout.parts, strict=True)
        }
        odd = tuple(name for name, most in zip(layout.names, layout.gates, strict=True) if not nis[name] <= most)
        surprising = odd if self._agree(odd, nis) else ()
        refused = () if surprising else odd
        spread = np.sqrt(covariance.diagonal())
        whitened, shared = innovation / spread, expected.slopes[: self.measuring.considered] / spread
        for name, part in zip(layout.names, layout.parts, strict=True) if odd else ():
            whitened[part] *= name not in odd  # The gate has dealt with it.
        leans = monitor.lean(whitened, layout.places, shared)
        after = self._update(now, layout, expected, innovation, covariance, refused)
        suspects: tuple[str, ...] = ()
        if leans.max() > DRIFT_THRESHOLD:
            parts = zip(layout.names, layout.parts, strict=True)
            suspects = tuple(name for name, part in parts if leans[part].max() > DRIFT_THRESHOLD)
        return UpdateResult(after, nis, refused, suspects, surprising)

    def _agree(self, odd: tuple[str, ...], nis: Mapping[str, float]) -> bool:
        """Whether sensors of several kinds tell what was not expected: then it is the model that is wrong."""
        kinds = {getattr(self.sensors[name], "source", name) for name in odd}
        return len(kinds) > 1 and all(nis[name] <= GROSS_ERROR_NIS for name in odd)

    def _layout(self, names: tuple[str, ...]) -> NumberLayout:
        if names not in self._layouts:
            sensors = [self.sensors[name] for name in names]
            ends = np.cumsum([len(sensor.fields) for sensor in sensors]).tolist()
            parts = tuple(slice(a, b) for a, b in zip([0, *ends], ends, strict=False))
            places: Any = np.concatenate([self._places[name] for name in names])
            places = slice(None) if names == tuple(self.sensors) else places
            gates = tuple(gate(self.refusing, len(sensor.fields)) for sensor in sensors)
            sigma = np.concatenate([np.array(sensor.sigma, float) for sensor in sensors])
            angles = np.concatenate([np.array(sensor.angles, bool) for sensor in sensors])
            straight = all(sensor.straight for sensor in sensors)
            self._layouts[names] = NumberLayout(names, parts, places, gates, sigma, np.flatnonzero(angles), straight)
        return self._layouts[names]

    def _expected(self, now: Gaussian, layout: NumberLayout) -> Transformed:
        """What is measured by the sigma points; by the root itself where that is the same."""
        if layout.straight:
            points = np.concatenate([now.mean[None], now.root.T])
        else:
            points = sigma_points(now.mean, now.root, self.measuring)
        at = Columns(points, self.states, self.lanes.bend(float(now.mean[0])))
        values = np.empty((len(points), len(layout.sigma)))
        columns = (column for name in layout.names for column in self.sensors[name].measured(at))
        for number, column in enumerate(columns):
            values[:, number] = column
        return linear_transform(values) if layout.straight else unscented_transform(values, self.measuring)

    def _update(
        self, now: Gaussian, layout: NumberLayout, expected: Transformed, innovation: np.ndarray,
        covariance: np.ndarray, refused: tuple[str, ...],
    ) -> Gaussian:  # fmt: skip
        sigma = layout.sigma
        if refused:
            kept = np.ones(len(sigma), bool)
            for name, part in zip(layout.names, layout.parts, strict=True):
                kept[part] = name not in refused
            if not kept.any():
                return now
            expected = Transformed(*(part[..., kept] for part in expected))
            innovation, sigma, covariance = innovation[kept], sigma[kept], covariance[np.ix_(kept, kept)]
        return update(now, expected, innovation, covariance, sigma, self.measuring)

    def _innovation(
        self, layout: NumberLayout, readings: Mapping[str, Sequence[float]], expected: np.ndarray
    ) -> np.ndarray:
        numbers = [number for name in layout.names for number in self.sensors[name].numbers(readings[name])]
        innovation = np.array(numbers, float) - expected
        for angle in layout.angles:
            innovation[angle] = math.remainder(innovation[angle], 2.0 * math.pi)
        return np.asarray(innovation)


@lru_cache(maxsize=64)
def gate(probability: float, size: int) -> float:
    """Return the normalised innovation squared that a sound measurement exceeds with a probability [1]."""
    from scipy.stats import chi2

    return float(chi2.isf(probability, size)) if probability > 0.0 else float("inf")


def normalised_innovation_squared(innovation: np.ndarray, covariance: np.ndarray) -> float:
    """Return the innovation squared over its covariance [1]: chi-squared where the filter is consistent."""
    if len(innovation) == 1:
        return float(innovation[0] * innovation[0] / covariance[0, 0])
    if len(innovation) == 2:
        ((a, b), (_, d)), (e, f) = covariance.tolist(), innovation.tolist()
        return float((d * e * e - 2.0 * b * e * f + a * f * f) / (a * d - b * b))
    return float(innovation @ np.linalg.solve(covariance, innovation))
