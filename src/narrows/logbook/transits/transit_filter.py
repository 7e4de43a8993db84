"""How much a transit tells of the coefficients: the exact linear system along it, and what its sensors leave open.

The motion about a transit is linear in what is small: offset, heading, drift and yaw rate off those that were planned,
gusts that come and go, the wind, zeros and wander of sensors, and the coefficients. Its matrices are exact derivatives,
and what sensors leave open of it is the covariance of a Kalman filter, which needs no readings. The rudder is an input
that is read with noise and a zero. A pilot's answers are in the rudder that is read, so that no pilot enters.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from narrows.codegen.free_motion import INPUTS
from narrows.codegen.linearisation import LINEARISED
from narrows.logbook.gaussian_update import NormalPrior
from narrows.logbook.sensor_grades import SensorGrade
from narrows.model.model import Model
from narrows.simulation.ship import SimulatedShip

FELT = ("y", "psi", "v", "r")
"""What moves about a planned transit; the speed is read and taken as it is."""
START = np.array([50.0, 0.1, 0.5, 3e-3])
"""Standard deviations of these where nothing was read yet [m, rad, m/s, rad/s]."""
SEEN = {"y": "y", "psi": "psi", "r": "r", "v": "v", "v_ground": "v"}
"""Signals that tell one of them."""
DRIVEN = (INPUTS["Y"], INPUTS["N"], "rudder")
SERIES = 12
"""Terms of the exponential of a step, which is short beside the ship's own time."""


@dataclass(frozen=True)
class TransitSystem:
    """The linear system along a transit, step by step.

    Parameters
    ----------
    transition : array (steps, 4, 4)
        Of ``FELT`` over a step.
    driven : array (steps, 4, 3)
        By sway force, yaw moment and rudder over a step.
    by_coefficients : array (steps, 4, coefficients)
        By each coefficient over a step.
    step : float [s]
        Its length.
    """

    transition: np.ndarray
    driven: np.ndarray
    by_coefficients: np.ndarray
    step: float

    @classmethod
    def along(
        cls, model: Model, values: Mapping[str, np.ndarray], at: Mapping[str, np.ndarray], step: float
    ) -> "TransitSystem":
        """Return the system along states at even times.

        Parameters
        ----------
        model : Model
            The ship.
        values : mapping of str to array (times,)
            Width and depth of the water [m] and heave [m] where they are not the model's own.
        at : mapping of str to array (times,)
            y from the middle of the section, psi, u, v, r, and positions of actuators.
        step : float [s]
            Between times.
        """
        ship = SimulatedShip(model)
        linear = ship.linearisation({**ship.values(), **values})
        rates, rows = linear.linear(at), [LINEARISED.index(name) for name in FELT]
        inputs = [len(LINEARISED) + linear.controlled.index(name) for name in DRIVEN]
        # Between two times, the mean of both.
        A, B, C = (_between(part) for part in (rates[:, rows][:, :, rows], rates[:, rows][:, :, inputs],
                                               linear.coefficients(at)[:, rows]))  # fmt: skip
        integral = _integral(A, step)
        return cls(np.eye(len(FELT)) + A @ integral, integral @ B, integral @ C, step)


def _between(columns: np.ndarray) -> np.ndarray:
    return np.asarray((columns[1:] + columns[:-1]) / 2)


def _integral(A: np.ndarray, step: float) -> np.ndarray:
    """The integral of the exponential of A over a step."""
    term = np.broadcast_to(step * np.eye(A.shape[1]), A.shape)
    total = term.copy()
    for order in range(2, SERIES):
        term = term @ A * (step / order)
        total = total + term
    return total


@dataclass(frozen=True)
class Unknowns:
    """Everything that a transit leaves open, each of size one before: motion, pushes, sensors' errors, coefficients.

    Parameters
    ----------
    gust : array (2, 2) [N, N m]
        Force and moment of two independent gusts of size one.
    wind : array (2,) [N, N m]
        Standard deviations of force and moment.
    gust_time : float [s]
        How long a gust stays.
    grade : SensorGrade
        Of the sensors, the rudder among them.
    prior : NormalPrior
        Of the coefficients.
    """

    gust: np.ndarray
    wind: np.ndarray
    gust_time: float
    grade: SensorGrade
    prior: NormalPrior

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that are used."""
        return tuple(name for name in self.grade.signals if name in SEEN)

    def information(self, system: TransitSystem) -> np.ndarray:
        """Return what one transit tells of the coefficients, in those of size one: (rank, rank) (ours).

        All else is unknown and the transit's own; of several transits it adds.

        Parameters
        ----------
        system : TransitSystem
            Along the transit.
        """
        first, size = len(FELT), self._size()
        seen, noise = self._seen(system.step)
        covariance, quiet = np.eye(size), self._forgotten(system.step)
        covariance[:first, :first] = np.diag(START**2)
        for transition, by_rudder in zip(self._transitions(system), system.driven[:, :, 2], strict=True):
            gain = np.linalg.solve(seen @ covariance @ seen.T + noise, seen @ covariance).T
            covariance = covariance - gain @ (seen @ covariance)
            covariance = transition @ covariance @ transition.T
            covariance[np.diag_indices(size)] += quiet
            covariance[:first, :first] += np.outer(by_rudder, by_rudder) * self._rudder_noise(system.step)
            covariance = (covariance + covariance.T) / 2
        rank = self.prior.root.shape[1]
        return np.asarray(np.linalg.inv(covariance[-rank:, -rank:]) - np.eye(rank))

    def _size(self) -> int:
        return len(FELT) + 2 + 2 + 1 + 2 * len(self.signals) + int(self.prior.root.shape[1])

    def _transitions(self, system: TransitSystem) -> np.ndarray:
        """Matrices of all over each step: motion, gusts, wind, zero of the rudder, wander, zeros, coefficients."""
        first, size = len(FELT), self._size()
        whole = np.broadcast_to(np.eye(size), (len(system.transition), size, size)).copy()
        whole[:, :first, :first] = system.transition
        whole[:, :first, first : first + 2] = system.driven[:, :, :2] @ self.gust
        whole[:, :first, first + 2 : first + 4] = system.driven[:, :, :2] * self.wind
        whole[:, :first, first + 4] = system.driven[:, :, 2] * self.grade.signals["rudder"].zero
        whole[:, :first, -self.prior.root.shape[1] :] = system.by_coefficients @ self.prior.root
        index = np.arange(size)
        whole[:, index, index] *= np.where(index < first, 1.0, self._kept(system.step))
        return whole

    def _kept(self, step: float) -> np.ndarray:
        """Of each unknown, what stays over a step."""
        memory = np.full(self._size(), np.inf)
        memory[len(FELT) : len(FELT) + 2] = self.gust_time
        wander = len(FELT) + 5
        memory[wander : wander + len(self.signals)] = [self.grade.signals[name].memory for name in self.signals]
        return np.asarray(np.exp(-step / memory))

    def _forgotten(self, step: float) -> np.ndarray:
        return np.asarray(1 - self._kept(step) ** 2)

    def _seen(self, step: float) -> tuple[np.ndarray, np.ndarray]:
        """What signals show of the unknowns, and the noise of as many readings as there are in a step."""
        seen, wander = np.zeros((len(self.signals), self._size())), len(FELT) + 5
        for row, name in enumerate(self.signals):
            grade = self.grade.signals[name]
            seen[row, FELT.index(SEEN[name])] = 1.0
            seen[row, wander + row] = grade.wander
            seen[row, wander + len(self.signals) + row] = grade.zero
        grades = [self.grade.signals[name] for name in self.signals]
        return seen, np.diag([grade.noise**2 * grade.period / step for grade in grades])

    def _rudder_noise(self, step: float) -> float:
        rudder = self.grade.signals["rudder"]
        return rudder.noise**2 * rudder.period / step
