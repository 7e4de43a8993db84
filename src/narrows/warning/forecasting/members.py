"""Members of an ensemble: the state and the coefficients drawn together, by the same numbers at every forecast."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from narrows.errors import InputError
from narrows.estimation.estimate import Estimate
from narrows.estimation.ship_filter import ShipFilter


class Drawn(NamedTuple):
    """Ships."""

    states: np.ndarray  # (ships, states) Of the estimate
    coefficients: np.ndarray  # (ships, coefficients) In the order of the model's table


@dataclass
class Members:
    """Ships that what is known leaves possible."""

    # What an estimate knows of how the state goes with the coefficients, the members keep. The numbers that they are
    # drawn by stay the same: from one forecast to the next only what is known changes.

    filter: ShipFilter  # Of the estimator
    count: int  # How many, an even number: half of them mirror the other half about the mean
    seed: int  # Of the numbers

    @cached_property
    def _normals(self) -> np.ndarray:
        size = len(self.filter.states) + self.filter.root.shape[1]
        half = np.random.default_rng(self.seed).standard_normal((self.count // 2, size))
        return np.concatenate([half, -half])

    def drawn(self, estimate: Estimate) -> Drawn:
        """Return the members."""
        return self._ships(estimate, self._normals)

    def likely(self, estimate: Estimate) -> Drawn:
        """Return the one ship of the mean."""
        return self._ships(estimate, np.zeros((1, self._normals.shape[1])))

    def _ships(self, estimate: Estimate, normals: np.ndarray) -> Drawn:
        joint, size = estimate.joint, len(self.filter.states)
        if joint is None:
            raise InputError("there is nothing known of this ship yet, so nothing can be foretold")
        points = joint.mean + normals[:, : joint.root.shape[1]] @ joint.root.T
        carried = normals[:, : self.filter.considered]
        directions = points[:, size:] if self.filter.estimated else carried
        return Drawn(points[:, :size], self._coefficients(directions))

    def _coefficients(self, directions: np.ndarray) -> np.ndarray:
        """Coefficients by the directions of their covariance, within the bounds of their terms."""
        model = self.filter.model
        middle = np.array([model.coefficients[name] for name in model.terms.names])
        low, high = np.array([term.bound for term in model.terms.terms]).T
        drawn = middle + directions @ self.filter.root[:, : directions.shape[1]].T
        return np.asarray(np.clip(drawn, np.minimum(low, middle), np.maximum(high, middle)))
