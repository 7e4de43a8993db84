"""Members of an ensemble: the state and the coefficients drawn together, by the same numbers at every forecast."""

from dataclasses import dataclass, field

import numpy as np

from narrows.estimation.ship_filter import ShipFilter
from narrows.estimation.unscented import Normal


@dataclass
class Members:
    """Ships that what is known leaves possible (ours).

    A filter that carries the coefficients' errors has in its root how the state goes with them; the members keep that.
    The numbers that they are drawn by stay the same: from one forecast to the next only what is known changes.

    Parameters
    ----------
    filter : ShipFilter
        Of the estimator; it corrects no coefficients.
    count : int
        How many, an even number: half of them mirror the other half about the mean.
    seed : int
        Of the numbers.
    """

    filter: ShipFilter
    count: int
    seed: int
    coefficients: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        model, known = self.filter.model, self.filter.considered
        half = np.random.default_rng(self.seed).standard_normal((self.count // 2, known + len(self.filter.states)))
        self._normals = np.concatenate([half, -half])
        middle = np.array([model.coefficients[name] for name in model.terms.names])
        low, high = np.array([term.bound for term in model.terms.terms]).T
        drawn = middle + self._normals[:, :known] @ self.filter.root[:, :known].T
        self.coefficients = np.clip(drawn, np.minimum(low, middle), np.maximum(high, middle))

    def states(self, normal: Normal) -> np.ndarray:
        """Return the states of the members, (count, states).

        Parameters
        ----------
        normal : Normal
            What is known now.
        """
        root = normal.root
        return np.asarray(normal.mean + self._normals[:, -root.shape[1] :] @ root.T)
