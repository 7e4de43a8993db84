"""The estimator of many ships at once: what ``Estimator`` does one by one, in the form of covariances."""

from collections.abc import Mapping

import numpy as np

from narrows.estimation.estimator import Estimator
from narrows.estimation.filter_run import Start
from narrows.estimation.settings import GROSS_ERROR_NIS, START_READINGS
from narrows.estimation.ship_filter import sigma_point_weights
from narrows.estimation.states import Gaussian
from narrows.simulation.kernel_run import ShipLanes

REFUSED, TINY = 1e12, 1e-12
TURN = 2 * np.pi


class FiltersAbreast:
    """Filters of one kind; all sensors tell each second.

    Parameters
    ----------
    estimator : Estimator
        Whose filter it is, that corrects coefficients and whose sensors are linear in the state.
    count : int
        Ships.
    """

    def __init__(self, estimator: Estimator, count: int) -> None:
        self.filter, self.count = estimator.filter, count
        self.size = len(self.filter.states)
        self.whole = self.size + self.filter.estimated
        self.spread = sigma_point_weights(self.whole)
        lanes = count * (1 + 2 * self.whole)
        self.lanes = ShipLanes(self.filter.ship, self.filter.states.names, lanes, self.filter.waterway)
        self.left, noise = self.filter.disturbances.over(1.0)
        self.noise = noise.T @ noise
        layout = self.filter.layout(tuple(self.filter.sensors))
        assert layout.seen is not None
        self.seen, self.sigma, self.parts = layout.seen, layout.noise.diagonal(), tuple(layout.parts.values())
        self.gates = layout.tests[1]
        self.angles = layout.angles
        self.mean, self.covariance = np.zeros((count, self.whole)), np.zeros((count, self.whole, self.whole))

    def begin(self, readings: np.ndarray, ships: np.ndarray) -> None:
        """Begin anew, from readings (count, numbers), with the ships of these places."""
        for ship in ships:
            start = Start(self.filter)
            told = {
                name: tuple(readings[ship, part]) for name, part in zip(self.filter.sensors, self.parts, strict=True)
            }
            for _ in range(START_READINGS):
                start.add(0.0, told)
            first = start.state(0.0)
            self.mean[ship], self.covariance[ship] = first.mean, first.covariance

    @property
    def root(self) -> np.ndarray:
        """Of the covariances, (count, n, n)."""
        try:
            return np.linalg.cholesky(self.covariance)
        except np.linalg.LinAlgError:
            size = np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))
            return np.linalg.cholesky(self.covariance + 1e-9 * np.einsum("ij,jk->ijk", size**2, np.eye(self.whole)))

    def update(self, readings: np.ndarray, before: np.ndarray, after: np.ndarray) -> None:
        """Move a second on, the indicated rudders from one angle to another, and take readings (count, numbers)."""
        lost = self._moved(before, after)
        self._corrected(readings)
        lost |= ~np.isfinite(self.mean).all(axis=1) | ~np.isfinite(self.covariance).all(axis=(1, 2))
        self.begin(readings, np.flatnonzero(lost))

    def _moved(self, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        spread, pairs, count = self.spread, self.whole, self.count
        steps = self.root.transpose(0, 2, 1) * spread.distance
        middle = self.mean[:, None]
        points = np.concatenate([middle, middle + steps, middle - steps], axis=1)
        moved, lost = self._sailed(points.reshape(-1, self.whole), before, after)
        moved = moved.reshape(count, 1 + 2 * pairs, self.whole)
        first, ahead, behind = moved[:, 0], moved[:, 1 : pairs + 1], moved[:, pairs + 1 :]
        off = ahead + behind - 2.0 * first[:, None]
        total = off.sum(axis=1)
        slope = 0.5 / spread.distance
        slopes, bends = (ahead - behind) * slope, (off + spread.bend * total[:, None]) * slope
        self.mean = first + spread.mean * total
        self.covariance = slopes.transpose(0, 2, 1) @ slopes + bends.transpose(0, 2, 1) @ bends + self.noise
        return lost

    def _sailed(self, points: np.ndarray, before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        size, each = self.size, 1 + 2 * self.whole
        bank = points[:, self.filter.states.places["bank"]]
        columns = self.lanes.columns_of(self.filter.middle + points[:, size:] @ self.filter.root.T, bank)
        start, end = (np.repeat(angle, each)[:, None] for angle in (before, after))
        states = self.lanes.advance(points[:, :size], 1.0, start, end, columns)
        lost = self.lanes.aground.reshape(self.count, each)[:, 0]
        moved = np.concatenate([states, points[:, size:]], axis=1)
        return moved * self.left, lost.copy()

    def _corrected(self, readings: np.ndarray) -> None:
        innovation = readings - self.mean @ self.seen.T
        innovation[:, self.angles] = np.remainder(innovation[:, self.angles] + np.pi, TURN) - np.pi
        shared = self.covariance @ self.seen.T
        expected = self.seen @ shared + np.diag(self.sigma**2)
        noise = np.tile(self.sigma**2, (self.count, 1))
        squares = np.stack([_square(innovation[:, part], expected[:, part, part]) for part in self.parts])
        odd = ~(squares <= np.array(self.gates)[:, None])
        gross = (odd & ~(squares <= GROSS_ERROR_NIS)).any(axis=0)
        refused = odd & ((odd.sum(axis=0) < 2) | gross)  # All sensors of this filter are of different kinds.
        for part, without in zip(self.parts, refused, strict=True):
            noise[without, part] *= REFUSED
        covariance = self.seen @ shared + np.einsum("bi,ij->bij", noise, np.eye(len(self.sigma)))
        gain = np.linalg.solve(covariance, shared.transpose(0, 2, 1)).transpose(0, 2, 1)
        self.mean = self.mean + np.einsum("bni,bi->bn", gain, innovation)
        after = self.covariance - gain @ covariance @ gain.transpose(0, 2, 1)
        self.covariance = (after + after.transpose(0, 2, 1)) / 2

    def normal(self) -> Gaussian:
        """Means (count, n) and roots (count, n, n)."""
        return Gaussian(self.mean, self.root)


def _square(off: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Normalised innovations squared."""
    return np.einsum("bi,bi->b", off, np.linalg.solve(block, off[:, :, None])[:, :, 0])


class SensorErrors:
    """Errors of the sensors of many ships: white ones, and those that wander as their sensors declare."""

    def __init__(self, filters: FiltersAbreast, seed: int) -> None:
        self.filters, self.random = filters, np.random.default_rng(seed)
        self.known = filters.filter.errors
        self.states = {name: std * self._normal() for name, (_, std, _) in self.known.items()}

    def _normal(self) -> np.ndarray:
        return self.random.standard_normal(self.filters.count)

    def readings(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        """What the sensors tell of true states a second later, (count, numbers)."""
        for name, (_, std, time) in self.known.items():
            left = np.exp(-1.0 / time)
            self.states[name] = left * self.states[name] + np.sqrt(1.0 - left * left) * std * self._normal()
        at = {**true, **self.states}
        names = self.filters.filter.states.names
        rows = np.stack([at.get(name, np.zeros(self.filters.count)) for name in names], axis=1)
        told = rows @ self.filters.seen[:, : len(names)].T
        return told + self.filters.sigma * self.random.standard_normal(told.shape)
